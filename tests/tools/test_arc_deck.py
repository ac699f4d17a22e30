"""tools/arc_deck: a deck with probes on arcs."""

import math
import re
import tempfile
import unittest
from pathlib import Path

from project import ROOT, call

CORNER = ROOT / "inputs/cube_corner.yml"


def probes(deck: str) -> list[tuple[str, tuple[float, ...]]]:
    rows = re.findall(r"name: (arc_\S+), surface: \S+, at: \[(.*?)\]", deck)
    return [(name, tuple(float(x) for x in at.split(","))) for name, at in rows]


class ArcDeck(unittest.TestCase):
    def test_points_lie_on_the_arcs(self):
        made = call("arc_deck", CORNER, "--surface", "floor", "-n", 7)
        self.assertEqual(made.returncode, 0, made.stderr)
        found = probes(made.stdout)
        self.assertEqual(len(found), 4 * 7)
        self.assertEqual(found[0][0], "arc_r0.1_000")
        for name, (x, y, z) in found:
            radius = float(name.split("_")[1][1:])
            self.assertAlmostEqual(math.hypot(x, y), radius, delta=1e-15)
            self.assertEqual(z, 0)
            self.assertTrue(x > 0 and y > 0, "strictly inside the triangle")

    def test_other_lines_stay(self):
        made = call("arc_deck", CORNER, "--surface", "floor").stdout
        kept = [line for line in made.splitlines() if "arc_r" not in line]
        self.assertEqual(kept, CORNER.read_text().splitlines())

    def test_second_vertex_and_even_steps(self):
        made = call(
            "arc_deck",
            CORNER,
            "--surface",
            "floor",
            "--vertex",
            2,
            "-n",
            4,
            "--even",
            "--radii",
            0.5,
        )
        for i, (_, (x, y, _)) in enumerate(probes(made.stdout)):
            angle = math.atan2(
                y, 1 - x
            )  # at (1,0,0), from the edge to (0,1,0), which has 45 degrees
            self.assertAlmostEqual(angle, math.pi / 4 * (1 - (i + 0.5) / 4), delta=1e-15)

    def test_a_deck_without_probes_gets_them(self):
        with tempfile.TemporaryDirectory() as folder:
            deck = Path(folder) / "a.yml"
            deck.write_text(
                "scene:\n  triangles:\n    - {name: a, vertices: [[0,0,0],[1,0,0],[0,1e0,0]]}\n"
            )
            made = call("arc_deck", deck, "--surface", "a", "-n", 3, "--radii", 0.1)
        self.assertIn("\nprobes:\n  - {name: arc_r0.1_000, surface: a, at: [", made.stdout)

    def test_errors_are_one_sentence(self):
        for code, arguments in [
            (2, (CORNER, "--surface", "nowhere")),
            (2, (CORNER, "--surface", "floor", "--radii", 0.8)),
            (2, (CORNER, "--surface", "floor", "--radii", 0)),
            (3, ("/nowhere.yml", "--surface", "floor")),
        ]:
            made = call("arc_deck", *arguments)
            self.assertEqual(made.returncode, code)
            self.assertEqual(made.stdout, "")
            self.assertEqual(len(made.stderr.splitlines()), 1, made.stderr)
