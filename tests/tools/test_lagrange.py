"""Pictures of Lagrange cells, as VTK's own reader and interpolation see them."""

import os
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

import h5py
import numpy as np

import synthetic  # noqa: F401 - of the same folder as the tools' tests
from project import ROOT

sys.path.insert(0, str(ROOT / "tools/python"))

PROGRAM = Path(os.environ.get("POLYRAD", ROOT / "build/release/polyrad"))
SUB = [(0, 1), (1, 0), (1, 2), (2, 1), (2, 0), (0, 2)]  # v -> w of the six sub-triangles
GRADED = "{mesh: graded, elements: 1, degree: %d, grading: %d, angle: %s, quadrature_tolerance: 1e-6}"


def setUpModule():
    global vtk
    try:
        import vtk
    except ImportError:
        raise unittest.SkipTest("no vtk here: tools/venv render installs it") from None
    if not PROGRAM.exists():
        raise unittest.SkipTest(f"no program {PROGRAM}")


def angle_map(angle, phi):
    return np.sqrt(3) * np.tan(np.pi * phi / 6) if angle == "polar" else phi


def lagrange(nodes, x):
    """[len(x), len(nodes)]: values of the Lagrange polynomials."""
    value = np.ones((len(x), len(nodes)))
    for a, at in enumerate(nodes):
        for b, other in enumerate(nodes):
            if a != b:
                value[:, a] *= (x - other) / (at - other)
    return value


class Element:
    """One sub-triangle of mesh graded, N = 1, from what the file says of triangles and u_h."""

    def __init__(self, file, number, degree, p, angle):
        triangle, (v, w) = number // 6, SUB[number % 6]
        corner = file["polyrad/triangles/vertices"][triangle]
        self.v, middle = corner[v], (corner[v] + corner[w]) / 2
        self.a, self.b = middle - self.v, corner.mean(axis=0) - middle
        self.p, self.angle, k = p, angle, degree + 1
        self.nodes = (np.polynomial.legendre.leggauss(k)[0] + 1) / 2
        self.u = file["polyrad/solution/value"][number * k * k : (number + 1) * k * k, 0].reshape(k, k)
        self.point = file["polyrad/solution/point"][number * k * k : (number + 1) * k * k]

    def place(self, sigma, tau):
        t = angle_map(self.angle, sigma**self.p)
        return self.v + (tau**self.p)[:, None] * (self.a + t[:, None] * self.b)

    def value(self, sigma, tau):
        return np.einsum("na,nc,ca->n", lagrange(self.nodes, sigma), lagrange(self.nodes, tau), self.u)


