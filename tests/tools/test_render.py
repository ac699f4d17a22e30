"""tools/render: pictures show what the file holds, pages draw in a browser, VTK reads the files."""

import base64
import os
import re
import shutil
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path
from unittest import mock

import h5py
import matplotlib.image
import numpy as np

import synthetic
from project import ROOT, call

sys.path.insert(0, str(ROOT / "tools/python"))

SIDES = ["-x", "+x", "-y", "+y", "-z", "+z"]
COLORS = np.array([[5, 1, 1], [1, 5, 1], [1, 1, 5], [4, 4, 1], [1, 4, 4], [4, 1, 4]]) / 10
CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser")
FLAGS = """--headless --no-sandbox --disable-gpu --enable-unsafe-swiftshader --hide-scrollbars
    --disable-quic --no-first-run --disable-background-networking --disable-component-update
    --disable-sync --window-size=400,400""".split()


def setUpModule():
    """tools/render installs what it needs; without that no test makes sense."""
    global light, render, surfaces, Problem, Result
    with tempfile.TemporaryDirectory() as folder:
        path = synthetic.write(Path(folder, "a.vtkhdf"), 1)
        made = call("render", path, "--size", "200x100")
        if made.returncode == 3:
            raise unittest.SkipTest(made.stderr.strip())
        assert made.returncode == 0, made.stderr
        assert path.with_suffix(".png").exists()
    import light
    import render
    import surfaces
    from result import Problem, Result


def run(*arguments) -> None:
    """tools/render in this process, which saves the time of loading VTK."""
    with mock.patch("sys.argv", ["render", *map(str, arguments)]):
        render.main()


def screen(color) -> np.ndarray:
    """What a colour is in the picture, with --exposure 1."""
    return light.srgb(light.rolled(np.asarray(color, float)))


class Folder(unittest.TestCase):
    def setUp(self):
        holder = tempfile.TemporaryDirectory()
        self.addCleanup(holder.cleanup)
        self.folder = Path(holder.name)

    def picture(self, *arguments) -> np.ndarray:
        """The picture's pixels, [row, column, red green blue]."""
        out = self.folder / "out.png"
        run(*arguments, "-o", out)
        return matplotlib.image.imread(out)[:, :, :3]

    def box(self, sides=SIDES, bands=("red", "green", "blue"), name="box.vtkhdf") -> Path:
        color = COLORS[[SIDES.index(side) for side in sides]]
        color = color[:, [synthetic.BANDS.index(band.lower()) for band in bands]]
        return synthetic.write_box(self.folder / name, sides, color, list(bands))

    def near(self, pixel, color, message=None):
        self.assertLess(np.abs(pixel - screen(color)).max(), 1.5 / 255, message)


