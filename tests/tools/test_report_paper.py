"""tools/paper and docs/paper.md: the paper's tables for small N, against numbers of an independent program
(the project's reference values) and against what the page says."""

import os
import sys
import tempfile
import unittest
from pathlib import Path

import numpy as np
from project import ROOT

sys.path.insert(0, str(ROOT / "tools/python"))
import paper_mesh  # noqa: E402
import paper_quadrature  # noqa: E402
import paper_tables  # noqa: E402
import report_paper  # noqa: E402
import report_paper_figures  # noqa: E402
from paper_exponents import exact_and_measured, local_exponents  # noqa: E402
from paper_runs import SIDE, Runs  # noqa: E402

PAGE = (ROOT / "docs/paper.md").read_text()
SMALL = [1, 2, 4]

# Of the independent program: errors for N = 1, 2, 4 against the finest mesh.
KNOWN = {
    "4.2": [2.833175e-2, 1.376113e-2, 6.807135e-3],
    "4.3": [2.956264e-2, 1.279864e-2, 5.023219e-3],
    "4.6": [1.34305e-1, 6.51203e-2, 3.87982e-2],
}


def rows_of(name: str) -> list[list[str]]:
    """The rows of a made table of the page."""
    made = PAGE.split(f"<!-- {name}: made by tools/paper -->")[1].split(f"<!-- end of {name} -->")[0]
    lines = [line for line in made.strip().splitlines() if line.startswith("|")]
    return [[cell.strip() for cell in line.strip("|").split("|")] for line in lines[2:]]


