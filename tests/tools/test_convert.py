"""tools/convert and tools/scene: formats, names, cuts along contacts, errors of one sentence."""

import collections
import math
import tempfile
import unittest
from pathlib import Path

import meshio
import numpy as np

from project import ROOT, call

SQUARE = [[0, 0, 0], [2, 0, 0], [2, 2, 0], [0, 2, 0]]


def read(path: Path) -> tuple[np.ndarray, list[tuple[list[int], str]]]:
    """Vertices and faces of an OBJ file as the tools write it."""
    vertices, faces, name = [], [], ""
    for line in path.read_text().splitlines():
        word, _, rest = line.partition(" ")
        if word == "v":
            vertices.append([float(x) for x in rest.split()])
        elif word == "usemtl":
            name = rest
        elif word == "f":
            faces.append(([int(k) - 1 for k in rest.split()], name))
    return np.array(vertices), faces


def areas(path: Path) -> dict[str, float]:
    x, faces = read(path)
    sums: dict[str, float] = collections.defaultdict(float)
    for corners, name in faces:
        p = x[corners] - x[corners[0]]
        sums[name] += float(np.linalg.norm(np.cross(p[1:-1], p[2:]).sum(axis=0))) / 2
    return dict(sums)


def volume(path: Path) -> float:
    """Of the air around which the faces stand, by the divergence theorem."""
    x, faces = read(path)
    return -sum(float(np.linalg.det(x[corners])) for corners, _ in faces) / 6


def open_edges(path: Path) -> int:
    """Edges that are not passed equally often in both directions."""
    _, faces = read(path)
    count: dict[tuple[int, int], int] = collections.Counter()
    for corners, _ in faces:
        for a, b in zip(corners, corners[1:] + corners[:1], strict=True):
            count[min(a, b), max(a, b)] += 1 if a < b else -1
    return sum(n != 0 for n in count.values())


def contacts(path: Path) -> int:
    """Vertices that lie on a face or its edges and are not its corners (to 1e-9)."""
    x, faces = read(path)
    found = 0
    for corners, _ in faces:
        a, b, c = x[corners]
        normal = np.cross(b - a, c - a)
        inside = np.abs((x - a) @ normal) <= 1e-9 * np.linalg.norm(normal)
        for p, q in ((a, b), (b, c), (c, a)):
            inward = np.cross(normal, q - p)
            inside &= (x - p) @ inward >= -1e-9 * np.linalg.norm(inward)
        inside[corners] = False
        found += int(inside.sum())
    return found


def block(low, high, inwards=False) -> list[list[list[float]]]:
    """Six quadrilaterals, normals outwards."""
    faces = []
    for axis in range(3):
        for far in (0, 1):
            face = []
            for i, j in ((0, 0), (1, 0), (1, 1), (0, 1)):
                corner = [0.0] * 3
                corner[axis] = (low, high)[far][axis]
                corner[(axis + 1) % 3] = (low, high)[i][(axis + 1) % 3]
                corner[(axis + 2) % 3] = (low, high)[j][(axis + 2) % 3]
                face.append(corner)
            faces.append(face if bool(far) != inwards else face[::-1])
    return faces


class Tool(unittest.TestCase):
    def setUp(self):
        holder = tempfile.TemporaryDirectory()
        self.addCleanup(holder.cleanup)
        self.folder = Path(holder.name)
        self.out = self.folder / "out.obj"

    def refused(self, code: int, expected: str, tool: str, *arguments):
        made = call(tool, *arguments, folder=self.folder)
        self.assertEqual(made.returncode, code, made.stderr)
        self.assertEqual(len(made.stderr.splitlines()), 1, made.stderr)
        self.assertIn(expected, made.stderr)

    def convert(self, *arguments):
        made = call("convert", *arguments, "-o", self.out, folder=self.folder)
        self.assertEqual((made.returncode, made.stderr), (0, ""))


