"""The surfaces of a result file as triangles that face their radiating side, and lines on them."""

from dataclasses import dataclass

import numpy as np

from result import Problem, Result

# A cell is cut into four triangles round its middle: a cut along one diagonal would show.
FAN = np.array([[0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4]])


@dataclass
class Surfaces:
    point: np.ndarray  # [5 n, 3]: of each cell its corners and its middle [m]
    normal: np.ndarray  # [n, 3]: unit vector to the radiating side; 0 where it is not known
    area: np.ndarray  # [n] [m2]
    face: np.ndarray  # [m, 3]: point numbers, counterclockwise seen from the radiating side
    cell: np.ndarray  # [n]: number in the file

    @classmethod
    def of(cls, result: Result, keep: np.ndarray) -> "Surfaces":
        """The cells of the file's picture for which keep [cells] is true."""
        points = np.asarray(result.array("VTKHDF/Points"), float)
        cell = np.flatnonzero(keep)
        if len(cell) == 0:
            raise Problem(f"{result.path} has no values to show", 2)
        corner = result.corners()[cell]
        at = points[corner]
        area = 0.5 * np.cross(at[:, 2] - at[:, 0], at[:, 3] - at[:, 1])
        normal = normals(result, cell)
        turned = np.einsum("ij,ij->i", area, normal) < 0
        is_triangle = corner[:, 2] == corner[:, 3]
        fan = np.where(turned[:, None, None], FAN[:, ::-1], FAN)
        face = fan + 5 * np.arange(len(cell))[:, None, None]
        used = np.ones((len(cell), 4), bool)
        used[:, 2] = ~is_triangle
        return cls(
            with_middle(at, is_triangle).reshape(-1, 3),
            normal,
            np.linalg.norm(area, axis=1),
            face[used],
            cell,
        )

    def middle(self) -> np.ndarray:
        return self.point[4::5]


def with_middle(value: np.ndarray, is_triangle: np.ndarray) -> np.ndarray:
    """Values at four corners [n, 4, ...], and their mean as a fifth; a triangle has three."""
    count = np.where(is_triangle, 3, 4).reshape(-1, *[1] * (value.ndim - 2))
    last = np.where(is_triangle.reshape(count.shape), 0, value[:, 3])
    middle = (value[:, :3].sum(axis=1) + last) / count
    return np.concatenate([value, middle[:, None]], axis=1)


def normals(result: Result, cell: np.ndarray) -> np.ndarray:
    """Of the radiating side of each cell; 0 where the file does not say."""
    if result.file.get("VTKHDF/CellData/triangle") is None:
        return np.zeros((len(cell), 3))
    return result.array("polyrad/triangles/normal")[result.array("VTKHDF/CellData/triangle")[cell]]


def values(result: Result, surfaces: Surfaces, value: np.ndarray, on_cells: bool) -> np.ndarray:
    """Values of points or cells of the file [., k] at the points of the surfaces [5 n, k]."""
    if on_cells:
        return value[surfaces.cell].repeat(5, axis=0)
    corner = result.corners()[surfaces.cell]
    at = with_middle(value[corner], corner[:, 2] == corner[:, 3])
    return at.reshape(-1, value.shape[1])


def element_lines(result: Result, surfaces: Surfaces) -> tuple[np.ndarray, np.ndarray]:
    """Outlines [m, 2, 3] of the elements, and their normals [m, 3].

    Points are not shared between elements, and those of an element follow one another: a cell whose
    points are all new begins one. Within an element, sides of two cells are inside.
    """
    corner = result.corners()
    newest = np.maximum.accumulate(corner.max(axis=1))
    begins = np.concatenate([[True], corner.min(axis=1)[1:] > newest[:-1]])
    element = np.cumsum(begins)[surfaces.cell]
    at = surfaces.point.reshape(-1, 5, 3)[:, :4]
    size = np.ptp(at.reshape(-1, 3), axis=0).max()
    place = np.unique(np.round(at.reshape(-1, 3) / size, 10), axis=0, return_inverse=True)[1]
    place = place.reshape(-1, 4)
    pair = np.sort(np.stack([place, np.roll(place, -1, axis=1)], axis=2), axis=2).reshape(-1, 2)
    key = np.column_stack([element.repeat(4), pair])
    _, first, count = np.unique(key, axis=0, return_index=True, return_counts=True)
    chosen = first[(count == 1) & (pair[first, 0] != pair[first, 1])]
    cell, side = chosen // 4, chosen % 4
    lines = np.stack([at[cell, side], at[cell, (side + 1) % 4]], axis=1)
    return lines, surfaces.normal[cell]


def triangle_lines(result: Result) -> tuple[np.ndarray, np.ndarray]:
    """Sides [m, 2, 3] of the scene's triangles, and their normals [m, 3]."""
    vertices = np.asarray(result.array("polyrad/triangles/vertices"), float)
    lines = np.stack([vertices, np.roll(vertices, -1, axis=1)], axis=2).reshape(-1, 2, 3)
    return lines, result.array("polyrad/triangles/normal").repeat(3, axis=0)
