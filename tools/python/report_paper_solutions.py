"""The paper's Figures 4.1 to 4.5, and what (4.6) sees: solutions on the two surfaces."""

import numpy as np
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize

import view as space
from paper_exponents import DISTANCE, exact_and_measured, of_the_paper
from paper_mesh import SUBS, place
from paper_runs import Runs
from paper_tables import EMISSION_S2, PAPER, RHO_S2
from report_paper_figures import BLACK, BLUE, GREEN, ORANGE, RED, SKY, axes

SIDE = 32  # parts of a side of a sub-triangle in a coloured surface
STEP = 0.01  # of the difference quotient, in t


def surface(panel, triangles: np.ndarray, value, eye: tuple, scale: ScalarMappable) -> None:
    """Triangles, none of which hides another, coloured by value(triangle, sub, phi, r)."""
    s = np.linspace(0, 1, SIDE + 1)
    phi, r = (x.ravel() for x in np.meshgrid(s, s))
    number = np.arange((SIDE + 1) ** 2).reshape(SIDE + 1, -1)
    a, b, c, d = (x.ravel() for x in (number[:-1, :-1], number[:-1, 1:], number[1:, 1:], number[1:, :-1]))
    parts = np.concatenate([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)])
    view = space.View(np.array(eye, float), np.zeros(3))
    for t, triangle in enumerate(triangles):
        for sub in range(len(SUBS)):
            flat = view.project(place(triangle, sub, phi, r))[0]
            look = {"shading": "gouraud", "cmap": scale.cmap, "norm": scale.norm, "rasterized": True}
            panel.tripcolor(*flat.T, parts, value(t, sub, phi, r), **look)
        panel.plot(*view.project(triangle[[0, 1, 2, 0]])[0].T, color="0.15", lw=0.9)
    space.frame(panel, view.project(triangles.reshape(-1, 3))[0])
    label_corners(panel, view, triangles)


def label_corners(panel, view: space.View, triangles: np.ndarray) -> None:
    """Coordinates beside the outer vertices; the inner one is the origin."""
    middle = view.project(triangles.mean(axis=(0, 1)))[0]
    for v in {tuple(v) for v in triangles.reshape(-1, 3) if v.any()}:
        flat = view.project(np.array(v))[0]
        out = (flat - middle) / np.linalg.norm(flat - middle)
        text = f"({', '.join(f'{x:g}' for x in v)})"
        centred = {"textcoords": "offset points", "ha": "center", "va": "center", "fontsize": 8}
        panel.annotate(text, flat, 11 * out * (2, 1), **centred)
    low, high = np.array([panel.get_xlim(), panel.get_ylim()]).T
    margin = 0.1 * (high - low)
    panel.set(xlim=(low[0] - margin[0], high[0] + margin[0]), ylim=(low[1] - margin[1], high[1] + margin[1]))


def coloured(triangles: np.ndarray, values: list, titles: list[str], eye: tuple, labels: list[str]):
    """Panels of surfaces, each with its bar."""
    figure, panels = space.plt.subplots(
        1, len(values), figsize=(5.2 * len(values), 4.0), layout="constrained", squeeze=False
    )
    grid = np.meshgrid(np.linspace(0, 1, 9), np.linspace(0, 1, 9))
    for panel, value, title, label in zip(panels[0], values, titles, labels, strict=True):
        seen = [value(t, s, *grid) for t in range(len(triangles)) for s in range(len(SUBS))]
        scale = ScalarMappable(Normalize(np.min(seen), np.max(seen)), "ember")
        surface(panel, triangles, value, eye, scale)
        panel.set_title(title, fontsize=10, pad=10)
        bar = figure.colorbar(scale, ax=panel, shrink=0.75, aspect=26, pad=0.03)
        bar.set_label(label)
        bar.outline.set_linewidth(0.5)
    return figure


def figure_4_1(runs: Runs, _full: bool):
    solution = runs.solution("cube_corner_p1.yml", 8, 1)
    return coloured(solution.triangles, [solution.at], ["N = 8, p = 1"], (5, 5, 5), ["u  [W/m²]"])


def figure_4_5(runs: Runs, _full: bool):
    as_printed = runs.solution("wedge_p1.yml", 8, 1)
    settings = [
        part
        for i, (rho, e) in enumerate(zip(RHO_S2, EMISSION_S2, strict=True))
        for part in ("--set", f"scene.triangles.{i}.emission={rho * e:g}")
    ]
    source = runs.solution("wedge_p1.yml", 8, 1, "source", settings)
    values = [as_printed.at, lambda t, s, phi, r: source.at(t, s, phi, r) / RHO_S2[t]]
    titles = ["u = E + ρ K u, equation (1.1)", "v = E + K(ρ v), as in Table 4.6"]
    labels = ["u  [W/m²]", "v  [W/m²]"]
    return coloured(as_printed.triangles, values, titles, (5, 5, 2), labels)


def arc(r: float, t: np.ndarray) -> np.ndarray:
    """(4.7)."""
    return r * np.stack([np.cos(np.pi / 2 * t), np.sin(np.pi / 2 * t), 0 * t], axis=-1)