class Formats(Tool):
    def mesh(self, **more) -> meshio.Mesh:
        points = [*SQUARE, [0, 0, 1 / 3], [2, 0, 1 / 3]]
        return meshio.Mesh(
            points, [("triangle", [[0, 1, 2], [0, 2, 3], [0, 5, 1], [0, 4, 5]])], **more
        )

    def test_formats_keep_shape_and_orientation(self):
        for name in ("a.stl", "a.ply", "a.vtk", "a.vtu", "a.msh"):
            self.mesh().write(self.folder / name)
            self.convert(name)
            x, faces = read(self.out)
            self.assertEqual([surface for _, surface in faces][:1], ["a"], name)
            first = x[faces[0][0]]
            np.testing.assert_allclose(np.cross(*(first[1:] - first[0])), [0, 0, 4], atol=1e-6)
            self.assertAlmostEqual(areas(self.out)["a"], 4 + 2 / 3, delta=1e-6)
            if name != "a.stl":  # single precision
                self.assertIn(1 / 3, x[:, 2])

    def test_physical_groups_become_names(self):
        tags = np.array([7, 7, 9, 9])
        mesh = self.mesh(
            cell_data={"gmsh:physical": [tags], "gmsh:geometrical": [tags + 1]},
            field_data={"floor": np.array([7, 2]), "blue wall": np.array([9, 2]), "edge": [9, 1]},
        )
        mesh.write(self.folder / "room.msh", file_format="gmsh22")
        self.convert("room.msh")
        sums = areas(self.out)
        self.assertEqual(sorted(sums), ["blue wall", "floor"])
        self.assertAlmostEqual(sums["floor"], 4)

    def test_cell_data_become_names(self):
        data = {"part": [np.array([1, 1, 2, 2])], "heat": [np.array([0.5, 1, 1, 1])]}
        self.mesh(cell_data=data).write(self.folder / "a.vtu")
        self.convert("a.vtu", "--surfaces", "part")
        self.assertEqual(sorted(areas(self.out)), ["part_1", "part_2"])
        self.refused(2, "there are: part, heat", "convert", "a.vtu", "--surfaces", "x")
        self.refused(2, "whole number", "convert", "a.vtu", "--surfaces", "heat")

    def test_volumes_are_left_out(self):
        points = [*SQUARE, [0, 0, 1.0]]
        cells = [("tetra", [[0, 1, 2, 4]]), ("quad", [[0, 1, 2, 3]]), ("line", [[0, 1]])]
        meshio.Mesh(points, cells).write(self.folder / "a.vtk")
        self.convert("a.vtk")
        self.assertEqual([corners for corners, _ in read(self.out)[1]], [[0, 1, 2, 3]])
        meshio.Mesh(points, cells[:1]).write(self.folder / "b.vtk")
        self.refused(3, "only tetra", "convert", "b.vtk")

    def test_errors(self):
        self.refused(2, "which file", "convert")
        for name in ("no.stl", "no.obj"):
            self.refused(3, "no.", "convert", name, "-o", "x.obj")
        for name in ("a.stl", "a.ply", "a.msh", "a.vtk", "a.vtu", "a.xyz"):
            (self.folder / name).write_bytes(b"rubbish \xff\x00")
            self.refused(3, name, "convert", name)
        (self.folder / "a.obj").write_text("v 0 0 0\nv 1 0 0\nf 1 2 3\n")
        self.refused(3, "a.obj:3:", "convert", "a.obj", "-o", "b.obj")
        self.refused(2, "overwritten", "convert", "a.obj")
        self.mesh().write(self.folder / "b.stl")
        self.refused(3, "cannot be written", "convert", "b.stl", "-o", "no/where.obj")
        self.refused(2, "--tolerance", "convert", "b.stl", "--tolerance", 1)


