"""Exponents at edges and vertices: exact ones, and those that solutions show near by."""

from dataclasses import dataclass

import numpy as np

from paper_runs import Runs

# The halvings of the distance at which the solution is looked at.
DISTANCE = 2.0 ** -np.arange(2, 25)
TOLERANCE = 1e-8


@dataclass
class Line:
    """Points start + h direction on a surface, h in DISTANCE."""

    name: str
    surface: str
    start: tuple[float, float, float]
    direction: tuple[float, float, float]


def local_exponents(u: np.ndarray) -> np.ndarray:
    """Of u at h, h/2, h/4 ..: log2 of u(h) - u(h/2) over u(h/2) - u(h/4), which is beta where u is
    c + C h^beta."""
    step = u[..., :-1] - u[..., 1:]
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.log2(step[..., :-1] / step[..., 1:])


def unit(vector) -> tuple[float, ...]:
    vector = np.asarray(vector, float)
    return tuple(vector / np.linalg.norm(vector))


def away(point, along, toward) -> tuple[float, ...]:
    """The direction from a point of an edge into a face: across ALONG, on the side of TOWARD."""
    along = np.asarray(unit(along))
    off = np.asarray(toward, float) - np.asarray(point, float)
    return unit(off - along * (off @ along))


LINES = {
    "cube_corner_p1.yml": [
        Line("edge, r = 1", "floor", (0.5, 0, 0), (0, 1, 0)),
        Line("edge, r = 1/64", "floor", (1 / 128, 0, 0), (0, np.pi / (6 * np.sqrt(3)) / 64, 0)),  # h: phi
        Line("vertex, t = 1/4", "floor", (0, 0, 0), unit((np.cos(np.pi / 8), np.sin(np.pi / 8), 0))),
        Line("vertex, t = 1/2", "floor", (0, 0, 0), unit((1, 1, 0))),
    ],
    "wedge_p1.yml": [
        Line("1-2", "floor", (0, 0.4, 0), (1, 0, 0)),
        Line("1-3", "floor", (0.4, 0, 0), (0, 1, 0)),
        Line("2-3", "white", (0.4, 0.4, 0.4), away((0.4, 0.4, 0.4), (1, 1, 1), (0, 1, 0))),
        Line("2-3", "grey", (0.4, 0.4, 0.4), away((0.4, 0.4, 0.4), (1, 1, 1), (1, 0, 0))),
    ],
}


def exact_and_measured(
    runs: Runs, deck: str, tolerance: float = TOLERANCE
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Edge exponents [triangle, 3] (v0v1, v1v2, v2v0) and vertex exponents [triangle, 3] as polyrad
    solves their equations, and the local exponents of an adaptive solution along LINES of the deck."""
    probes = []
    for line in LINES[deck]:
        for h in DISTANCE:
            at = np.asarray(line.start) + h * np.asarray(line.direction)
            place = ", ".join(f"{x:.17g}" for x in at)
            probes.append(f"{{surface: {line.surface}, at: [{place}]}}")
    settings = ["method={}", f"accuracy.tolerance={tolerance}", "output.sampling=1"]
    settings += [f"probes=[{', '.join(probes)}]"]
    if deck.startswith("wedge"):  # exponents do not depend on E: the face whose light shows them best
        settings += [f"scene.triangles.{i}.emission={e}" for i, e in enumerate((0, 0, 1))]
    given = [part for setting in settings for part in ("--set", setting)]
    result = runs.result(runs.deck(deck), f"{deck[:-4]}_exponents", given)
    u = np.asarray(result.array("polyrad/probes/radiosity")).reshape(-1, len(DISTANCE))
    edge = np.asarray(result.array("polyrad/triangles/edge_exponent"))
    return edge, np.asarray(result.array("polyrad/triangles/vertex_exponent")), local_exponents(u)


def of_the_paper(solution, n: int) -> tuple[float, float]:
    """(4.6), estimated from u_h on the floor at 1, 2 and 4 mesh widths: across the edge close to the
    vertex, r = 1/(2N), and along the ray phi = 1/2 towards the vertex."""
    h = np.array([4, 2, 1]) / n
    across = solution.at(0, 0, h, 0.5 / n)
    along = solution.at(0, 0, 0.5, h)
    return float(local_exponents(across)[0]), float(local_exponents(along)[0])