def exact_on_arcs(runs: Runs, radii: list[float], t: np.ndarray) -> np.ndarray:
    """u on the arcs [radius, t], from an adaptive run."""
    points = np.concatenate([arc(r, t) for r in radii])
    probes = [f"{{surface: floor, at: [{', '.join(f'{x:.17g}' for x in p)}]}}" for p in points]
    settings = ["method={}", "accuracy.tolerance=1e-7", "output.sampling=1", f"probes=[{', '.join(probes)}]"]
    given = [part for setting in settings for part in ("--set", setting)]
    name = f"arcs_{len(radii)}_{len(t)}"
    result = runs.result(runs.deck("cube_corner_p1.yml"), name, given)
    return result.array("polyrad/probes/radiosity").reshape(len(radii), len(t))


def figure_4_2(runs: Runs, full: bool):
    n, radii = (32 if full else 16), [0.001, 0.01, 0.05, 0.1]
    solution = runs.solution("cube_corner_p1.yml", n, 1)
    t, few = np.linspace(0, 1, 1001), np.linspace(0, 1, 81)[1:-1]
    exact = exact_on_arcs(runs, radii, few)
    figure, panel = axes(6.2, 4.0)
    styles = zip(radii, exact, (BLACK, BLUE, GREEN, RED), ("-", "--", "-.", ":"), strict=True)
    for r, u, color, style in styles:
        panel.plot(t, solution.at_points(0, arc(r, t)), style, color=color, lw=1.7, label=f"r = {r:g}")
        panel.plot(few, u, color=color, lw=0.7, alpha=0.6)
    panel.plot([], [], color="0.4", lw=0.7, label="thin: exact")
    panel.set(xlim=(0, 1), xlabel="t", ylabel=f"ū(αᵣ(t)),  N = {n}  [W/m²]")
    panel.legend(frameon=False, fontsize=9, ncols=1, loc="lower right")
    return figure


def slopes(runs: Runs, deck: str, p: int, numbers: list[int]):
    """Difference quotients with step 0.01 along the arc r = 0.01."""
    t = np.linspace(0, 1, 101)
    middle = (t[1:] + t[:-1]) / 2
    figure, panel = axes(6.2, 4.0)
    inside = t.clip(1e-9, 1 - 1e-9)
    exact = np.diff(exact_on_arcs(runs, [0.01], inside)[0]) / STEP
    panel.plot(middle, exact, color=BLACK, lw=3.2, alpha=0.22, label="exact")
    styles = zip(numbers, (ORANGE, SKY, BLUE), (":", "--", "-"), (1.6, 1.5, 1.3), strict=True)
    for n, color, style, width in styles:
        u = runs.solution(deck, n, p).at_points(0, arc(0.01, t))
        panel.plot(middle, np.diff(u) / STEP, style, color=color, lw=width, label=f"N = {n}")
    panel.set(xlim=(0, 1), xlabel="t", ylabel="dū(αᵣ(t))/dt,  r = 0.01, step 0.01  [W/m²]")
    panel.legend(frameon=False, fontsize=9)
    return figure


def figure_4_3(runs: Runs, full: bool):
    return slopes(runs, "cube_corner_p1.yml", 1, [8, 16, 32] if full else [4, 8, 16])


def figure_4_4(runs: Runs, full: bool):
    return slopes(runs, "cube_corner_p2.yml", 2, [4, 8, 16] if full else [2, 4, 8])


def figure_exponents(runs: Runs, full: bool):
    """Local exponents against the distance."""
    n = 32 if full else 16
    edge, vertex, local = exact_and_measured(runs, "cube_corner_p1.yml")
    solution, h = runs.solution("cube_corner_p1.yml", n, 1), DISTANCE[:-2]
    figure, panels = axes(8.6, 3.7, 2)
    cases = [
        (panels[0], "β₁, across the edge", edge[0, 0], local[:2], ("r = 1", "r = 1/64"), 0),
        (panels[1], "β₂, towards the vertex", vertex[0, 0], local[2:], ("t = 1/4", "t = 1/2"), 1),
    ]
    paper = (PAPER["(4.6)"]["beta_1"], PAPER["(4.6)"]["beta_2"])
    for panel, title, exact, curves, names, k in cases:
        panel.axhline(exact, color=BLACK, lw=1, ls="--", label=f"exact {exact:.4f}")
        for curve, name, color in zip(curves, names, (BLUE, GREEN), strict=True):
            panel.semilogx(h / 4, curve, color=color, lw=1.6, label=f"solution, {name}")
        panel.plot(1 / n, of_the_paper(solution, n)[k], "s", color=ORANGE, mec=BLACK, ms=6, label=f"P1, N = {n}")
        panel.plot(1 / 32, paper[k], "x", color=RED, ms=8, mew=2, label="paper, (4.6)")
        panel.set(ylim=(0.65, 0.95), xlabel="smallest distance h", title=title)
        panel.legend(frameon=False, fontsize=8.5, loc="upper left")
    panels[0].set_ylabel("local exponent")
    return figure
