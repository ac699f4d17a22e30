"""The paper's meshes P(N,p) and trial functions, written anew from its section 3: what figures of meshes
need, and u_h at any point of a sub-triangle from the values at the collocation points."""

import numpy as np

GAUSS = np.array([0.5 - 0.5 / np.sqrt(3), 0.5 + 0.5 / np.sqrt(3)])  # c_0, c_1 of (3.15)
SUBS = [(0, 1), (1, 0), (1, 2), (2, 1), (2, 0), (0, 2)]  # corner and the vertex its half edge leads to


def legs(n: int, p: float, rounding=lambda x: np.floor(x + 0.5)) -> np.ndarray:
    """Rectangles in one leg of every layer; (3.8) leaves the rounding open."""
    grid = (np.arange(n + 1) / n) ** p
    return rounding((1 - grid[1:]) / (grid[1:] - grid[:-1]))


def rectangles(n: int, p: float) -> tuple[np.ndarray, np.ndarray]:
    """P(N,p): [m, 2, 2] limits of (phi, r), and the layer of each, in the order of the result files."""
    grid, out, layer = (np.arange(n + 1) / n) ** p, [], []
    for i, parts in enumerate(legs(n, p).astype(int)):
        own = grid[i : i + 2]
        cuts = grid[i + 1] + (1 - grid[i + 1]) * np.arange(parts + 1) / max(parts, 1)
        along = [cuts[m : m + 2] for m in range(parts)]
        out += [(own, own), *((cut, own) for cut in along), *((own, cut) for cut in along)]
        layer += [i] * (1 + 2 * parts)
    return np.array(out), np.array(layer)


def place(triangle: np.ndarray, sub: int, phi, r) -> np.ndarray:
    """Points (3.25) of sub-triangle SUB of a triangle [3, 2 or 3] at (phi, r)."""
    corner, toward = triangle[SUBS[sub][0]], triangle[SUBS[sub][1]]
    middle, t = (corner + toward) / 2, np.sqrt(3) * np.tan(np.pi / 6 * np.asarray(phi))
    return corner + np.asarray(r)[..., None] * (
        middle - corner + t[..., None] * (triangle.mean(axis=0) - middle)
    )


def locate(triangle: np.ndarray, points: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """(phi, r) of points [n, 2 or 3] of a triangle, and their sub-triangles."""
    phi, r, sub = (np.full(len(points), np.nan), np.zeros(len(points)), np.full(len(points), -1))
    for s, (corner, toward) in enumerate(SUBS):
        middle = (triangle[corner] + triangle[toward]) / 2
        sides = np.stack([middle - triangle[corner], triangle.mean(axis=0) - middle], axis=1)
        along, across = np.linalg.pinv(sides) @ (points - triangle[corner]).T
        t = across / np.where(along > 0, along, np.inf)
        here = (sub < 0) & (along <= 1 + 1e-12) & (t >= -1e-12) & (t <= 1 + 1e-12) & (along > 0)
        phi[here], r[here], sub[here] = 6 / np.pi * np.arctan(t[here] / np.sqrt(3)), along[here], s
    return phi.clip(0, 1), r.clip(0, 1), sub


def collocation(box: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(phi, r) of the four Gauss points of every rectangle [m, 4], phi fastest."""
    phi = box[:, :1, 0] + (box[:, :1, 1] - box[:, :1, 0]) * np.tile(GAUSS, 2)
    r = box[:, 1:, 0] + (box[:, 1:, 1] - box[:, 1:, 0]) * np.repeat(GAUSS, 2)
    return phi, r


class Solution:
    """u_h of a run of method {mesh: paper, degree: 1} from its result file."""

    def __init__(self, result, n: int, p: float):
        self.triangles = np.asarray(result.array("polyrad/triangles/vertices"))
        self.box, self.layer = rectangles(n, p)
        points = self.points = np.asarray(result.array("polyrad/solution/point"))
        values = np.asarray(result.array("polyrad/solution/value"))
        shape = (len(self.triangles), len(SUBS), len(self.box), 4)
        if values.size != np.prod(shape):
            raise ValueError(f"{result.path} is no run with P({n},{p:g}) and P1")
        phi, r = collocation(self.box)
        for t, triangle in enumerate(self.triangles):
            for s in range(len(SUBS)):
                off = place(triangle, s, phi, r) - points.reshape(*shape, 3)[t, s]
                assert np.abs(off).max() < 1e-12, "the points of the file are in another order"
        self.value = values.reshape(shape)

    def at(self, triangle: int, sub: int, phi, r) -> np.ndarray:
        """u_h at (phi, r); between rectangles that of the one above."""
        phi, r = np.broadcast_arrays(np.asarray(phi, float), np.asarray(r, float))
        box, c = self.box, GAUSS
        inside = np.ones((*phi.shape, len(box)), bool)
        for k, x in enumerate((phi, r)):
            x = x[..., None]
            inside &= (x >= box[:, k, 0]) & ((x < box[:, k, 1]) | (box[:, k, 1] == 1))
        m = inside.argmax(axis=-1)
        xi = (phi - box[m, 0, 0]) / (box[m, 0, 1] - box[m, 0, 0])
        eta = (r - box[m, 1, 0]) / (box[m, 1, 1] - box[m, 1, 0])
        a, b = (xi - c[0]) / (c[1] - c[0]), (eta - c[0]) / (c[1] - c[0])
        v = self.value[triangle, sub, m]
        low = v[..., 0] + a * (v[..., 1] - v[..., 0])
        return low + b * (v[..., 2] + a * (v[..., 3] - v[..., 2]) - low)

    def at_points(self, triangle: int, points: np.ndarray) -> np.ndarray:
        """u_h at points [n, 3] of a triangle."""
        phi, r, sub = locate(self.triangles[triangle], points)
        value = np.empty(len(points))
        for s in range(len(SUBS)):
            value[sub == s] = self.at(triangle, s, phi[sub == s], r[sub == s])
        return value

    def on_grid(self, phi, r) -> np.ndarray:
        """[triangle, sub, point] at the same (phi, r) of every sub-triangle."""
        return np.array(
            [[self.at(t, s, phi, r) for s in range(len(SUBS))] for t in range(len(self.triangles))]
        )
