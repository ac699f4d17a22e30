"""Work and precision: true errors in the maximum norm against time, unknowns and bytes, one curve a
method, and the cheapest method for each accuracy."""

import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np

import view
from report_context import Context, Section, grid, image, provenance
from result import Result, names_in
from study_table import table

SCENES = {
    "corner": "S1, corner of a cube",
    "wedge": "S2, wedge of 45 degrees",
    "cube": "closed cube",
    "blocker": "plates with a blocker",
    "cornell": "Cornell box",
}
LARGEST = {"corner": 1.30, "wedge": 1.79, "cube": 1.20, "blocker": 1.04, "cornell": 17.2}  # radiosity [W/m2]
WORK = {"seconds_total": "time of a run [s]", "unknowns": "unknowns", "matrix_bytes": "bytes of the matrix"}
# Tolerances of the adaptive runs; the last one with --full only, and then a smaller one of the reference.
TOLERANCES = {
    "corner": ([1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8], 1e-10),
    "wedge": ([1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7], 1e-8),
    "cube": ([1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6], 1e-7),
    "blocker": ([1e-2, 1e-3, 1e-4, 1e-5], 1e-6),
    "cornell": ([1e-1, 3e-2, 1e-2, 3e-3], 3e-4),
}


@dataclass
class Curve:
    """Runs of one method, by work."""

    name: str
    error: np.ndarray
    work: dict[str, np.ndarray]


def words_of(method: str) -> dict[str, str]:
    """A mapping of a deck, {mesh: paper, elements: 2}, as texts."""
    return dict(re.findall(r"(\w+): *([^,{}]+)", method))


def name_of(method: str) -> str:
    """The curve of a run: all of the method but N."""
    key = words_of(method)
    degree = int(key.get("degree", 1))
    if key["mesh"] == "uniform":
        return "uniform, " + ("constants" if degree == 0 else "linear")
    if key["mesh"] == "graded":
        return f"graded, degree {degree}"
    if degree == 0:
        return "P0, paper"
    duffy = ", duffy" if key.get("angle") == "duffy" else ""
    return f"P1, p = {key.get('grading', '1')}{duffy}"


def curves_of(result: Result, tail: str, names: list[str]) -> list[Curve]:
    columns = table(result)
    keep = np.isfinite(columns["error"]) & (columns["error"] > 0)
    found = []
    for name in dict.fromkeys(names):
        row = np.array([i for i, n in enumerate(names) if n == name and keep[i]], int)
        if len(row):
            work = {key: np.asarray(columns[key], float)[row] for key in WORK}
            found.append(Curve(name + tail, columns["error"][row], work))
    return found


def cheapest(curves: list[Curve], work: str, floor=0.0) -> list[tuple[float, str, float]]:
    """For each decade of the error, down to what the reference can tell: the method that reaches it with
    the least work, and that work."""
    smallest = max(floor, min(curve.error.min() for curve in curves))
    found = []
    for decade in range(-1, -16, -1):
        if 10.0**decade < smallest:
            break
        best = min(
            (
                (float(curve.work[work][curve.error <= 10.0**decade].min()), curve.name)
                for curve in curves
                if (curve.error <= 10.0**decade).any()
            ),
        )
        found.append((10.0**decade, best[1], best[0]))
    return found


def style(name: str) -> dict:
    """Colour by kind of method, marker by what is varied in it; u* is filled, u_h hollow."""
    kind = name.split(",")[0]
    kinds = {"uniform": "0.55", "P0": "tab:brown", "P1": "tab:blue", "graded": "tab:green", "adaptive": "tab:red"}
    number = re.search(r"p = (\d)|degree (\d)", name)
    which = int(number[1] or number[2]) if number else 0
    marker = "d" if "duffy" in name else {0: "o", 1: "o", 2: "s", 3: "^", 5: "v", 7: "D", 9: "P"}[which]
    return {
        "color": kinds[kind],
        "marker": marker,
        "ms": 6 if kind == "adaptive" else 4,
        "lw": 2.2 if kind == "adaptive" else 1,
        "ls": "-" if name.endswith("u*") else ":",
        "mfc": None if name.endswith("u*") else "white",
    }