class Photographs(Folder):
    def test_one_looks_into_the_open_side(self):
        for i, missing in enumerate(SIDES):
            path = self.box([side for side in SIDES if side != missing])
            image = self.picture(path, "--exposure", 1, "--size", "120x100")
            self.assertEqual(image.shape, (100, 120, 3))
            self.near(image[50, 60], COLORS[i ^ 1], f"{missing}: the opposite side")
            self.near(image[50, 1], [9, 9, 9], f"{missing}: white beside the box")

    def test_sides_of_an_open_box_are_where_they_belong(self):
        image = self.picture(
            self.box(SIDES[1:]), "--exposure", 1, "--size", "100x100", "--background", "black"
        )
        # From -x with z up: +y is to the left.
        for at, side in {(50, 5): "+y", (50, 95): "-y", (5, 50): "+z", (95, 50): "-z"}.items():
            self.near(image[at], COLORS[SIDES.index(side)], side)
        self.near(image[0, 0], [0, 0, 0])

    def test_camera_of_the_deck(self):
        """What output.camera says is as if the options said it; options go first."""
        path = self.box()
        asked = self.picture(path, "--size", "60x60", "--from", "0.5,-2,0.5", "--up", "1,0,0", "--angle", 30)
        with h5py.File(path, "a") as file:
            nan = [float("nan")] * 3
            file["polyrad/camera"] = [0.5, -2, 0.5, *nan, 1, 0, 0, 30]
        np.testing.assert_array_equal(self.picture(path, "--size", "60x60"), asked)
        other = self.picture(path, "--size", "60x60", "--from", "0.5,0.4,5", "--angle", 20, "--up", "0,1,0")
        with h5py.File(path, "a") as file:
            del file["polyrad/camera"]
        plain = self.picture(path, "--size", "60x60", "--from", "0.5,0.4,5", "--angle", 20, "--up", "0,1,0")
        np.testing.assert_array_equal(other, plain)
        self.assertFalse(np.array_equal(asked, plain))

    def test_closed_rooms_are_seen_from_outside_and_inside(self):
        path = self.box()
        common = ["--exposure", 1, "--size", "64x64"]
        above = self.picture(path, *common, "--from", 0.5, 0.4, 5)
        self.near(above[32, 32], COLORS[4], "through the ceiling to the floor")
        inside = self.picture(path, *common, "--from", "0.5,0.5,0.5", "--to=0.5,2,0.5")
        self.near(inside[32, 32], COLORS[3])
        tilted = self.picture(path, *common, "--from", 0.5, -2, 0.5, "--up", "1,0,0", "--angle", 30)
        self.near(tilted[3, 32], COLORS[1], "+x is above")

    def test_bands_in_any_order(self):
        sides = SIDES[1:]
        usual = self.picture(self.box(sides))
        for bands in (("blue", "red", "green"), ("Green", "BLUE", "Red")):
            self.assertTrue((self.picture(self.box(sides, bands)) == usual).all(), bands)

    def test_automatic_exposure_knows_no_unit_and_no_lamp(self):
        path = self.box(SIDES[1:])
        usual = self.picture(path)
        with h5py.File(path, "a") as file:
            file["VTKHDF/PointData/radiosity"][:] *= 1e6
        other = self.picture(path)
        self.assertLess(np.abs(other - usual).max(), 1.5 / 255)
        with h5py.File(path, "a") as file:
            u = file["VTKHDF/PointData/radiosity"]
            bright = u[:] * (1 + 1e3 * (np.arange(len(u)) >= len(u) - 4)[:, None])
            u[:] = bright
            file["VTKHDF/PointData/emission"] = np.where(bright > 1e7, bright, 0)
        lamp = self.picture(path)
        self.assertLess(np.abs(lamp[400, 400] - usual[400, 400]).max(), 0.1)
        self.assertGreater(lamp[5, 400].min(), 0.99)

    def test_fine_gradients_have_no_steps_or_gaps(self):
        path = synthetic.write(self.folder / "corner.vtkhdf", 6, bands=3)
        image = self.picture(path, "--background", "magenta")
        height, width, _ = image.shape
        inside = image[int(0.8 * height) : int(0.9 * height), int(0.4 * width) : int(0.6 * width)]
        self.assertLess(np.abs(np.diff(inside, axis=0)).max(), 0.03)
        self.assertLess(np.abs(np.diff(inside, axis=1)).max(), 0.03)