class Conform(Tool):
    def conform(self, faces: dict[str, list], *arguments) -> dict[str, float]:
        rows, n = [], 0
        for name, quads in faces.items():
            rows.append(f"usemtl {name}")
            for quad in quads:
                rows += ["v {!r} {!r} {!r}".format(*map(float, x)) for x in quad]
                rows.append("f " + " ".join(str(n + k + 1) for k in range(len(quad))))
                n += len(quad)
        (self.folder / "in.obj").write_text("\n".join(rows) + "\n")
        self.convert("in.obj", "--conform", *arguments)
        self.assertEqual(contacts(self.out), 0)
        return areas(self.out)

    def test_block_on_the_floor(self):
        inner = block((0.5, 0.5, 0), (1, 1.5, 1))
        sums = self.conform({"room": block((0, 0, 0), (2, 2, 2), True), "block": inner})
        self.assertAlmostEqual(sums["room"], 24 - 0.5, delta=1e-12)
        self.assertAlmostEqual(sums["block"], 0.5 + 3, delta=1e-12)
        self.assertEqual(open_edges(self.out), 0)
        self.assertAlmostEqual(volume(self.out), 8 - 0.5, delta=1e-12)

    def test_block_turned_and_in_a_corner(self):
        c, s = math.cos(0.3), math.sin(0.3)
        turned = [
            [[1 + c * x - s * y, 1 + s * x + c * y, z] for x, y, z in face]
            for face in block((-0.4, -0.3, 0), (0.4, 0.3, 0.7))
        ]
        corner = block((0, 0, 0), (0.2, 0.3, 0.4))
        sums = self.conform(
            {"room": block((0, 0, 0), (2, 2, 2), True), "a": turned, "b": corner},
            "--tolerance",
            1e-9,
        )
        self.assertEqual(open_edges(self.out), 0)
        self.assertAlmostEqual(volume(self.out), 8 - 0.8 * 0.6 * 0.7 - 0.024, delta=1e-9)
        self.assertAlmostEqual(sums["b"], 0.2 * 0.3 + 0.2 * 0.4 + 0.3 * 0.4, delta=1e-9)

    def test_lamp_in_the_ceiling(self):
        lamp = [[0.5, 0.5, 0], [0.7, 0.5, 0], [0.7, 0.9, 0], [0.5, 0.9, 0]]
        for order in (("lamp", "ceiling"), ("ceiling", "lamp")):
            quads = {"lamp": [lamp], "ceiling": [SQUARE]}
            sums = self.conform({name: quads[name] for name in order})
            self.assertAlmostEqual(sums["lamp"], 0.08, delta=1e-12)
            self.assertAlmostEqual(sums["ceiling"], 3.92, delta=1e-12)

    def test_of_equal_faces_the_later_stays(self):
        self.assertEqual(self.conform({"old": [SQUARE], "new": [SQUARE]}), {"new": 4.0})

    def test_fin_on_the_floor(self):
        fin = [[0.5, 0.5, 0], [1.5, 1.2, 0], [1.5, 1.2, 1], [0.5, 0.5, 1]]
        sums = self.conform({"floor": [SQUARE], "fin": [fin]})
        self.assertAlmostEqual(sums["floor"], 4, delta=1e-12)
        x, faces = read(self.out)
        foot = {k for k, p in enumerate(x.tolist()) if p in fin[:2]}
        self.assertEqual(sum(foot <= set(corners) for corners, _ in faces), 3)

    def test_tip_on_the_floor(self):
        tip = [[1, 1.1, 0], [1.5, 1.2, 1], [0.5, 0.5, 1]]
        sums = self.conform({"floor": [SQUARE], "tip": [tip]})
        self.assertAlmostEqual(sums["floor"], 4, delta=1e-12)
        self.assertGreater(len(read(self.out)[1]), 4)

    def test_faces_that_pierce_each_other(self):
        blade = [[1, -1, -1], [1, 3, -1], [1, 3, 1], [1, -1, 1]]
        sums = self.conform({"floor": [SQUARE], "blade": [blade]})
        self.assertAlmostEqual(sums["floor"], 4, delta=1e-12)
        self.assertAlmostEqual(sums["blade"], 8, delta=1e-12)

    def test_parts_of_edges(self):
        wall = [
            [[0, 0, 0], [0, 0, 1], [1, 0, 1], [1, 0, 0]],
            [[1, 0, 0], [1, 0, 1], [2, 0, 1], [2, 0, 0]],
        ]
        self.conform({"floor": [SQUARE], "wall": wall})
        x, faces = read(self.out)
        self.assertEqual(len(x), 4 + 3 + 1)
        self.assertEqual(len(faces), 4 + 3)

    def test_noise_below_the_tolerance(self):
        rng = np.random.default_rng(2003)
        faces = {
            "room": block((0, 0, 0), (2, 2, 2), True),
            "block": block((0.5, 0.5, 0), (1, 1.5, 1)),
        }
        noisy = {
            name: [[[x + rng.uniform(-1e-8, 1e-8) for x in p] for p in quad] for quad in quads]
            for name, quads in faces.items()
        }
        sums = self.conform(noisy)
        self.assertEqual(open_edges(self.out), 0)
        self.assertAlmostEqual(sums["room"], 23.5, delta=1e-5)

    def test_conforming_scenes_stay(self):
        faces = block((0, 0, 0), (2, 2, 2), True)
        self.conform({"room": faces})
        self.assertEqual(len(read(self.out)[1]), 12)
        self.assertEqual(len(read(self.out)[0]), 8)

    def test_crossed_faces_are_refused(self):
        (self.folder / "in.obj").write_text(
            "v 0 0 0\nv 3 0 0\nv 1 2 0\nv 1 -1 0\nusemtl bow\nf 1 2 3 4\n"
        )
        self.refused(3, "a face of 'bow' crosses", "convert", "in.obj", "--conform", "-o", "x.obj")


