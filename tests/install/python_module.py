"""The Python module against the library at POLYRAD_LIBRARY; run by test_install.py."""

import copy
import pickle
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
        close, error = corner(), s.surface_errors()
        close.solve(tolerance=1e-7, threads=1)
        for coarse, fine, most in zip(s.surface_means(), close.surface_means(), error):
            self.assertTrue((abs(coarse - fine) <= most).all() and (most <= 2e-4).all())
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


class Refused(unittest.TestCase):
    """What would be read beyond its end, or means nothing, is an exception with a sentence."""

    def refuse(self, error, words, **more):
        with self.subTest(**{k: repr(v)[:60] for k, v in more.items()}), self.assertRaisesRegex(error, words):
            corner(**more)

    def test_bands(self):
        m = len(TRIANGLES)
        for name in ("rho", "emission"):
            for shape in ((m, 0), (1, 0), (0, 0), (m, 3, 0), (m, 17)):
                self.refuse(ValueError, f"last axis of {name}, the bands, is (0|17); give .* from 1 to 16",
                            **{name: np.zeros(shape)})
        for bands in (0, -1, 17, 2**31, 2**32 + 1, -2**63):
            self.refuse(ValueError, f"bands is {bands}; give a whole number from 1 to 16", bands=bands)
        for bands in (1.5, "2", [1], np.nan):
            self.refuse(TypeError, "", bands=bands)
        self.refuse(ValueError, r"rho has the shape \[3, 2\]; give one that fits \[3, 3\]", rho=np.zeros((m, 2)), bands=3)
        self.refuse(ValueError, "emission has the shape", emission=np.ones((m, 2)), rho=np.zeros((m, 3)))

    def test_shapes(self):
        for name, whole in (("vertices", VERTICES), ("triangles", TRIANGLES)):
            for bad in (whole[:, :2], whole[0], whole[None], whole[0, 0], [], [[]], whole.T[:, :2], whole.ravel(),
                        np.zeros((len(whole), 4), int)):
                self.refuse(ValueError, f"{name} must have the shape \\[n, 3\\], but has", **{name: bad})
        self.refuse(polyrad.Error, "0 vertices", vertices=np.zeros((0, 3)))
        self.refuse(polyrad.Error, "0 triangles", triangles=np.zeros((0, 3), int), surface=None, names=None,
                    emission=1)
        for name, n in (("rho", 2), ("rho", 4), ("emission", 2), ("emission", 0), ("surface", 2), ("surface", 4),
                        ("surface", 0)):
            self.refuse(ValueError, f"{name} has the shape", **{name: np.zeros(n, int)})
        self.refuse(ValueError, "emission has the shape", emission=np.zeros((3, 2, 1)))
        self.refuse(ValueError, "rho has the shape", rho=np.zeros((3, 3, 1)))
        self.refuse(ValueError, "surface has the shape", surface=np.zeros((3, 1), int))
        heat = {"rho": None, "emission": None, "emissivity": 0.5, "temperature": 300}
        for name in ("emissivity", "temperature"):
            for bad in (np.ones(2), np.ones((3, 1)), np.ones(0)):
                self.refuse(ValueError, f"{name} has the shape", **{**heat, name: bad})

    def test_indices(self):
        for bad in (2**31, 2**32, -2**31, -2**63, 2**63):
            dtype = np.uint64 if bad >= 2**63 else np.int64
            for name, whole in (("triangles", TRIANGLES), ("surface", np.arange(3))):
                a = whole.astype(dtype)
                a.flat[1] = bad
                self.refuse(ValueError, f"{name} has indices from .* indices are at most 2\\^31 - 1", **{name: a})
        for bad in (-1, 4, 2**31 - 1, -2**31 + 1):
            a = TRIANGLES.copy()
            a[1, 2] = bad
            self.refuse(polyrad.Error, f"triangle 2 has the vertex index {bad}; give one of 0 to 3", triangles=a)
            self.refuse(polyrad.Error, f"triangle 2 has the surface index {bad}; give one of 0 to 2",
                        surface=[0, bad, 2])
        for bad in (3, 2**31 - 1):
            self.refuse(ValueError, f"there are {bad + 1} surfaces, but only 3 triangles", surface=[0, 1, bad], names=None)
        for bad in (TRIANGLES + 0.5, TRIANGLES > 0, TRIANGLES.astype(str), TRIANGLES * 1j):
            self.refuse(TypeError, "triangles must be", triangles=bad)
        self.refuse(TypeError, "", triangles=TRIANGLES.astype(object) + 2**70)

    def test_names(self):
        self.refuse(ValueError, "there are 4 surfaces", names=["a", "b", "c", "d"])
        self.refuse(polyrad.Error, "n_surface is 0", names=[])
        self.refuse(TypeError, "without zero characters", names=["a", "b", "c\0d"])
        self.refuse(TypeError, "is no name", names=["a", "b", 3])
        self.refuse(TypeError, "a list of texts", names="abc")
        self.refuse(ValueError, "give surface too", surface=None)

    def test_numbers(self):
        for bad in (np.nan, np.inf, -np.inf):
            v = VERTICES.astype(float)
            v[1, 1] = bad
            self.refuse(polyrad.Error, "not finite", vertices=v)
            self.refuse(polyrad.Error, "rho is", rho=[0.5, bad, 0.5])
            self.refuse(polyrad.Error, "emission is", emission=[1, bad, 1])
            at_vertices = np.ones((3, 3, 1))
            at_vertices[2, 1] = bad
            self.refuse(polyrad.Error, "emission is", emission=at_vertices)
            heat = {"rho": None, "emission": None, "emissivity": [0.5, 1, 1], "temperature": [300, 1, 2]}
            self.refuse(polyrad.Error, "emissivity", **{**heat, "emissivity": [0.5, bad, 1]})
            self.refuse(polyrad.Error, "temperature", **{**heat, "temperature": [300, bad, 1]})
            self.refuse(polyrad.Error, "flux", **{**heat, "temperature": [300, np.nan, 1], "flux": [np.nan, bad, np.nan]})
        for bad in ("a", ["1", "2", "3"], [1j, 0, 0], [None, 1, 2]):
            self.refuse(TypeError, "emission must be real numbers", emission=bad)

    def test_too_many(self):
        """More than an int counts: told before anything is copied."""
        many = np.broadcast_to(np.zeros(3), (2**31 + 4, 3))
        self.refuse(ValueError, "vertices must have the shape", vertices=many)
        self.refuse(ValueError, "triangles must have the shape", triangles=np.broadcast_to(np.zeros(3, int), many.shape))
        s = corner()
        s.solve(threads=1)
        with self.assertRaisesRegex(ValueError, "position must have the shape"):
            s.evaluate_at(0, many)

    def test_points(self):
        s = corner()
        s.solve(threads=1)
        one = [0.5, 0.25, 0.25]
        for call, what in ((s.evaluate, "weight"), (s.evaluate_at, "position")):
            for bad in (0.5, [0.5, 0.5], [0.5] * 6, [[0.5, 0.5]], np.ones((3, 4)), np.ones((4, 0)), [[one]], np.ones((2, 5, 3))):
                with self.assertRaisesRegex(ValueError, what + " must have the shape"):
                    call(0, bad)
            for bad in ([0, 1], [], [[0]], np.zeros((1, 1), int)):
                with self.assertRaisesRegex(ValueError, "triangle has the shape"):
                    call(bad, [one] * 3 if len(bad) != 1 else [one] * 1)
            for bad in (-1, 3, 2**31 - 1):
                with self.assertRaisesRegex(polyrad.Error, f"point 1 has the triangle index {bad}; give one of 0 to 2"):
                    call(bad, one)
            for bad in (2**31, -2**63):
                with self.assertRaisesRegex(ValueError, "triangle has indices"):
                    call(np.int64(bad), one)
            with self.assertRaisesRegex(TypeError, "triangle must be whole numbers"):
                call(0.0, one)
            for bad in (np.nan, np.inf):
                with self.assertRaisesRegex(polyrad.Error, "not finite"):
                    call(0, [bad, 0.5, 0.5])
            for empty in ([], np.zeros((0, 3))):
                u, h = call(np.zeros(0, int), empty)
                self.assertEqual((u.shape, h.shape), ((0, 1), (0, 1)))
        self.assertEqual(s.evaluate(1, one)[0].shape, (1, 1))

    def test_options(self):
        s = corner()
        for threads in (-1, 4097, 2**31, 2**32 + 1):
            with self.assertRaisesRegex(ValueError, "threads is"):
                s.solve(threads=threads)
        for bad in (-1, np.nan, 2, np.inf):
            with self.assertRaisesRegex(polyrad.Error, "tolerance is"):
                s.solve(tolerance=bad)
            with self.assertRaisesRegex(polyrad.Error, "tolerance is"):
                s.view_factors(bad)
        for bad in (-1, np.nan):
            with self.assertRaisesRegex(polyrad.Error, "memory_limit is"):
                s.solve(memory_limit=bad)

    def test_any_layout_of_arrays(self):
        """Strides, order and type of the numbers do not matter."""
        a = corner()
        a.solve(1e-3, threads=1)
        wide = np.full((8, 6), np.nan)
        wide[::2, ::-2] = VERTICES
        backwards = TRIANGLES[::-1].copy()
        for more in ({"vertices": wide[::2, ::-2]}, {"vertices": np.asfortranarray(VERTICES, dtype=">f8")},
                     {"triangles": np.asfortranarray(TRIANGLES, dtype=np.int16)}, {"triangles": backwards[::-1]},
                     {"triangles": TRIANGLES.astype(">i8")}, {"triangles": TRIANGLES.astype(np.uint8)},
                     {"rho": np.broadcast_to(0.5, (3, 1)), "emission": np.array([0.3, 1, 0.5])[::-1]},
                     {"surface": np.arange(6, dtype=np.uint64)[:3]}):
            b = corner(**more)
            b.solve(1e-3, threads=1)
            np.testing.assert_array_equal(a.surface_means(), b.surface_means())
        points = np.full((3, 4), np.nan)
        points[:, 1:] = [0.5, 0.25, 0.25]
        np.testing.assert_array_equal(a.evaluate(np.array([0, 9, 1, 9, 2])[::2], points[:, 1:]),
                                      a.evaluate([0, 1, 2], [[0.5, 0.25, 0.25]] * 3))

    def test_at_work(self):
        """emission may not call its scene; copies would free the handle twice."""
        scene = []
        scene.append(corner(emission=lambda *_: scene[0].view_factors()[0, 0]))
        with self.assertRaisesRegex(RuntimeError, "at work"):
            scene[0].solve(threads=1)
        for make in (copy.copy, copy.deepcopy, pickle.dumps):
            with self.assertRaisesRegex(TypeError, "cannot be copied"):
                make(scene[0])


if __name__ == "__main__":
    unittest.main()