class Maps(Folder):
    def setUp(self):
        super().setUp()
        self.path = synthetic.write(self.folder / "corner.vtkhdf", 4)

    def test_values_in_order_and_a_bar(self):
        image = self.picture(self.path, "--size", "620x500")
        self.assertEqual(image.shape, (500, 620, 3))
        # From (1,1,1): y = 0 (darkest) to the left, x = 0 (brightest) right, floor below.
        left, right, floor = image[[250, 250, 400], [190, 310, 250]].sum(axis=1)
        self.assertTrue(left < floor < right, (left, floor, right))
        bar = image[80:420, 525].sum(axis=1)
        self.assertTrue((np.diff(bar[10:-10]) <= 0.02).all())
        self.assertGreater(bar[10] - bar[-10], 1)

    def test_range_and_logarithm(self):
        low = self.picture(self.path, "--range", 1e8, 1e9, "--size", "300x200")
        ember = matplotlib.image.imread(self.folder / "out.png")[150, 88, :3]
        self.assertLess(np.abs(low[150, 88] - ember).max(), 1e-6)
        self.assertLess(low[150, 88].sum(), 0.6, "the map's dark end")
        linear = self.picture(self.path, "--size", "300x200", "--range", 0.01, 2)
        log = self.picture(self.path, "--size", "300x200", "--range", 0.01, 2, "--log")
        self.assertGreater(log[150, 88].sum(), linear[150, 88].sum() + 0.3)

    def test_bands_and_fields(self):
        three = synthetic.write(self.folder / "three.vtkhdf", 2, bands=3)
        photograph = self.picture(three, "--field", "irradiance")
        band = self.picture(three, "--band", "green")
        number = self.picture(three, "--band", 1)
        self.assertTrue((band == number).all())
        self.assertGreater(np.abs(photograph - band).max(), 0.3)

    def test_indicator_of_cells(self):
        with h5py.File(self.path, "a") as file:
            file["VTKHDF/CellData/error_bound"] = np.resize([1e-5, 1e-2], 6 * 3 * 16)
            file["VTKHDF/CellData/error_bound"].attrs["unit"] = "W/m2"
        image = self.picture(self.path, "--field", "error_bound", "--log", "--colors", "gray")
        scene = image[:, : image.shape[1] - 120].reshape(-1, 3)
        dark, bright = (scene.max(axis=1) < 0.01).sum(), (scene.min(axis=1) > 0.99).sum()
        self.assertGreater(dark, 0.1 * len(scene))
        self.assertGreater(dark + bright, 0.8 * len(scene), "flat in each cell")

    def test_constants_and_gaps(self):
        with h5py.File(self.path, "a") as file:
            u = file["VTKHDF/PointData/radiosity"]
            u[:] = 1.0
            u[: len(u) // 3] = np.nan  # not computed on the floor
        image = self.picture(self.path, "--size", "300x200")
        self.assertGreater(image[150, 88].min(), 0.99, "background where nothing is known")


class Lines(Folder):
    def test_outlines_of_an_element(self):
        # 2 x 2 cells in a fan about the origin, each with its own tip, then one quadrilateral.
        points = [[0, 0], [0, 0], [0, 0], [1, 0], [1, 1], [0, 1], [2, 0], [2, 2], [0, 2]]
        points += [[2, 0], [3, 0], [3, 2], [2, 2]]
        cells = [[0, 4, 3], [1, 5, 4], [3, 4, 7, 6], [4, 5, 8, 7], [9, 10, 11, 12]]
        path = self.folder / "fan.h5"
        with h5py.File(path, "w") as file:
            file["VTKHDF/Points"] = np.insert(np.array(points, float), 2, 0, axis=1)
            file["VTKHDF/Connectivity"] = np.concatenate(cells)
            file["VTKHDF/Offsets"] = np.cumsum([0, *map(len, cells)])
        result = Result(str(path))
        found, _ = surfaces.element_lines(result, surfaces.Surfaces.of(result, np.full(5, True)))
        length = np.linalg.norm(found[:, 1] - found[:, 0], axis=1).sum()
        self.assertEqual(len(found), 2 + 2 + 2 + 4)
        self.assertAlmostEqual(length, 4 + 4 + 6)

    def test_lines_are_drawn_and_hidden(self):
        path = self.box(SIDES[1:])
        without = self.picture(path, "--size", "200x200")
        drawn = self.picture(path, "--size", "200x200", "--mesh", "triangles")
        elements = self.picture(path, "--size", "200x200", "--mesh", "elements")
        changed = (np.abs(drawn - without).max(axis=2) > 0.05).sum()
        fewer = (np.abs(elements - without).max(axis=2) > 0.05).sum()
        self.assertTrue(200 < fewer < changed < 4000, (fewer, changed))
        closed = self.box(name="closed.vtkhdf")
        view = ["--size", "100x100", "--from", 0.5, 0.5, -4]
        change = np.abs(
            self.picture(closed, *view, "--mesh", "triangles") - self.picture(closed, *view)
        )
        self.assertGreater(change.max(), 0.1)
        self.assertEqual(change[30, 50].max(), 0, "no line of the wall that is looked through")


class Pages(Folder):
    def page(self, *arguments) -> Path:
        path = self.folder / "page.html"
        run(*arguments, "--html", path)
        return path

    def screenshot(self, page: Path) -> np.ndarray:
        if not CHROMIUM:
            self.skipTest("no Chromium here (apt-get install chromium): the page was not drawn")
        out = self.folder / "page.png"
        command = [CHROMIUM, *FLAGS, f"--user-data-dir={self.folder / 'profile'}"]
        command += [f"--screenshot={out}", page.as_uri()]
        made = subprocess.run(command, capture_output=True, text=True, timeout=900)
        self.assertTrue(out.exists(), made.stderr)
        return matplotlib.image.imread(out)[:, :, :3]

    def test_a_page_needs_nothing_else_and_holds_the_scene(self):
        path = self.box(SIDES[1:])
        with h5py.File(path, "a") as file:
            file["polyrad"].attrs["deck"] = "title: </script> & co\n"
        text = self.page(path).read_text()
        self.assertNotRegex(text, r"https?://|src=|@import|<link")
        self.assertEqual(text.count("</script>"), 1)
        point = np.frombuffer(base64.b64decode(re.search(r'"point": "([^"]+)"', text)[1]), "<f4")
        self.assertEqual(point.shape, (5 * 5 * 3,))
        self.assertEqual(np.abs(point).max(), 0.5)
        self.assertFalse(path.with_suffix(".png").exists(), "--html alone makes no picture")

    def test_a_photograph_in_a_browser_is_the_picture(self):
        path = self.box(SIDES[1:])
        options = ["--size", "400x400", "--background", "black"]
        shown, picture = self.screenshot(self.page(path, *options)), self.picture(path, *options)
        self.assertGreater(len(np.unique(shown.reshape(-1, 3), axis=0)), 5)
        far = np.abs(shown - picture)[40:360].max(axis=2) > 2 / 255
        self.assertLess(far.mean(), 0.02, "but for the smoothing of edges")

    def test_a_map_in_a_browser_can_be_turned(self):
        page = self.page(synthetic.write(self.folder / "corner.vtkhdf", 3), "--mesh", "elements")
        before = self.screenshot(page)
        self.assertGreater(len(np.unique(before.reshape(-1, 3), axis=0)), 50)
        bar = before[60:340, -93].sum(axis=1)
        self.assertGreater(bar[0] - bar[-1], 1)
        drag = """<script>
          const hand = (name, x) => canvas.dispatchEvent(
            new PointerEvent(name, { pointerId: 1, clientX: x, clientY: 200, buttons: 1 }));
          hand("pointerdown", 100); hand("pointermove", 300); hand("pointerup", 300); paint();
        </script>"""
        page.write_text(page.read_text().replace("</html>", drag + "</html>"))
        after = self.screenshot(page)
        self.assertGreater((np.abs(after - before)[:, :270].max(axis=2) > 0.1).mean(), 0.1)


class Readers(Folder):
    def read(self, path: Path):
        """By VTK's own reader, as ParaView does."""
        from vtkmodules.vtkIOHDF import vtkHDFReader

        reader = vtkHDFReader()
        self.assertTrue(reader.CanReadFile(str(path)))
        reader.SetFileName(str(path))
        reader.Update()
        return reader.GetOutput()

    def test_vtk_reads_what_the_other_tests_use(self):
        grid = self.read(synthetic.write(self.folder / "corner.vtkhdf", 2, bands=3))
        self.assertEqual((grid.GetNumberOfPoints(), grid.GetNumberOfCells()), (288, 72))
        self.assertEqual(grid.GetPointData().GetArray("radiosity").GetNumberOfComponents(), 3)

    def test_vtk_and_render_read_a_result(self):
        program = Path(os.environ.get("POLYRAD", ROOT / "build/release/polyrad"))
        if not program.exists():
            self.skipTest(f"no program {program}")
        path = self.folder / "cube.vtkhdf"
        command = [program, "run", ROOT / "inputs/cube_corner.yml", "--quiet", "-o", path]
        subprocess.run(command, check=True, timeout=900)
        grid = self.read(path)
        with h5py.File(path) as file:
            for kind, data in {
                "PointData": grid.GetPointData(),
                "CellData": grid.GetCellData(),
            }.items():
                names = [data.GetArrayName(i) for i in range(data.GetNumberOfArrays())]
                self.assertEqual(sorted(names), sorted(file[f"VTKHDF/{kind}"]))
                for name in ("radiosity", "irradiance", "emission", "rho", "surface"):
                    expected = file[f"VTKHDF/{kind}/{name}"][()]
                    array = data.GetArray(name)
                    found = np.array([array.GetTuple1(i) for i in range(len(expected))])
                    self.assertTrue(np.array_equal(found, expected, equal_nan=True), name)
            self.assertIn("error_bound", file["VTKHDF/CellData"])
            self.assertEqual(grid.GetNumberOfCells(), len(file["VTKHDF/Types"]))
        low, high = np.reshape(grid.GetBounds(), (3, 2)).T
        self.assertLess(np.abs(low).max() + np.abs(high - 1).max(), 1e-12)
        self.assertGreater(np.ptp(self.picture(path, "--mesh", "elements")), 0.5)
        self.picture(path, "--field", "error_bound", "--log")


class Refusals(Folder):
    def refused(self, code: int, expected: str, *arguments):
        with self.subTest(arguments=arguments), self.assertRaises(Problem) as caught:
            run(*arguments)
        self.assertIn(expected, str(caught.exception))
        self.assertEqual(caught.exception.code, code)

    def test_options(self):
        path = synthetic.write(self.folder / "corner.vtkhdf", 1)
        for expected, *arguments in (
            ("irradiance, radiosity", "--field", "heat"),
            ("no band 'blue'", "--band", "blue"),
            ("same point", "--from", "1,1,1", "--to", "1,1,1"),
            ("radiating side", "--from", "-1,-1,-1"),
            ("line of sight", "--up", "1,1,1"),
            ("line of sight", "--up", "0,0,0"),
            ("three numbers", "--from", "1,2"),
            ("800x600", "--size", "big"),
            ("8192", "--size", "9000x10"),
            ("136", "--size", "130x100"),
            ("MIN < MAX", "--range", 2, 1),
            ("above 0", "--log", "--range", 0, 1),
            ("no colour", "--background", "loud"),
            ("colour map", "--colors", "loud"),
            (".png", "-o", "a.jpg"),
            ("--nonsense", "--nonsense"),
        ):
            self.refused(2, expected, path, *arguments)

    def test_files(self):
        path = synthetic.write(self.folder / "corner.vtkhdf", 1)
        broken, empty = self.folder / "broken.vtkhdf", self.folder / "empty.vtkhdf"
        broken.write_text("not HDF5")
        h5py.File(empty, "w").close()
        self.refused(3, "no file", self.folder / "nowhere.vtkhdf")
        self.refused(3, "HDF5", broken)
        self.refused(3, "holds no", empty)
        self.refused(3, "cannot be written", path, "-o", self.folder / "no/where.png")
        self.refused(3, "cannot be written", path, "--html", self.folder / "no/where.html")

    def test_one_sentence_and_a_code(self):
        path = synthetic.write(self.folder / "corner.vtkhdf", 1)
        hidden = {"__EGL_VENDOR_LIBRARY_DIRS": "/nonexistent"}
        for code, expected, environment, *arguments in (
            (2, "which result file", {}),
            (2, "three numbers", {}, path, "--from", "1,2"),
            (3, "no file", {}, "nowhere.vtkhdf"),
            (3, "libegl1", hidden, path),
        ):
            with mock.patch.dict(os.environ, environment):
                made = call("render", *arguments, folder=self.folder)
            self.assertEqual(made.returncode, code, made.stderr)
            self.assertEqual(len(made.stderr.splitlines()), 1, made.stderr)
            self.assertIn(expected, made.stderr)
        self.assertFalse(path.with_suffix(".png").exists())
