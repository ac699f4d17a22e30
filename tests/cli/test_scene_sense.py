"""Scenes that make no sense: what is said of them, and the exit code, in `check` and in `run`."""

import itertools
import unittest

from test_cli import Case

AXES = ((0, 1, 2), (1, 2, 0), (2, 0, 1))


def cube(inwards, optics):
    """Twelve triangles of the unit cube, one a line, from line 3 on; surfaces w0 to w5."""
    lines = ["scene:", "  triangles:"]
    for number, (far, (x, y, z)) in enumerate(itertools.product((0, 1), AXES)):
        corner = []
        for a, b in ((0, 0), (1, 0), (1, 1), (0, 1)):
            point = [0, 0, 0]
            point[x], point[y], point[z] = a, b, far
            corner.append(point)
        for half in ([0, 1, 2], [0, 2, 3]):
            order = half if bool(far) != inwards else half[::-1]
            lines.append(f"    - {{name: w{number}, vertices: {[corner[k] for k in order]}, {optics}}}")
    return "\n".join(lines) + "\n"


def face(name, vertices, more=""):
    return f"    - {{name: {name}, vertices: {vertices}, {more}}}\n"


WHITE = "rho: 0.8, emission: 0.2"
LOW = "[[0.2, 0.2, 0], [0.8, 0.2, 0], [0.2, 0.8, 0]]"
HOT = "emissivity: 0.8, temperature: 1000"
ROOM = "method: {mesh: uniform, elements: 1, degree: 0}\n"
SHIELD = """scene:
  triangles:
    - {name: hot, vertices: [[0,0,0],[10,0,0],[10,10,0]]}
    - {name: cold, vertices: [[0,10,0.2],[10,10,0.2],[10,0,0.2]]}
    - {name: shield, vertices: [[0,0,0.1],[10,0,0.1],[10,10,0.1]], side: both}
    - {name: shield, vertices: [[0,0,0.1],[10,10,0.1],[0,10,0.1]], side: both}
  surfaces:
    hot: {emissivity: 0.8, temperature: 1000}
    cold: {emissivity: 0.8, temperature: 300}
    shield: {emissivity: 0.1, flux: 0}
method: {mesh: uniform, elements: 1, degree: 0}
"""


