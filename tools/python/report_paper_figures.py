"""The paper's computed figures, drawn anew: same axes and curves, what is exact added to them."""

import numpy as np

import view as space
from paper_mesh import SUBS, collocation, place, rectangles
from paper_runs import Runs

# Of Okabe and Ito: told apart by colour-blind readers, and by their lightness.
BLACK, BLUE, ORANGE, GREEN, SKY, RED = "#000000", "#0072B2", "#E69F00", "#009E73", "#56B4E9", "#D55E00"
LINE = {"color": "0.25", "lw": 0.7}
REFERENCE = np.array([[0, 0], [1, 0], [0.5, np.sqrt(3) / 2]])  # the triangle of Figure 3.1
S1 = np.array(
    [
        [[0, 0, 0], [1, 0, 0], [0, 1, 0]],
        [[0, 0, 0], [0, 1, 0], [0, 0, 1]],
        [[0, 0, 0], [0, 0, 1], [1, 0, 0]],
    ],
    float,
)


def axes(width: float = 5.4, height: float = 3.6, panels: int = 1):
    figure, found = space.plt.subplots(1, panels, figsize=(width, height), layout="constrained", squeeze=False)
    for panel in found[0]:
        panel.grid(color="0.9", lw=0.7)
        panel.set_axisbelow(True)
        panel.spines[["top", "right"]].set_visible(False)
    return figure, found[0] if panels > 1 else found[0, 0]


def bare(width: float = 5.0, height: float = 4.6):
    figure, panel = space.plt.subplots(figsize=(width, height), layout="constrained")
    panel.set_aspect("equal")
    panel.axis("off")
    return figure, panel


# --- Figures 2.2 and 2.3: what a sector gives to a plane through its peak ---


def sigma(beta: np.ndarray, low: float, high: float) -> np.ndarray:
    """sigma of the sector LOW..HIGH of the plane z = 0 at (cos beta, 0, sin beta), normal (0, 1, 0): the
    integral over angles in the proof of Lemma 2.7 with u = 1."""
    x, w = np.polynomial.legendre.leggauss(200)
    alpha = low + (high - low) * (x + 1) / 2
    weight = (high - low) / 2 * w * np.sin(alpha)  # a = n2 . y
    c = np.cos(alpha) * np.cos(beta)[:, None]
    s2 = 1 - c**2
    radial = 2 * c / s2 + (np.pi + 2 * np.arctan(c / np.sqrt(s2))) / s2**1.5
    return np.sin(beta) / (4 * np.pi) * (radial @ weight)


def sector_probes(runs: Runs, name: str, low: float, high: float, beta: np.ndarray) -> np.ndarray:
    """The same by polyrad: irradiance from a triangle of emission 1, cut off at 1e6 from its peak."""
    far = 1e6 * np.array([[np.cos(a), np.sin(a), 0] for a in (low, high)])
    probes = [f"{{surface: wall, at: [{np.cos(b):.17g}, 0, {np.sin(b):.17g}]}}" for b in beta]
    deck = runs.folder / f"{name}.yml"
    ends = [f"[{', '.join(f'{x:.17g}' for x in end)}]" for end in far]
    deck.write_text(
        "scene:\n  triangles:\n"
        f"    - {{name: sector, vertices: [[0,0,0], {ends[0]}, {ends[1]}], normal: [0, 0, 1], rho: 0, emission: 1}}\n"
        "    - {name: wall, vertices: [[0,0,0], [0,0,3], [3,0,0]], normal: [0, 1, 0], rho: 0, emission: 0}\n"
        "    - {name: wall, vertices: [[0,0,0], [-3,0,0], [0,0,3]], normal: [0, 1, 0], rho: 0, emission: 0}\n"
        "method: {mesh: graded, elements: 1, degree: 2, quadrature_tolerance: 1e-9}\n"
        f"probes: [{', '.join(probes)}]\n"
    )
    return runs.result(deck, name, []).array("polyrad/probes/irradiance").ravel()


def figure_2_2(runs: Runs, _full: bool):
    figure, (left, right) = axes(8.6, 3.4, 2)
    sets = ((left, "2.2", np.pi / 3, 3 * np.pi / 4, np.pi, "β"), (right, "2.3", 0, np.pi / 2, np.pi / 2, "φ"))
    for panel, number, low, high, end, angle in sets:
        beta = np.linspace(2e-3, end - 2e-3, 400)
        at = np.linspace(0, end, 16)[1:-1]
        panel.plot(beta, sigma(beta, low, high), color=BLUE, lw=1.6, label="integral of Lemma 2.7")
        given = sector_probes(runs, f"figure_{number.replace('.', '_')}", low, high, at)
        off = np.abs(given - sigma(at, low, high)).max()
        panel.plot(at, given, "o", color=ORANGE, ms=4.5, mec=BLACK, mew=0.5, label=f"polyrad (off by {off:.0e})")
        ticks = np.linspace(0, end, 5)
        names = ["0", "π/4", "π/2", "3π/4", "π"] if end > 2 else ["0", "π/8", "π/4", "3π/8", "π/2"]
        panel.set_xticks(ticks, names)
        panel.set(xlim=(0, end), ylim=(0, None), xlabel=angle, title=f"Figure {number}")
        panel.legend(frameon=False, fontsize=8.5, loc="lower center")
    left.set_ylabel("σ  of the sector α = π/3 .. 3π/4")
    right.set_ylabel("(K 1)(cos φ, 0, sin φ)")
    return figure


