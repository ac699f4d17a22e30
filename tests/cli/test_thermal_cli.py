"""Decks with temperatures and fluxes, from the deck to `polyrad info`."""

import os
import re
import unittest

from test_cli import INPUTS, Case

FURNACE = os.path.join(INPUTS, "furnace.yml")
MESH = "method={mesh: graded, elements: 1, degree: %d, grading: 2}"
QUICK = ("--set", MESH % 1)


class Thermal(Case):
    def test_summary_and_info(self):
        text = self.done("run", FURNACE, "-o", "f.vtkhdf", "--set", MESH % 3).stdout
        row = re.search(r"\n +load +700 +(-\d\S+) \+- (\S+) +(-\d\S+) \+- (\S+)\n", text)
        self.assertTrue(row, text)
        # 20 kW/m2 on 2 m2, less what the door loses; 1 m2 of load
        self.assertLessEqual(abs(float(row[1]) + 39500), float(row[2]))
        self.assertLessEqual(abs(float(row[3]) + 39500), float(row[4]))
        total = re.search(r"sum of net powers (\S+) \+- (\S+) W, of (\S+) W given off", text)
        self.assertLessEqual(abs(float(total[1])), float(total[2]))
        self.assertAlmostEqual(float(total[3]), 40000, delta=10)
        text = self.done("info", "f.vtkhdf").stdout
        for pattern in (r"mean_net_flux +net_power +error_net_power +temperature\n", r"\n  load +1 .* 700\n",
                        r"net_flux +temperature\n", r"/VTKHDF/PointData/temperature .*\] K:",
                        r"/VTKHDF/CellData/net_flux .*\] W/m2", r"/polyrad/triangles/emissivity"):
            self.assertRegex(text, pattern)

    def test_fields(self):
        self.done("run", FURNACE, "-o", "f.vtkhdf", "--quiet", *QUICK, "--set", "output.fields=[temperature]")
        text = self.done("info", "f.vtkhdf").stdout
        self.assertIn("/VTKHDF/PointData/temperature", text)
        self.assertNotIn("/VTKHDF/PointData/net_flux", text)
        self.assertIn("leave them out", self.refused(
            2, "run", os.path.join(INPUTS, "cube_corner.yml"), "--set", "output.fields=[net_flux]"))

    def test_too_much_drawn_is_a_warning(self):
        p = self.call("run", FURNACE, *QUICK, "--quiet", "--set", "scene.surfaces.door.flux=-1e6")
        self.assertEqual((p.returncode, p.stdout), (0, ""))
        self.assertRegex(p.stderr, r"warning: triangle \d+ \(\w+\) has no temperature")

    def test_all_fluxes(self):
        for more in QUICK, ():
            e = self.refused(1, "run", FURNACE, "--quiet", *more, "--set",
                             "scene.surfaces.load={emissivity: 0.9, flux: 0}")
            self.assertIn("give one face a temperature", e)


if __name__ == "__main__":
    unittest.main()
