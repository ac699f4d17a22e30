"""A result that was cut short, whatever cut it: tools/plot and tools/render say so in one sentence."""

import os
import subprocess
import tempfile
import unittest
from pathlib import Path

from project import ROOT, call

PROGRAM = os.environ.get("POLYRAD", str(ROOT / "build/release/polyrad"))


class CutFiles(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        holder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(holder.cleanup)
        cls.folder = Path(holder.name)
        deck = ROOT / "inputs/cube_corner.yml"
        command = [PROGRAM, "run", deck, "--quiet", "-o", "out.vtkhdf", "--set", "method.elements=1"]
        subprocess.run(command, cwd=cls.folder, check=True)
        cls.whole = (cls.folder / "out.vtkhdf").read_bytes()

    def look(self, *words):
        for size in (0, len(self.whole) - 1):
            (self.folder / "cut.vtkhdf").write_bytes(self.whole[:size])
            made = call(*words, "cut.vtkhdf", "-o", "picture.png", folder=self.folder)
            self.assertEqual(made.returncode, 3, made.stdout + made.stderr)
            self.assertRegex(made.stderr, r"\A[^\n]*cut\.vtkhdf[^\n]*\n\Z")
            self.assertFalse((self.folder / "picture.png").exists())

    def test_plot(self):
        self.look("plot", "surface")

    def test_render(self):
        call("venv", "render")  # says so on stderr when it has something to install
        self.look("render")