class Paper(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(folder.cleanup)
        polyrad = os.environ.get("POLYRAD", ROOT / "build/release/polyrad")
        cls.runs = Runs(Path(polyrad), ROOT, Path(folder.name))

    def close(self, ours, known, tolerance):
        np.testing.assert_allclose(ours, known, rtol=tolerance)

    def test_cube_corner(self):
        for key, tolerance in (("4.2", 3e-4), ("4.3", 3e-4)):
            deck = paper_tables.PAPER[key]["deck"]
            study = paper_tables.study_of(self.runs, key, SMALL)
            found = paper_tables.convergence(study, self.runs.triangles(deck))
            self.close(found.error, KNOWN[key], tolerance)
            rows = rows_of(f"table {key}")
            self.close([float(row[3]) for row in rows[:3]], found.error, 1e-4)
            self.assertEqual([row[-1] for row in rows[:3]], found.at)
            self.assertEqual([row[1] for row in rows[:3]], [str(n) for n in found.unknowns])
        # The paper's own numbers are met by Table 4.2 as well.
        self.close(found.error[0], paper_tables.PAPER["4.3"]["error"][0], 3e-3)

    def test_wedge(self):
        at_x, at_y = paper_tables.wedge(self.runs, SMALL)
        self.close(at_x.error, KNOWN["4.6"], 3e-4)
        self.close(at_y.error, paper_tables.PAPER["4.6"]["error"][:3], 3e-3)
        self.assertEqual(at_y.at, ["Δ1 (0.333, 0.333, 0)", *["Δ1 (0, 0.5, 0)"] * 2])  # as it says
        rows = rows_of("table 4.6")
        self.close([float(row[3]) for row in rows[:3]], at_y.error, 1e-4)
        self.close([float(row[5]) for row in rows[:3]], at_x.error, 1e-4)

    def test_exponents(self):
        edge, _, _ = exact_and_measured(self.runs, "wedge_p1.yml", 1e-2)
        rows = rows_of("table 4.5")
        exact = [float(row[4]) for row in rows]
        self.close(exact, [edge[0, 2], edge[0, 0], edge[1, 2]], 1e-4)
        for value, row in zip(exact, rows, strict=True):
            for seen in row[6].split(","):
                self.assertLess(abs(float(seen) - value), 0.005)

    def test_local_exponents_of_a_power(self):
        h = 2.0 ** -np.arange(5)
        np.testing.assert_allclose(local_exponents(3 - 2 * h**0.7), 0.7)

    def test_orders_are_those_of_the_paper(self):
        for key in ("4.2", "4.3", "4.6"):
            printed = paper_tables.PAPER[key]
            orders = paper_tables.orders(printed["N"], printed["reference"], printed["error"])
            if key == "4.3":  # its last order is not that of its errors, see docs/paper.md
                self.assertAlmostEqual(orders.pop(), 1.589, places=3)
            np.testing.assert_allclose(orders, printed["eoc"][: len(orders)], atol=0.012)

    def test_table_3_1_stands_in_the_page(self):
        made = paper_tables.table_3_1()
        self.assertIn(made.markdown(), PAGE)
        self.assertIn("126 of 126 printed numbers are met", made.notes[0])
        self.assertEqual(paper_quadrature.by_doubling(0.5, 1e-4, 1), 18)  # no transformation

    def test_the_integral_of_table_3_1(self):
        closed = [1 / (2 * (1 + 1)) + np.arctan(1) / 2, 2 * (0.5 / (2 * 1.25) + np.arctan(0.5) / 2)]
        self.close([paper_quadrature.exact(0, 1), paper_quadrature.exact(0.5, 1)], closed, 1e-14)
        low, high = 0.5, 1.5  # a = -0.5
        outside = sum(k * (s / (2 * (s * s + 1)) + np.arctan(s) / 2) for k, s in ((1, high), (-1, low)))
        self.close(paper_quadrature.exact(-0.5, 1), outside, 1e-13)

    def test_the_paper_s_trial_functions_are_those_of_the_program(self):
        """u_h written anew from the paper's section 3, against the values a study compares."""
        s = np.arange(SIDE) / (SIDE - 1)
        phi, r = np.meshgrid(s, s)
        for deck, p in (("cube_corner_p1.yml", 1), ("cube_corner_p2.yml", 2)):
            study = self.runs.study(deck, [1, 4])
            ours = self.runs.solution(deck, 4, p).on_grid(phi, r)
            np.testing.assert_allclose(ours, study.value[1][..., 0], atol=1e-6)

    def test_points_are_found_again(self):
        triangle = np.array([[0.1, 0, 0.2], [1, 0.3, 0], [0.2, 0.5, 1]])
        rng = np.random.default_rng(2003)
        for sub in range(6):
            phi, r = rng.uniform(0.01, 0.99, (2, 20))
            found = paper_mesh.locate(triangle, paper_mesh.place(triangle, sub, phi, r))
            np.testing.assert_allclose(found[0], phi, atol=1e-12)
            np.testing.assert_allclose(found[1], r, atol=1e-12)
            np.testing.assert_array_equal(found[2], sub)

    def test_a_half_plane_gives_one_half(self):
        beta = np.array([0.7, 1.5, 2.4])  # Remark 2.5d: (1 + cos 90 degrees)/2
        np.testing.assert_allclose(report_paper_figures.sigma(beta, 0, np.pi), 0.5, atol=1e-12)
        parts = [report_paper_figures.sigma(beta, 0, 1), report_paper_figures.sigma(beta, 1, np.pi)]
        np.testing.assert_allclose(sum(parts), 0.5, atol=1e-12)

    def test_figures(self):
        for figure in report_paper.FIGURES:
            name = f"paper_{figure.name}.svg"
            self.assertIn(f"(img/{name})", PAGE)
            self.assertTrue((ROOT / "docs/img" / name).is_file(), name)
        twice = []
        for figure in (report_paper.FIGURES[1], report_paper.FIGURES[5]):
            made = report_paper.drawn(figure, self.runs, False, self.runs.folder)
            twice.append(made.read_text())
        self.assertIn(">23<", twice[0])  # rectangles of P(3,2)
        self.assertIn("72 points of P1 (dots), 126 of constants", twice[1])

    def test_what_differs_as_html(self):
        made = report_paper.differences(PAGE)
        self.assertEqual(made.count("<li>"), 7)
        self.assertIn("<b>It is 0.8384.</b>", made)
        self.assertNotIn("**", made)
        table = paper_tables.Table("a < b", ["x"], [["1 & 2"]], ["**so** it is"])
        self.assertIn("<h3>a &lt; b</h3>", table.page())
        self.assertIn("<td>1 &amp; 2</td>", table.page())
        self.assertIn("<p>so it is</p>", table.page())

    def test_counts_of_unknowns(self):
        for rounding, counts in (
            (lambda x: np.floor(x + 0.5), [72, 576, 3168, 16272, 77760]),
            (np.floor, [72, 576, 3168, 15984, 77184]),
            (np.ceil, [72, 576, 3312, 16560, 78912]),
        ):
            found = [72 * (n + 2 * paper_mesh.legs(n, 2, rounding).sum()) for n in (1, 2, 4, 8, 16)]
            self.assertEqual(found, counts)

    def test_every_made_part_of_the_page_has_its_table(self):
        names = ["table 3.1", "table 4.2", "formula 4.6", "table 4.3", "table 4.5", "table 4.6"]
        self.assertEqual(report_paper.places(PAGE), names)
        table = paper_tables.Table("T", ["a"], [["1"]])
        page = report_paper.with_tables(PAGE, {name: table for name in names})
        self.assertEqual(page.count("| a |\n| --- |\n| 1 |"), 6)
        self.assertEqual(report_paper.places(page), names)


if __name__ == "__main__":
    unittest.main()