class Lagrange(unittest.TestCase):
    def setUp(self):
        holder = tempfile.TemporaryDirectory()
        self.addCleanup(holder.cleanup)
        self.folder = Path(holder.name)

    def solve(self, *more):
        path = self.folder / "x.vtkhdf"
        words = [w for key in ("output.cells=lagrange", *more) for w in ("--set", key)]
        subprocess.run([PROGRAM, "run", ROOT / "inputs/cube_corner.yml", "--quiet", "-o", path, *words],
                       check=True, timeout=900)
        reader = vtk.vtkHDFReader()
        reader.SetFileName(str(path))
        reader.Update()
        return path, reader.GetOutput()

    def at(self, grid, cell, xi):
        """Positions and radiosities by VTK's interpolation at parametric coordinates [n, 2]."""
        c, ids = grid.GetCell(cell), grid.GetCell(cell).GetPointIds()
        array = grid.GetPointData().GetArray("radiosity")
        nodal = np.array([array.GetTuple1(ids.GetId(i)) for i in range(ids.GetNumberOfIds())])
        place, value = np.empty((len(xi), 3)), np.empty(len(xi))
        for n, (a, b) in enumerate(xi):
            weight, x, sub = [0.0] * len(nodal), [0.0] * 3, vtk.mutable(0)
            c.EvaluateLocation(sub, [a, b, 0], x, weight)
            place[n], value[n] = x, np.dot(weight, nodal)
        return place, value

    def check(self, degree, p, angle, order, place_error, value_error):
        path, grid = self.solve("accuracy={}", "method=" + GRADED % (degree, p, angle))  # shows u_h
        xi = np.random.default_rng(2003).random((40, 2))
        self.assertEqual(grid.GetNumberOfCells(), 18)
        with h5py.File(path) as file:
            size = np.abs(file["polyrad/solution/value"][()]).max()
            for cell in range(18):
                self.assertEqual(grid.GetCellType(cell), vtk.VTK_LAGRANGE_QUADRILATERAL)
                self.assertEqual(grid.GetCell(cell).GetNumberOfPoints(), (order + 1) ** 2)
                e = Element(file, cell, degree, p, angle)
                mesh = np.meshgrid(e.nodes, e.nodes)
                np.testing.assert_allclose(e.place(*(m.ravel() for m in mesh)), e.point, atol=1e-15)
                place, value = self.at(grid, cell, xi)
                np.testing.assert_allclose(place, e.place(*xi.T), atol=place_error)
                np.testing.assert_allclose(value, e.value(*xi.T), atol=value_error * size)
                self.borders(grid, cell, e)

    def borders(self, grid, cell, e):
        """The sides of the cell are those of the plane trapezoid, whatever happens inside."""
        s = np.linspace(0, 1, 9)
        zero, one = np.zeros(9), np.ones(9)
        for xi, start, end in (((s, zero), e.v, e.v), ((one, s), e.v, e.v + e.a + e.b),
                               ((s, one), e.v + e.a, e.v + e.a + e.b), ((zero, s), e.v, e.v + e.a)):
            place, _ = self.at(grid, cell, np.transpose(xi))
            np.testing.assert_allclose(place[[0, -1]], [start, end], atol=1e-15)
            np.testing.assert_allclose(np.cross(place - start, end - start), 0, atol=1e-14)

    def test_polynomials_are_exact(self):
        # x has degree p in sigma and tau, u_h its own: both at most the order of the cell
        self.check(5, 2, "duffy", 5, 1e-13, 1e-12)
        self.check(3, 3, "duffy", 6, 1e-13, 1e-12)

    def test_polar_coordinates(self):
        # tan is no polynomial: interpolated at 7 points, error 3e-4 of the size; u_h still exact
        self.check(5, 3, "polar", 6, 1e-3, 1e-12)

    def test_order_has_a_limit(self):
        path, grid = self.solve("method=" + GRADED % (13, 1, "duffy"))
        self.assertEqual(grid.GetCell(0).GetNumberOfPoints(), 11**2)

    def test_adaptive_and_cell_data(self):
        path, grid = self.solve("accuracy.tolerance=1e-3", "output.sampling=1")
        with h5py.File(path) as file:
            n = len(file["VTKHDF/Types"])
            self.assertEqual(n, file["polyrad/diagnostics"].attrs["elements"])
            self.assertEqual(len(file["VTKHDF/CellData/error_bound"]), n)
            area = file["polyrad/surfaces/area"][()].sum()
        sizes = vtk.vtkCellSizeFilter()
        sizes.SetInputData(grid)
        sizes.Update()
        cell_area = sizes.GetOutput().GetCellData().GetArray("Area")
        total = sum(cell_area.GetTuple1(i) for i in range(n))
        self.assertAlmostEqual(total / area, 1, delta=1e-12)

    def test_tools_cut_them_into_linear_cells(self):
        from result import Result
        from surfaces import Surfaces

        path, _ = self.solve("method=" + GRADED % (4, 2, "polar"))
        result = Result(str(path))
        corner = result.corners()
        self.assertEqual(corner.shape, (18 * 16, 4))
        self.assertEqual(len(result.array("VTKHDF/CellData/triangle")), 18 * 16)
        point, area = result.array("VTKHDF/Points"), 0.0
        for a, b, c, d in corner:
            area += np.linalg.norm(np.cross(point[c] - point[a], point[d] - point[b])) / 2
        self.assertAlmostEqual(area, 1.5, delta=1e-13)
        made = Surfaces.of(result, np.ones(18 * 16, bool))
        self.assertAlmostEqual(made.area.sum(), 1.5, delta=1e-13)


if __name__ == "__main__":
    unittest.main()