# --- Figures 3.4 to 3.8: meshes and collocation points ---


def border(box: np.ndarray) -> np.ndarray:
    """(phi, r) of the corners of every rectangle [m, 5, 2]; the sides are straight in space as well."""
    round_it = np.array([[0, 0], [1, 0], [1, 1], [0, 1], [0, 0]])
    return box[:, None, :, 0] + (box[:, :, 1] - box[:, :, 0])[:, None] * round_it


def partition(triangle: np.ndarray, box: np.ndarray) -> np.ndarray:
    """Borders of all rectangles in the six sub-triangles [6 m, 5, 2 or 3]."""
    around = border(box)
    return np.concatenate([place(triangle, s, around[..., 0], around[..., 1]) for s in range(len(SUBS))])


def figure_3_4(_runs: Runs, _full: bool):
    figure, panel = space.plt.subplots(figsize=(5.0, 4.8), layout="constrained")
    box, layer = rectangles(3, 2)
    shades = ("#9ecae9", "#cfe3f3", "#f3f7fb")
    for k, (limits, i) in enumerate(zip(box, layer, strict=True), 1):
        low, width = limits[:, 0], limits[:, 1] - limits[:, 0]
        panel.add_patch(space.plt.Rectangle(low, *width, facecolor=shades[i], edgecolor="0.25", lw=0.8))
        size = 7 if width.min() < 0.2 else 10
        panel.text(*(low + width / 2), str(k), ha="center", va="center", fontsize=size)
    ticks = [0, 1 / 9, 4 / 9, 1]
    panel.set_xticks(ticks, ["0", "1/9", "4/9", "1"])
    panel.set_yticks(ticks, ["0", "1/9", "4/9", "1"])
    panel.set(xlim=(0, 1), ylim=(0, 1), xlabel="φ", ylabel="r", aspect="equal")
    return figure


def figure_3_5(_runs: Runs, _full: bool):
    figure, panel = bare(5.2, 4.6)
    for line in partition(REFERENCE, rectangles(3, 2)[0]):
        panel.plot(*line.T, **LINE)
    for s in range(len(SUBS)):
        panel.plot(*place(REFERENCE, s, np.array([0, 1, 0, 0]), np.array([0, 1, 1, 0])).T, color=BLUE, lw=1.6)
    for v, name in zip(REFERENCE, ("(0, 0)", "(1, 0)", "(1/2, √3/2)"), strict=True):
        away = 30 * (v - REFERENCE.mean(axis=0))
        panel.annotate(name, v, away * (0.6, 0.8), textcoords="offset points", ha="center", va="center")
    return figure


def drawn_s1(lines: list[np.ndarray], dots: list[tuple[np.ndarray, dict]]):
    """S1 from (5, 5, 5): lines [.., n, 3], and dots [n, 3] with their styles."""
    figure, panel = bare(5.6, 5.0)
    eye = space.View(np.array([5.0, 5.0, 5.0]), np.full(3, 0.3))
    for line in lines:
        panel.plot(*eye.project(line)[0].T, **LINE)
    for triangle in S1:
        panel.plot(*eye.project(triangle[[0, 1, 2, 0]])[0].T, color=BLACK, lw=1.5)
    for at, style in dots:
        panel.plot(*eye.project(at)[0].T, linestyle="none", **style)
    for axis, name in zip(np.eye(3), "xyz", strict=True):
        panel.text(*eye.project(1.06 * axis)[0], name, ha="center", va="center", style="italic")
    return figure


def figure_3_6(_runs: Runs, _full: bool):
    return drawn_s1([line for t in S1 for line in partition(t, rectangles(2, 2)[0])], [])


def figure_3_7(runs: Runs, _full: bool):
    points = runs.solution("cube_corner_p2.yml", 2, 2).points
    lines = [line for t in S1 for line in partition(t, rectangles(2, 2)[0])]
    figure = drawn_s1(lines, [(points, {"marker": "o", "ms": 2.6, "color": BLUE, "mew": 0})])
    figure.suptitle(f"{len(points)} points", fontsize=10)
    return figure


def figure_3_8(_runs: Runs, _full: bool):
    box, layer = rectangles(2, 2)
    phi, r = collocation(box)
    middle = box.mean(axis=2)
    constant = layer == 0
    four, one = [], []
    for t in S1:
        for s in range(len(SUBS)):
            four.append(place(t, s, phi[~constant].ravel(), r[~constant].ravel()))
            one.append(place(t, s, *middle[constant].T))
    four, one = np.concatenate(four), np.concatenate(one)
    lines = [line for t in S1 for line in partition(t, box)]
    dots = [(four, {"marker": "o", "ms": 2.6, "color": BLUE, "mew": 0})]
    dots += [(one, {"marker": "D", "ms": 3.4, "color": RED, "mew": 0})]
    figure = drawn_s1(lines, dots)
    figure.suptitle(f"{len(four)} points of P1 (dots), {len(one)} of constants (diamonds)", fontsize=10)
    return figure