class Scenes(Tool):
    def scene(self, *arguments):
        made = call("scene", *arguments, "-o", self.out)
        self.assertEqual((made.returncode, made.stderr), (0, ""))

    def test_cornell_box(self):
        self.scene("cornell")
        self.assertEqual(contacts(self.out), 0)
        sums = areas(self.out)
        self.assertAlmostEqual(sums["lamp"], 130 * 105, delta=1e-6)
        self.assertAlmostEqual(sums["ceiling"], 556 * 559.2 - 130 * 105, delta=1e-6)
        self.assertEqual(self.out.read_text(), (ROOT / "inputs/cornell_box.obj").read_text())

    def test_street(self):
        self.scene("street")
        self.assertEqual((contacts(self.out), open_edges(self.out)), (0, 0))
        self.assertAlmostEqual(areas(self.out)["street"], 600, delta=1e-9)
        self.assertEqual(self.out.read_text(), (ROOT / "inputs/street_canyon.obj").read_text())

    def test_room(self):
        self.scene("room", "--triangles", 1500)
        self.assertEqual(self.out.read_text(), (ROOT / "inputs/room.obj").read_text())
        self.scene("room", "--triangles", 2000)
        self.assertEqual((contacts(self.out), open_edges(self.out)), (0, 0))
        self.assertAlmostEqual(len(read(self.out)[1]), 2000, delta=2)
        sums = areas(self.out)
        self.assertAlmostEqual(sums["window"], 1.6 * 1.2, delta=1e-9)
        self.assertAlmostEqual(sums["ceiling"], 20 - 0.8 * 0.6, delta=1e-9)
        self.refused(2, "at least", "scene", "room", "--triangles", 5, "-o", "x.obj")

    def test_scenes_of_the_stability_studies(self):
        folder = ROOT / "inputs/studies/stability"
        for angle in (1, 170):
            self.scene("wedge", "--angle", angle)
            self.assertEqual(self.out.read_text(), (folder / f"wedge_{angle}.obj").read_text())
        self.scene("vertex", "--faces", 5)
        self.assertEqual(self.out.read_text(), (folder / "vertex_5.obj").read_text())
        self.scene("vertex", "--faces", 12, "--dent")
        self.assertEqual(self.out.read_text(), (folder / "dent_12.obj").read_text())
        self.refused(2, "--faces", "scene", "vertex", "--faces", 3, "--dent", "-o", "x.obj")
        self.refused(2, "--angle", "scene", "wedge", "--angle", 0, "-o", "x.obj")

    def test_box(self):
        for inner in ((), ("--inner",)):
            self.scene("box", "--n", 3, *inner)
            self.assertEqual(len(read(self.out)[1]), 108 * (1 + len(inner)))
            self.assertEqual((contacts(self.out), open_edges(self.out)), (0, 0))
            self.assertAlmostEqual(volume(self.out), 1 - len(inner) / 64, delta=1e-12)
        self.refused(2, "--n", "scene", "box", "--n", 0, "-o", "x.obj")
        self.refused(2, "which scene", "scene", "house")
        self.refused(3, "cannot be written", "scene", "cornell", "-o", "no/where.obj")


if __name__ == "__main__":
    unittest.main()