class Sense(Case):
    def refused_both(self, deck, *words):
        self.write("deck.yml", deck)
        for verb in "check", "run":
            text = self.refused(2, verb, "deck.yml", threads=1)
            for word in words:
                self.assertIn(word, text)
            self.assertEqual(self.files(), ["deck.yml"])

    def warned(self, deck):
        """Lines on stderr, the same in both verbs, which end well."""
        self.write("deck.yml", deck)
        said = []
        for verb in ["check"], ["run", "--quiet"]:
            p = self.call(verb[0], "deck.yml", *verb[1:], threads=1)
            self.assertEqual(p.returncode, 0, p.stderr)
            said.append(p.stderr)
        self.assertEqual(*said)
        return said[0].splitlines()

    def test_rug(self):
        self.refused_both(cube(True, WHITE) + face("rug", LOW, WHITE) + ROOM,
                          "deck.yml:15: error: triangle 13 (rug): overlaps triangle 1 (w0, line 3), in the same "
                          "plane and facing the same way", "would count twice; delete one",
                          "tools/convert --conform", "1 more pair of triangles overlaps\n")

    def test_rug_of_two_sides(self):
        turned = "[[0.2, 0.2, 0], [0.2, 0.8, 0], [0.8, 0.2, 0]]"
        self.refused_both(cube(True, WHITE) + face("rug", turned, WHITE + ", side: both") + ROOM, "(rug): overlaps")
        self.assertEqual(self.warned(cube(True, WHITE) + face("bottom", turned, WHITE) + ROOM), [])

    def test_rug_above(self):
        """Higher than the tolerance it hides the floor, and nothing is said."""
        for height, refused in (1e-10, True), (1e-8, False):
            above = f"[[0.2, 0.2, {height:.1e}], [0.8, 0.2, {height:.1e}], [0.2, 0.8, {height:.1e}]]"
            self.write("deck.yml", cube(True, WHITE) + face("rug", above, WHITE))
            p = self.call("check", "deck.yml", threads=1)
            self.assertEqual((p.returncode, "overlaps" in p.stderr), (2, True) if refused else (0, False))

    def test_two_diagonals(self):
        floor = ("[[0,0,0],[1,0,0],[1,1,0]]", "[[0,0,0],[1,1,0],[0,1,0]]",
                 "[[0,0,0],[1,0,0],[0,1,0]]", "[[1,0,0],[1,1,0],[0,1,0]]")
        deck = "scene:\n  triangles:\n" + "".join(face("floor", v, "rho: 0, emission: 1") for v in floor)
        self.refused_both(deck, "deck.yml:5: error: triangle 3 (floor): overlaps triangle 1 (floor, line 3)",
                          "3 more pairs of triangles overlap\n")
        above = face("top", "[[0,0,1],[0,1,1],[1,1,1]]", "rho: 0, emission: 1")
        below = face("under", "[[0,0,-1],[1,0,-1],[1,1,-1]]", "rho: 0, emission: 1")
        self.assertEqual(self.warned(
            "scene:\n  triangles:\n" + "".join(face("wall", v, f"rho: 0, emission: 1, side: {side}")
                                               for v, side in zip(floor, ["front"] * 2 + ["back"] * 2))
            + above + below + ROOM), [])

    def test_crossing_comes_first(self):
        """A wall that stands on the floor, and one that goes through it."""
        deck = ("scene:\n  triangles:\n" + face("floor", "[[0,0,0],[4,0,0],[0,4,0]]", WHITE)
                + face("standing", "[[1,1,0],[2,1,0],[1,1,1]]", WHITE)
                + face("sunk", "[[0.5,2,-1],[1.5,2,-1],[1,2,1]]", WHITE))
        self.write("deck.yml", deck)
        p = self.call("check", "deck.yml", threads=1)
        self.assertEqual(p.returncode, 0)
        first, second = p.stderr.splitlines()
        self.assertRegex(first, r"\Adeck.yml:5: warning: triangle 3 \(sunk\) crosses triangle 1 \(floor\), .*--conform")
        self.assertRegex(second, r"\Adeck.yml:4: warning: triangle 2 \(standing\) touches triangle 1 \(floor\)")

    def test_inside_out(self):
        shell, dark = self.warned(cube(False, WHITE) + ROOM)
        self.assertIn("closed shell of 12 triangles that radiates outwards, and no face outside it", shell)
        self.assertIn("side: back", shell)
        self.assertIn("no face of the scene sees another", dark)
        self.assertEqual(self.warned(cube(False, WHITE + ", side: back") + ROOM), [])
        self.assertEqual(self.warned(cube(True, WHITE) + ROOM), [])

    def test_sheet_with_a_flux(self):
        line, = self.warned(SHIELD)
        self.assertRegex(line, r"deck.yml: warning: surface 'shield' has a flux and two sides: .*temperature of its own"
                               r".*make the sides two surfaces")

    def test_flux_that_sees_nothing(self):
        heater = "[[0.2, 0.2, -1], [0.2, 0.8, -1], [0.8, 0.2, -1]]"  # below the floor, looking down
        for flux, code in (-10, 2), (10, 0), (0, 0):
            deck = cube(True, HOT) + face("heater", heater, f"emissivity: 0.5, flux: {flux}") + ROOM
            if code:
                self.refused_both(deck, "surface 'heater' takes up 10 W/m2", "side: back")
            else:
                line, = self.warned(deck)
                self.assertIn("surface 'heater' has a flux, but 1 of its 1 triangles see no other face", line)


if __name__ == "__main__":
    unittest.main()
