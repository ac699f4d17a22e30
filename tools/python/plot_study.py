"""Columns of one or more studies (polyrad study) against another: by default the error against
unknowns and against time, log-log."""

from pathlib import Path

import numpy as np

import view as space
from result import Problem, Result, names_in, parser, run, save
from study_table import table

MARKERS = "osD^vP*X"


def curves(columns: dict[str, np.ndarray], x: str) -> dict[str, np.ndarray]:
    """Rows by curve: where several keys vary, one curve for all but x, or the one with most values."""
    keys = {name: column for name, column in columns.items() if "." in name}
    text = {
        name: names_in(column) if column.dtype.kind in "OS" else [f"{value:g}" for value in column]
        for name, column in keys.items()
    }
    text = {name: column for name, column in text.items() if len(set(column)) > 1}
    most = max(text, key=lambda name: len(set(text[name])), default=None)
    along = x if x in text else most
    rows: dict[str, list[int]] = {}
    for row in range(len(columns["error"])):
        parts = [f"{n.split('.')[-1]} {text[n][row]}" for n in text if n != along]
        rows.setdefault(", ".join(parts), []).append(row)
    return {label: np.array(row) for label, row in rows.items()}


LABELS = {
    "error": "largest error  [W/m²]",
    "error_mean_square": "mean square of the error  [W/m²]",
    "error_bound": "bound of the error  [W/m²]",
    "seconds_total": "time of a run [s]",
    "inverse_norm": "norm of the inverse, E to u_h",
    "inverse_matrix": "norm of the inverse matrix",
    "spectral_radius": "spectral radius",
}


def numbers(column: np.ndarray) -> np.ndarray | None:
    """A column as numbers, or None where it holds names."""
    if column.dtype.kind not in "OS":
        return np.asarray(column, float)
    try:
        return np.array([float(value) for value in names_in(column)])
    except ValueError:
        return None


def draw(panel, x: np.ndarray, y: np.ndarray, row: np.ndarray, label: str, style: dict) -> None:
    """One curve; names stand side by side."""
    values, at = numbers(x), np.asarray(y, float)
    keep = row[np.isfinite(at[row]) & (at[row] > 0)]
    if values is not None:
        panel.plot(values[keep], at[keep], label=label, **style)
        return
    names = list(dict.fromkeys(Path(name).stem for name in names_in(x)))
    place = np.array([names.index(Path(name).stem) for name in names_in(x)])
    panel.plot(place[keep], at[keep], label=label, **style)
    panel.set_xticks(range(len(names)), names, rotation=60, ha="right", fontsize=8)


def scale(panel, x: str, columns: list[dict[str, np.ndarray]]) -> None:
    """Logarithmic where numbers span more than a decade."""
    panel.set_yscale("log")
    found = [numbers(c[x]) for c in columns if x in c]
    if all(v is not None and np.nanmin(v) > 0 and np.nanmax(v) >= 10 * np.nanmin(v) for v in found):
        panel.set_xscale("log")


def main() -> None:
    options = parser(__doc__, "FILE...")
    options.add_argument(
        "--labels", nargs="+", metavar="TEXT", help="one a file; default: its title"
    )
    options.add_argument("--x", metavar="COLUMN", help="against it; default: unknowns, and time")
    options.add_argument(
        "--y", metavar="COLUMN", action="append", help="a panel each; default: error"
    )
    options = options.parse_args()
    if options.labels and len(options.labels) != len(options.file):
        raise Problem(f"{len(options.file)} files, but {len(options.labels)} labels", 2)

    results = [Result(path) for path in options.file]
    tables = [table(result) for result in results]
    ys = options.y or ["error"]
    pairs = [(x, y) for y in ys for x in ([options.x] if options.x else ["unknowns", "seconds_total"])]
    for name in {name for pair in pairs for name in pair} - {"seconds_total"}:
        for result, columns in zip(results, tables, strict=True):
            if name not in columns:
                raise Problem(f"the study in {result.path} has no column '{name}'", 2)
    figure, panels = space.plt.subplots(
        1, len(pairs), figsize=(4.8 * len(pairs), 4.4), sharey=len(ys) == 1, layout="constrained",
        squeeze=False,
    )
    panels, drawn = panels[0], 0
    for i, columns in enumerate(tables):
        name = options.labels[i] if options.labels else results[i].title
        for label, row in curves(columns, pairs[0][0]).items():
            full = ", ".join(part for part in (name if len(results) > 1 else "", label) if part)
            style = {
                "marker": MARKERS[drawn % len(MARKERS)],
                "color": f"C{drawn % 10}",
                "ms": 5,
                "lw": 1.4,
            }
            for panel, (x, y) in zip(panels, pairs, strict=True):
                if x in columns:
                    draw(panel, columns[x], columns[y], row, full, style)
            drawn += any(len(line.get_xdata()) for line in panels[0].lines)
    if not any(len(line.get_xdata()) for panel in panels for line in panel.lines):
        raise Problem(f"no run of these studies has a value of '{ys[0]}' above zero")

    for panel, (x, y) in zip(panels, pairs, strict=True):
        scale(panel, x, tables)
        panel.set_xlabel(LABELS.get(x, x.split(".", 1)[-1] if x != "scene.mesh.file" else ""))
        panel.set_ylabel(LABELS.get(y, y.replace("_", " ")))
        panel.grid(which="major", color="0.85", lw=0.7)
        panel.grid(which="minor", color="0.94", lw=0.4)
        panel.set_axisbelow(True)
        panel.spines[["top", "right"]].set_visible(False)
    if any(panels[0].get_legend_handles_labels()[1]):
        panels[0].legend(frameon=False, fontsize=8 if drawn > 8 else 9)
    default = results[0].title if len(results) == 1 else "Convergence"
    figure.suptitle(options.title or default)
    save(figure, options.output or str(Path(options.file[0]).with_suffix(".png")), options.file[0])


run(main)
