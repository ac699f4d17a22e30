"""The Python module against the library at POLYRAD_LIBRARY; run by test_install.py."""

import unittest

import numpy as np

import polyrad

VERTICES = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
TRIANGLES = np.array([[0, 1, 2], [0, 2, 3], [0, 3, 1]])


def corner(**more):
    return polyrad.Scene(**{"vertices": VERTICES, "triangles": TRIANGLES, "rho": 0.5, "emission": [0.5, 1, 0.3],
                            "surface": [0, 1, 2], "names": ["floor", "x0", "y0"], **more})


class Module(unittest.TestCase):
    def test_values(self):
        s = corner()
        summary = s.solve(tolerance=1e-4, threads=1)
        self.assertTrue(summary.converged and summary.unknowns > 50 and 0 < summary.relative_bound <= 1e-4)
        weight = np.array([[0.5, 0.25, 0.25], [0.2, 0.3, 0.5]])
        u, h = s.evaluate([0, 2], weight)
        np.testing.assert_allclose(u[:, 0], [0.5, 0.3] + 0.5 * h[:, 0], rtol=1e-14)
        position = np.einsum("nc,ncx->nx", weight, VERTICES[TRIANGLES[[0, 2]]].astype(float))
        np.testing.assert_allclose(s.evaluate_at([0, 2], position)[0], u, rtol=1e-12)
        means, _ = s.surface_means()
        self.assertEqual(means.shape, (3, 1))
        self.assertTrue((means[:, 0] > [0.5, 1, 0.3]).all())
        f = s.view_factors(1e-5)
        np.testing.assert_allclose(f, f.T, atol=2e-5)
        self.assertEqual(s.warnings, [])

    def test_bands(self):
        s = corner(emission=[[1, 2], [0, 0], [0, 0]], rho=np.full((3, 1), 0.5))
        s.solve(threads=1)
        u, _ = s.surface_means()
        np.testing.assert_allclose(u[:, 1], 2 * u[:, 0], rtol=1e-9)

    def test_function(self):
        at = VERTICES[TRIANGLES] @ [1.0, 2.0, 3.0]
        a, b = corner(emission=at[:, :, None]), corner(emission=lambda x, t, w, band: x @ [1, 2, 3])
        a.solve(1e-3, threads=1), b.solve(1e-3, threads=1)
        np.testing.assert_allclose(a.surface_means()[0], b.surface_means()[0], atol=2e-3 * 5)

    def test_heat(self):
        nan = np.nan
        s = corner(rho=None, emission=None, emissivity=[0.5, 1, 0.25], temperature=[1000, nan, nan], flux=[nan, 0, -5])
        s.solve(1e-3, threads=1)
        q, t = s.surface_heat()
        u, h = s.surface_means()
        np.testing.assert_allclose(q, (u - h)[:, 0], rtol=1e-12)
        np.testing.assert_allclose(q[1:], [0, -5], atol=1e-3 * u.max())
        np.testing.assert_allclose(5.670374419e-8 * t[1:]**4, h[1:, 0] + [0, -5 / 0.25], rtol=1e-9)
        self.assertEqual(t[0], 1000)
        with self.assertRaisesRegex(polyrad.Error, "has no emissivity"):
            s = corner()
            s.solve(threads=1)
            s.surface_heat()
        with self.assertRaisesRegex(polyrad.Error, "emissivity is given, and so are rho"):
            corner(emissivity=1, temperature=300)
        with self.assertRaisesRegex(polyrad.Error, "triangle 1 has the temperature nan and the flux nan"):
            corner(rho=None, emission=None, emissivity=1, temperature=nan)

    def test_errors(self):
        with self.assertRaisesRegex(polyrad.Error, "rho is 2 in band 1") as e:
            corner(rho=2)
        self.assertEqual(e.exception.status, 2)
        with self.assertRaisesRegex(polyrad.Error, "no solution yet"):
            corner().surface_means()
        with self.assertRaises(ZeroDivisionError):
            corner(emission=lambda *_: 1 / 0).solve()
        with self.assertRaises(TypeError):
            corner(triangles=TRIANGLES + 0.5)
        with self.assertRaises(ValueError):
            corner(vertices=[[0, 0]])


if __name__ == "__main__":
    unittest.main()
