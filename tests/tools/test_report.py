"""tools/report: curves, the cheapest method, pages that need no other file, decks that are good."""

import os
import re
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

import numpy as np
from project import ROOT

sys.path.insert(0, str(ROOT / "tools/python"))
import report  # noqa: E402
import report_stability  # noqa: E402
import report_work  # noqa: E402
from report_context import Context, Section  # noqa: E402
from report_work import Curve, cheapest, name_of  # noqa: E402

POLYRAD = Path(os.environ.get("POLYRAD", ROOT / "build/release/polyrad"))
SMALL = {
    "meshes": "study.vary.method=[{mesh: paper, elements: 1, degree: 0}, {mesh: paper, elements: 2, degree: 0}, "
    "{mesh: graded, elements: 1, grading: 3, degree: 3}]",
    "adaptive": "study.vary.accuracy.tolerance=[1e-1, 1e-2]",
}


class Small(Context):
    """Each study with a few quick runs."""

    def study(self, section, deck, name, settings=None):
        vary = SMALL["adaptive" if "_adaptive_" in name else "meshes"]
        more = ["study.repeats=1", "study.reference.tolerance=1e-3", vary] if section == "work" else []
        return super().study(section, deck, name, [*(settings or []), *more])


def links(page: str) -> list[str]:
    return re.findall(r'(?:src|href)\s*=\s*"([^"]*)"', page) + re.findall(r"url\(([^)#]*)", page)


class Report(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.context = Small(POLYRAD, ROOT, Path(folder.name))

    def alone(self, page: str):
        for link in links(page):
            self.assertRegex(link, r"^(data:image/svg\+xml;base64,|#)")

    def test_work(self):
        text, path = report_work.scene_part(self.context, "blocker")
        self.alone(text)
        self.assertTrue(path.read_text().lstrip().startswith("<?xml"))
        self.context.known = self.context.folder  # what has been computed is not computed again
        curves, floor, _ = report_work.runs_of(self.context, "blocker")
        names = {curve.name: curve for curve in curves}
        self.assertEqual(len(names), 6)
        for kind, runs in (("P0, paper", 2), ("graded, degree 3", 1), ("adaptive", 2)):
            u_h, star = names[f"{kind}, u_h"], names[f"{kind}, u*"]
            self.assertEqual((len(u_h.error), len(star.error)), (runs, runs))
            np.testing.assert_array_equal(u_h.work["unknowns"], star.work["unknowns"])
            self.assertTrue((star.error < u_h.error).all())  # u* is the better one
        self.assertTrue((names["adaptive, u*"].error < [0.1 * 1.05, 0.01 * 1.05]).all())  # the largest u is 1.04
        self.assertAlmostEqual(floor, 1e-5 * 1.04)

    def test_cheapest(self):
        def curve(name, error, seconds):
            return Curve(name, np.array(error), {"seconds_total": np.array(seconds)})

        curves = [curve("quick", [0.2, 0.05], [1, 2]), curve("fine", [0.09, 5e-4], [3, 4])]
        found = cheapest(curves, "seconds_total")
        self.assertEqual(found, [(0.1, "quick", 2.0), (0.01, "fine", 4.0), (0.001, "fine", 4.0)])
        self.assertEqual(cheapest(curves, "seconds_total", 0.005), found[:2])

    def test_names(self):
        for method, name in {
            "{mesh: uniform, elements: 4, degree: 0}": "uniform, constants",
            "{mesh: paper, elements: 4, degree: 0, quadrature_tolerance: 1e-8}": "P0, paper",
            "{mesh: paper, elements: 4, grading: 2, degree: 1, angle: duffy}": "P1, p = 2, duffy",
            "{mesh: graded, elements: 1, grading: 3, degree: 9}": "graded, degree 9",
        }.items():
            self.assertEqual(name_of(method), name)
            self.assertIn("marker", report_work.style(name + ", u*"))

    def test_stability(self):
        folder = ROOT / "inputs/studies/stability"
        entry = next(e for e in report_stability.entries(folder) if e["id"] == "quadrature")
        text, figures = report_stability.part(self.context, entry, folder)
        self.alone(text)
        self.assertEqual(len(figures), 1)
        self.assertEqual(text.count("<tr>"), 1 + 8)
        self.assertIn(entry["verdict"].split(":")[0], text)

    def test_page(self):
        sections = {"work": Section("Work", "<p>a</p>"), "paper": Section("Paper", "<p>b</p>")}
        page = report.page(sections)
        self.alone(page)
        for name, section in sections.items():
            self.assertIn(f'<h2 id="{name}">{section.title}</h2>\n{section.html}', page)

    def test_figures_for_the_documents(self):
        made, shown = self.context.folder / "a" / "work_a.svg", self.context.folder / "docs"
        made.parent.mkdir()
        shown.mkdir()
        made.write_text("<svg/>")
        self.context.docs = shown
        report.publish(self.context, [made])
        self.assertEqual([(f.name, f.read_text()) for f in shown.iterdir()], [("work_a.svg", "<svg/>")])

    def test_decks_are_good(self):
        for deck in sorted((ROOT / "inputs/studies/work").glob("*.yml")):
            listed = subprocess.run([POLYRAD, "study", deck, "--tasks"], capture_output=True, text=True, check=False)
            self.assertEqual(listed.returncode, 0, listed.stderr)
            self.assertIn(deck.stem, report_work.SCENES)
            self.assertIn(f"polyrad study inputs/studies/work/{deck.name}", deck.read_text())

    def test_wrong_folder(self):
        command = [sys.executable, ROOT / "tools/python/report.py", "--from", self.context.folder / "none"]
        ended = subprocess.run(command, capture_output=True, text=True, check=False)
        self.assertEqual(ended.returncode, 2)
        self.assertIn("there is no folder", ended.stderr)


if __name__ == "__main__":
    unittest.main()
