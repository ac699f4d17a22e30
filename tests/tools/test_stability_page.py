"""docs/stability.md and the studies it is made from: one list, decks that are there, the same words."""

import re
import sys
import unittest

from project import ROOT

sys.path.insert(0, str(ROOT / "tools/python"))
import report_stability  # noqa: E402

FOLDER = ROOT / "inputs/studies/stability"


def entries() -> list[dict[str, str]]:
    return report_stability.entries(FOLDER)


class Page(unittest.TestCase):
    def test_verdicts_and_answers_stand_in_the_page(self):
        page = " ".join((ROOT / "docs/stability.md").read_text().split())
        self.assertGreater(len(entries()), 8)
        for entry in entries():
            self.assertEqual(
                set(entry), {"id", "decks", "title", "plot", "columns", "verdict", "program"}
            )
            for key in ("verdict", "program"):
                self.assertIn(entry[key], page)

    def test_every_deck_is_listed_and_says_how_it_is_run(self):
        listed = [name for entry in entries() for name in re.findall(r"\w+\.yml", entry["decks"])]
        there = sorted(path.name for path in FOLDER.glob("*.yml"))
        self.assertEqual(sorted([*listed, "index.yml"]), there)
        for name in listed:
            text = (FOLDER / name).read_text()
            self.assertIn(f"polyrad study inputs/studies/stability/{name}", text)
            self.assertRegex(text, r"(?m)^title: \S")

    def test_figures_are_there(self):
        for name in re.findall(r"img/(\w+\.svg)", (ROOT / "docs/stability.md").read_text()):
            self.assertTrue((ROOT / "docs/img" / name).is_file(), name)
