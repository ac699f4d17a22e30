"""Made-up result files in the layout of docs/format.md: a cube corner, as surface S1."""

from pathlib import Path

import h5py
import numpy as np

FACES = np.array(
    [
        [[0, 0, 0], [1, 0, 0], [0, 1, 0]],
        [[0, 0, 0], [0, 1, 0], [0, 0, 1]],
        [[0, 0, 0], [0, 0, 1], [1, 0, 0]],
    ],
    float,
)
NORMALS = np.array([[0, 0, 1], [1, 0, 0], [0, 1, 0]], float)
EMISSION = np.array([0.5, 1.0, 0.3])
DECK = "title: Cube corner, made up   # for tests\nscene: {}\n"
BANDS = ["red", "green", "blue"]


def radiosity(points: np.ndarray, face: np.ndarray) -> np.ndarray:
    """Smooth away from the edges, like s^0.76 near them, and a jump from face to face."""
    other = EMISSION.sum() - EMISSION[face]
    near = np.prod(np.sort(points, axis=1)[:, 1:], axis=1) ** 0.38
    return EMISSION[face] + 0.3 * other * np.exp(-3 * near - points.sum(axis=1))


def cells(n: int) -> tuple[np.ndarray, np.ndarray]:
    """Quadrilaterals [m,4,3] in the six sub-triangles of each face, and their faces."""
    s = np.arange(n) / n
    phi, r = (grid.ravel() for grid in np.meshgrid(s, s))
    made, face = [], []
    for f, triangle in enumerate(FACES):
        centre = triangle.mean(axis=0)
        for i in range(3):
            for turn in (1, -1):
                v, w = triangle[i], triangle[(i + turn) % 3]
                a, b = (w - v) / 2, centre - (v + w) / 2
                around = [(0, 0), (1, 0), (1, 1), (0, 1)]  # turns the other way in every second one
                at = [
                    v + (r + q / n)[:, None] * (a + (phi + p / n)[:, None] * b) for p, q in around
                ]
                made.append(np.stack(at, axis=1))
                face.append(np.full(n * n, f))
    return np.concatenate(made), np.concatenate(face)


def write_grid(file: h5py.File, quads: np.ndarray) -> h5py.Group:
    """Quadrilaterals [m,4,3] that share no points."""
    vtk = file.create_group("VTKHDF")
    vtk.attrs["Version"] = [2, 0]
    vtk.attrs["Type"] = np.bytes_("UnstructuredGrid")
    vtk["Points"] = quads.reshape(-1, 3)
    vtk["Connectivity"] = np.arange(4 * len(quads))
    vtk["Offsets"] = np.arange(len(quads) + 1) * 4
    vtk["Types"] = np.full(len(quads), 9, np.uint8)
    for name, n in {"Points": 4, "Cells": 1, "ConnectivityIds": 4}.items():
        vtk[f"NumberOf{name}"] = [n * len(quads)]
    return vtk


def write_box(path: Path, sides: list[str], color: np.ndarray, bands=BANDS) -> Path:
    """Sides -x .. +z of the cube [0,1]^3 that radiate inwards, each of one colour [side, band]."""
    quads, normals = [], []
    for side in sides:
        axis, high = "xyz".index(side[1]), side[0] == "+"
        square = np.insert([[0.0, 0], [1, 0], [1, 1], [0, 1]], axis, high, axis=1)
        quads.append(square)
        normals.append(np.eye(3)[axis] * (-1 if high else 1))
    quads = np.array(quads)
    with h5py.File(path, "w") as file:
        vtk = write_grid(file, quads)
        vtk["CellData/triangle"] = 2 * np.arange(len(sides))
        vtk["PointData/radiosity"] = np.repeat(color, 4, axis=0)
        group = file.create_group("polyrad")
        group.attrs["bands"] = bands
        group["triangles/vertices"] = quads[:, [[0, 1, 2], [0, 2, 3]]].reshape(-1, 3, 3)
        group["triangles/normal"] = np.repeat(normals, 2, axis=0)
    return path


def write(path: Path, n: int = 8, bands: int = 1) -> Path:
    quads, face = cells(n)
    points = quads.reshape(-1, 3)
    u = radiosity(points, face.repeat(4))
    u = np.stack([u * (b + 1) for b in range(bands)], axis=1) if bands > 1 else u
    with h5py.File(path, "w") as file:
        vtk = write_grid(file, quads)
        vtk["CellData/triangle"] = face
        for name, values in {"radiosity": u, "irradiance": 2 * u}.items():
            vtk[f"PointData/{name}"] = values
            vtk[f"PointData/{name}"].attrs["unit"] = "W/m2"
        group = file.create_group("polyrad")
        group.attrs["deck"] = DECK
        group.attrs["bands"] = BANDS[:bands] if bands > 1 else ["all"]
        group["triangles/vertices"] = FACES
        group["triangles/normal"] = NORMALS
        middle = quads.mean(axis=1)
        group["solution/point"] = middle
        group["solution/triangle"] = face
        group["solution/value"] = radiosity(middle, face)[:, None]
        group.create_group("diagnostics").attrs["unknowns"] = len(middle)
    return path


def write_probes(path: Path, name: list[str], position: np.ndarray) -> Path:
    """Add probes on the first face to a file of write()."""
    with h5py.File(path, "a") as file:
        probes = file.require_group("polyrad/probes")
        probes["name"] = np.array(name, h5py.string_dtype())
        probes["position"] = position
        probes["radiosity"] = radiosity(position, np.zeros(len(position), int))[:, None]
        probes["radiosity"].attrs["unit"] = "W/m2"
    return path


def write_study(path: Path, rate: float, group: str = "study") -> Path:
    unknowns = np.array([72, 288, 1152, 4608, 18432])
    error = 0.03 * (unknowns / 72.0) ** (-rate / 2)
    error[-1] = np.nan  # the reference
    columns = {
        "method.elements": [1, 2, 4, 8, 16],
        "unknowns": unknowns,
        "error": error,
        "eoc": np.full(5, rate),
        "seconds_total": 1e-6 * unknowns**1.5,
    }
    with h5py.File(path, "w") as file:
        for name, column in columns.items():
            file[f"{group}/{name}"] = column
        file.require_group("polyrad").attrs["deck"] = "title: Cube corner, p = 1\n"
    return path