def chart(title: str, curves: list[Curve], floor: float, path: Path) -> None:
    """Three panels; the work grows to the right, and what lies below and left of others is better."""
    figure, panels = view.plt.subplots(1, 3, figsize=(14, 5.2), sharey=True, layout="constrained")
    for panel, (work, label) in zip(panels, WORK.items(), strict=True):
        for curve in curves:
            panel.loglog(curve.work[work], curve.error, label=curve.name, **style(curve.name))
        panel.axhline(floor, color="0.7", lw=0.8, ls="--")
        panel.set_xlabel(label)
        panel.grid(color="0.9", lw=0.6)
        panel.spines[["top", "right"]].set_visible(False)
    best = cheapest(curves, "seconds_total", floor)
    for error, _, seconds in best:
        panels[0].plot(seconds, error, marker="o", ms=11, mfc="none", mec="black", mew=1.2, ls="none")
    panels[0].set_ylabel("largest error  [W/m²]")
    handles, labels = panels[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside right upper", frameon=False, fontsize=8)
    figure.suptitle(title)
    view.save_svg(figure, path)


def runs_of(ctx: Context, scene: str) -> tuple[list[Curve], float, Result]:
    """All curves of a scene, the bound of its reference, and one of its studies."""
    deck = ctx.root / f"inputs/studies/work/{scene}.yml"
    tolerances, reference = TOLERANCES[scene]
    more = [f"study.reference.tolerance={reference:g}"] if ctx.full else []
    adaptive = "study.vary={accuracy.tolerance: %s}" % tolerances[: None if ctx.full else -1]
    tail = "_full" if ctx.full else ""
    curves: list[Curve] = []
    for values, mark in (("solution", ", u_h"), ("reported", ", u*")):
        settings = [f"study.values={values}", *more]
        study = ctx.study("work", deck, f"{scene}_{values}{tail}", settings)
        names = [name_of(method) for method in names_in(table(study)["method"])]
        curves += curves_of(study, mark, names)
        study = ctx.study("work", deck, f"{scene}_adaptive_{values}{tail}", [*settings, adaptive])
        curves += curves_of(study, mark, ["adaptive"] * len(table(study)["error"]))
    tolerance = reference if ctx.full else tolerance_of_reference(deck)
    return curves, tolerance * LARGEST[scene], study


def tolerance_of_reference(deck: Path) -> float:
    return float(re.search(r"reference: \{tolerance: ([\d.e-]+)\}", deck.read_text())[1])


def scene_part(ctx: Context, scene: str) -> tuple[str, Path]:
    curves, floor, study = runs_of(ctx, scene)
    path = ctx.folder / "work" / f"work_{scene}.svg"
    path.parent.mkdir(parents=True, exist_ok=True)
    chart(f"{SCENES[scene]}: error against work", curves, floor, path)
    caption = (
        f"{SCENES[scene]}. Solid: u*, dotted: u_h. Rings: the cheapest in time for each decade. Dashed: what the "
        "reference may be off. Times are medians of three runs, from the deck to the solution (without "
        f"evaluating it at points): {provenance(study)}."
    )
    rows = []
    by_bytes = dict((e, (n, w)) for e, n, w in cheapest(curves, "matrix_bytes", floor))
    for error, name, seconds in cheapest(curves, "seconds_total", floor):
        other, size = by_bytes[error]
        rows.append([f"{error:.0e}", name, f"{seconds:.3g}", other, f"{size / 1e6:.3g}"])
    head = ["error [W/m²]", "cheapest in time", "s", "cheapest in memory", "MB"]
    return f"<h3>{SCENES[scene]}</h3>\n{image(path, caption)}\n{grid(head, rows)}", path


def section(ctx: Context) -> Section:
    parts = [scene_part(ctx, scene) for scene in SCENES]
    return Section("Speed against accuracy", "\n".join(text for text, _ in parts), [path for _, path in parts])
