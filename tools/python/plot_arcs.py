"""Radiosity on small arcs about a vertex, and its derivative along one of them.

The arcs are probes named arc_rRADIUS_NUMBER, which tools/arc_deck adds to a deck; their values
are u*, the radiosity that the solution sends back through the integral equation. With several
files (N = 8, 16, 32, ...) the left panel shows the last one, the right panel all of them.
"""

import re

import numpy as np

import view as space
from result import Problem, Result, names_in, parser, run, save


def opening(result: Result, points: np.ndarray, radius: float) -> np.ndarray:
    """The share t in 0..1 of the angle at the vertex that a point of an arc has passed."""
    for triangle in result.array("polyrad/triangles/vertices"):
        for k in range(3):
            v, a, b = np.roll(triangle, -k, axis=0)
            out = points - v
            normal = np.cross(a - v, b - v)
            flat = np.abs(out @ normal).max() < 1e-6 * radius * np.linalg.norm(normal)
            if not flat or np.abs(np.linalg.norm(out, axis=1) / radius - 1).max() > 1e-6:
                continue
            e = (a - v) / np.linalg.norm(a - v)
            f = np.cross(normal / np.linalg.norm(normal), e)
            t = np.arctan2(out @ f, out @ e) / np.arctan2((b - v) @ f, (b - v) @ e)
            if t.min() > -1e-6 and t.max() < 1 + 1e-6:
                return t if t[0] <= t[-1] else 1 - t
    raise Problem(f"{result.path}: the arc of radius {radius:g} lies about no vertex of the scene")


def arcs(result: Result, band: str | None) -> dict[float, tuple[np.ndarray, np.ndarray]]:
    """t and u of each arc, by radius."""
    names = names_in(result.array("polyrad/probes/name"))
    u, _, _ = result.field("polyrad/probes/radiosity", band)
    points = np.asarray(result.array("polyrad/probes/position"), float)
    of_radius: dict[float, list[int]] = {}
    for i, name in enumerate(names):
        if found := re.fullmatch(r"arc_r([0-9.e+-]+)_(\d+)", name):
            of_radius.setdefault(float(found[1]), []).append(i)
    if not of_radius:
        raise Problem(
            f"{result.path} has no probes named arc_r...; tools/arc_deck adds them to a deck"
        )
    found = {}
    for radius, rows in sorted(of_radius.items(), reverse=True):
        if len(rows) < 3:
            raise Problem(f"{result.path}: the arc of radius {radius:g} has fewer than 3 probes")
        found[radius] = opening(result, points[rows], radius), u[rows]
    return found


def label(result: Result) -> str:
    unknowns = result.diagnostic("unknowns")
    return result.path if unknowns is None else f"{int(unknowns)} unknowns"


def main() -> None:
    options = parser(__doc__, "FILE...")
    options.add_argument(
        "--slope",
        type=float,
        default=0.01,
        metavar="RADIUS",
        help="arc whose derivative is shown; default 0.01",
    )
    options.add_argument("--band", help="name or number of a band; default: the first")
    options = options.parse_args()

    results = [Result(path) for path in options.file]
    found = [arcs(result, options.band) for result in results]
    _, unit, _ = results[-1].field("polyrad/probes/radiosity", options.band)
    radii = list(found[-1])
    for result, arc in zip(results, found, strict=True):
        if options.slope not in arc:
            have = ", ".join(f"{r:g}" for r in arc)
            raise Problem(f"{result.path} has no arc of radius {options.slope:g}; it has {have}", 2)

    figure, (left, right) = space.plt.subplots(1, 2, figsize=(9.6, 4.4), layout="constrained")
    shades = space.plt.colormaps["ember"](np.linspace(0.75, 0.05, len(radii)))
    for radius, shade in zip(radii, shades, strict=True):
        left.plot(*found[-1][radius], color=shade, lw=1.6, label=f"r = {radius:g} m")
    left.set_ylabel(f"radiosity  [{unit}]")
    inner = []
    for i, (result, arc) in enumerate(zip(results, found, strict=True)):
        t, u = arc[options.slope]
        slope, between = np.diff(u) / np.diff(t), (t[1:] + t[:-1]) / 2
        inner.append(slope[(between > 0.01) & (between < 0.99)])
        right.plot(between, slope, color=f"C{i}", lw=1.4, label=label(result))
    inner = np.concatenate(inner)
    if np.ptp(inner) > 0:  # at the edges it grows without bound, which would flatten the rest
        right.set_ylim(inner.min() - 0.1 * np.ptp(inner), inner.max() + 0.1 * np.ptp(inner))
    right.set_ylabel(f"d radiosity / dt at r = {options.slope:g} m  [{unit}]")
    for panel in (left, right):
        panel.set(xlim=(0, 1), xlabel="t, share of the angle at the vertex")
        panel.grid(color="0.9", lw=0.7)
        panel.set_axisbelow(True)
        panel.spines[["top", "right"]].set_visible(False)
        above = {"loc": "lower center", "bbox_to_anchor": (0.5, 1.0)}
        panel.legend(
            frameon=False, fontsize=9, ncols=4, columnspacing=1.2, handlelength=1.4, **above
        )
    figure.suptitle(options.title or f"{results[-1].title}, {label(results[-1])}")
    save(figure, options.output, options.file[-1])


run(main)
