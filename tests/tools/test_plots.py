"""tools/plot: each picture is made, shows what it should, and says what it lacks."""

import re
import tempfile
import unittest
from pathlib import Path

import h5py
import matplotlib.image
import numpy as np

import synthetic
from project import ROOT, call


class Plots(unittest.TestCase):
    def setUp(self):
        holder = tempfile.TemporaryDirectory()
        self.addCleanup(holder.cleanup)
        self.folder = Path(holder.name)
        self.result = synthetic.write(self.folder / "corner.vtkhdf", 4)

    def picture(self, kind: str, *arguments) -> np.ndarray:
        """The picture's pixels, [row, column, red green blue]."""
        out = self.folder / "out.png"
        made = call("plot", kind, *arguments, "-o", out)
        self.assertEqual((made.returncode, made.stderr), (0, ""))
        return matplotlib.image.imread(out)[:, :, :3]

    def words(self, kind: str, *arguments) -> str:
        out = self.folder / "out.svg"
        made = call("plot", kind, *arguments, "-o", out)
        self.assertEqual((made.returncode, made.stderr), (0, ""))
        return " ".join(re.findall(r">([^<>\n]+)</text>", out.read_text()))

    def refused(self, code: int, expected: str, *arguments):
        made = call("plot", *arguments, folder=self.folder)
        self.assertEqual(made.returncode, code, made.stderr)
        self.assertEqual(len(made.stderr.splitlines()), 1, made.stderr)
        self.assertIn(expected, made.stderr)

    def test_surface_has_title_unit_and_faces_in_order(self):
        words = self.words("surface", self.result)
        for word in ("Cube corner, made up", "radiosity", "W/m²"):
            self.assertIn(word, words)
        self.assertNotIn("for tests", words)
        image = self.picture("surface", self.result)
        height, width, _ = image.shape
        # From (1,1,1): y = 0 (darkest) to the left, x = 0 (brightest) right, floor below.
        left, right = image[height // 2, [int(0.33 * width), int(0.55 * width)]].sum(axis=1)
        floor = image[int(0.85 * height), int(0.43 * width)].sum()
        self.assertTrue(left < floor < right, (left, floor, right))

    def test_surface_without_seams(self):
        image = self.picture(
            "surface", self.result, "--range", 0, 1e9
        )  # all in the map's first colour
        height, width, _ = image.shape
        inside = image[int(0.76 * height) : int(0.88 * height), int(0.4 * width) : int(0.5 * width)]
        self.assertLess(np.ptp(inside.reshape(-1, 3), axis=0).max(), 0.02)

    def test_surface_is_written_beside_the_result(self):
        self.assertEqual(call("plot", "surface", self.result).returncode, 0)
        self.assertTrue(self.result.with_suffix(".png").exists())

    def test_surface_from_behind(self):
        self.refused(2, "--back", "surface", self.result, "--from", -1, -1, -1)
        behind = self.picture("surface", self.result, "--from", -1, -1, -1, "--back")
        with h5py.File(self.result, "a") as file:
            del file["VTKHDF/CellData/triangle"]  # which side radiates is not known then
        self.assertTrue(
            (self.picture("surface", self.result, "--from", -1, -1, -1) == behind).all()
        )

    def test_fields_and_bands(self):
        two = synthetic.write(self.folder / "two.vtkhdf", 2, bands=2)
        self.assertIn(
            "irradiance, green",
            self.words("surface", two, "--field", "irradiance", "--band", "green"),
        )
        self.assertIn("radiosity, green", self.words("surface", two, "--band", 1))
        self.refused(2, "red, green", "surface", two, "--band", "blue")
        self.refused(2, "no band", "surface", self.result, "--band", "blue")
        self.refused(2, "radiosity", "surface", self.result, "--field", "heat")

    def test_constant_radiosity(self):
        with h5py.File(self.result, "a") as file:
            file["VTKHDF/PointData/radiosity"][:] = 1.0
        self.assertIn("1.00", self.words("surface", self.result))

    def test_points(self):
        self.assertIn("288 collocation points", self.words("points", self.result))

    def test_arcs_of_two_runs(self):
        made = call("arc_deck", ROOT / "inputs/cube_corner.yml", "--surface", "floor", "-n", 20)
        rows = re.findall(r"name: (arc_\S+), surface: floor, at: \[(.*?)\]", made.stdout)
        names, places = zip(*rows, strict=True)
        at = np.array([[float(x) for x in place.split(",")] for place in places])
        synthetic.write_probes(self.result, list(names), at)
        fine = synthetic.write_probes(
            synthetic.write(self.folder / "fine.vtkhdf", 8), list(names), at
        )
        words = self.words("arcs", self.result, fine)
        for word in ("r = 0.1 m", "r = 0.001 m", "at r = 0.01 m", "288 unknowns", "1152 unknowns"):
            self.assertIn(word, words)
        self.refused(2, "no arc of radius 0.3", "arcs", self.result, "--slope", 0.3)

    def test_arcs_without_probes(self):
        self.refused(3, "polyrad/probes", "arcs", self.result)
        synthetic.write_probes(self.result, ["a"], np.array([[0.1, 0.1, 0]]))
        self.refused(3, "tools/arc_deck", "arcs", self.result)

    def test_studies(self):
        one = synthetic.write_study(self.folder / "one.h5", 0.8)
        two = synthetic.write_study(self.folder / "two.h5", 1.2, "polyrad/study")
        words = self.words("study", one, two, "--labels", "p = 1", "p = 2")
        for word in ("p = 1", "p = 2", "unknowns", "time of a run"):
            self.assertIn(word, words)
        self.refused(2, "1 labels", "study", one, two, "--labels", "only one")
        self.refused(3, "no study", "study", self.result)

    def test_a_study_over_two_keys_has_a_curve_each(self):
        path = self.folder / "two_keys.h5"
        with h5py.File(path, "w") as file:
            file["study/method.mesh"] = np.array(
                ["paper"] * 3 + ["uniform"] * 3, h5py.string_dtype()
            )
            file["study/method.elements"] = [1, 2, 4] * 2
            file["study/unknowns"] = [72, 288, 1152, 9, 36, 144]
            file["study/error"] = [0.03, 0.015, 0.007, 0.1, 0.09, 0.08]
        words = self.words("study", path)
        self.assertIn("mesh paper", words)
        self.assertIn("mesh uniform", words)

    def test_columns_of_a_study(self):
        path = self.folder / "columns.h5"
        with h5py.File(path, "w") as file:
            names = ["a.obj", "b.obj", "c.obj"] * 2
            file["study/scene.mesh.file"] = np.array(names, h5py.string_dtype())
            file["study/method.degree"] = np.array(["1"] * 3 + ["2"] * 3, h5py.string_dtype())
            file["study/unknowns"] = [4.0, 5, 6, 7, 8, 9]
            file["study/error"] = [0.1, 0.2, np.nan, 0.01, 0.02, 0.03]
            file["study/inverse_norm"] = [3.0, 4, 5, 6, 7, 8]
        words = self.words("study", path, "--x", "scene.mesh.file", "--y", "inverse_norm")
        for word in ("degree 1", "degree 2", "norm of the inverse", "a", "c"):
            self.assertIn(word, words)
        two = self.words("study", path, "--x", "unknowns", "--y", "error", "--y", "inverse_norm")
        self.assertIn("largest error", two)
        self.refused(2, "no column 'nothing'", "study", path, "--y", "nothing")

    def test_rules_of_quadrature(self):
        path = self.folder / "rules.csv"
        path.write_text(
            "distance,rule,kernel_values,relative_error\n"
            "0.1,Gauss,4,0.5\n0.1,Gauss,16,0.1\n1e-06,sinh,16,1e-3\n"
        )
        words = self.words("quadrature", path)
        for word in ("distance 0.1", "Gauss", "sinh", "kernel values"):
            self.assertIn(word, words)
        path.write_text("a,b\n1,2\n")
        self.refused(3, "is not a table", "quadrature", path)
        self.refused(3, "cannot be read", "quadrature", self.folder / "nowhere.csv")

    def test_files_that_are_none(self):
        broken = self.folder / "broken.vtkhdf"
        broken.write_text("not HDF5")
        empty = self.folder / "empty.vtkhdf"
        h5py.File(empty, "w").close()
        for kind in ("surface", "points", "arcs", "study"):
            self.refused(3, "no file", kind, "nowhere.vtkhdf")
            self.refused(3, "HDF5", kind, broken)
            self.refused(3, "holds no", kind, empty)

    def test_pictures_that_cannot_be_written(self):
        self.refused(
            3, "cannot be written", "surface", self.result, "-o", self.folder / "no/where.png"
        )
        self.refused(2, ".png", "surface", self.result, "-o", self.folder / "a.xyz")
        self.refused(2, "which picture", "heat", self.result)
