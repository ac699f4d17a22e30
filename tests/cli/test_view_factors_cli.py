"""output.view_factors as users meet it: the key, the summary, the file, `info`, limits."""

import math
import re
import shutil
import subprocess
import unittest

import test_cli

FACES = {"floor": [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]],
         "ceiling": [[0, 0, 1], [0, 1, 1], [1, 1, 1], [1, 0, 1]],
         "x0": [[0, 0, 0], [0, 1, 0], [0, 1, 1], [0, 0, 1]],
         "x1": [[1, 0, 0], [1, 0, 1], [1, 1, 1], [1, 1, 0]],
         "y0": [[0, 0, 0], [0, 0, 1], [1, 0, 1], [1, 0, 0]],
         "y1": [[0, 1, 0], [1, 1, 0], [1, 1, 1], [0, 1, 1]]}
OPPOSITE, NEIGHBOUR = 0.1998248956983874, 0.2000437760754032  # of the unit cube


def cube(rho=0.0, emission=0.0):
    """Black and dark: an adaptive run has no unknowns there, the matrix needs them all the same."""
    text = "scene:\n  triangles:\n"
    for name, p in FACES.items():
        for k in (1, 2):
            text += "    - {name: %s, rho: %g, emission: %g, vertices: %s}\n" % (
                name, rho, emission, [p[0], p[k], p[k + 1]])
    return text


def exact(s, t):
    return 0 if s == t else OPPOSITE if s // 2 == t // 2 else NEIGHBOUR


class Numbers(test_cli.Case):
    def numbers(self, file, name):
        if not shutil.which("h5dump"):
            self.skipTest("h5dump is not installed")
        p = subprocess.run(["h5dump", "-m", "%.17g", "-y", "-d", "/polyrad/view_factors/" + name,
                            self.path(file)], text=True, stdout=subprocess.PIPE, check=True)
        self.assertRegex(p.stdout, r'ATTRIBUTE "unit"(.|\n)*?"1"')
        self.assertIn('ATTRIBUTE "description"', p.stdout)
        data = p.stdout[p.stdout.index("DATA {"):p.stdout.index("ATTRIBUTE")]
        return [float(x) for x in re.findall(r"[-+0-9.e]+(?=[,\s])|nan", data[6:])]


class ViewFactors(Numbers):
    def look(self, tolerance, *options):
        out = self.done("run", "deck.yml", "-o", "a.h5", *options).stdout
        self.assertIn("6 x 6 view factors", out)
        self.assertNotIn("(NOT CONVERGED)", out)
        matrix, rows = self.numbers("a.h5", "matrix"), self.numbers("a.h5", "row_sum")
        error, reciprocity = self.numbers("a.h5", "error"), self.numbers("a.h5", "reciprocity")
        self.assertEqual([len(x) for x in (matrix, rows, error, reciprocity)], [36, 6, 36, 36])
        for i, f in enumerate(matrix):
            self.assertLessEqual(abs(f - exact(i // 6, i % 6)), tolerance)
            self.assertLessEqual(error[i], tolerance)
            self.assertTrue(math.isnan(reciprocity[i]))  # both directions only of what is partly hidden
        for s, row in enumerate(rows):
            self.assertLessEqual(abs(row - 1), tolerance)
            self.assertAlmostEqual(row, sum(matrix[6 * s:6 * s + 6]), 13)

    def test_closed_cube(self):
        self.write("deck.yml", cube(0.5, 1) + "output: {view_factors: true}\n")
        self.look(1e-3)
        self.look(1e-6, "--set", "method.elements=1", "--set", "method.degree=0")
        self.look(1e-9, "--set", "method.elements=1", "--set", "method.degree=0", "--set",
                  "accuracy.tolerance=1e-9")
        info = self.done("info", "a.h5").stdout
        self.assertRegex(info, r"view factors:\n +converged +yes\n +tolerance +1e-09\n")
        self.assertRegex(info, r"\n +floor +0 0\.199825 0\.200044 .* 1\n")
        self.assertIn("/polyrad/view_factors/matrix", info)

    def test_black_and_dark(self):
        self.write("deck.yml", cube() + "method: {elements: 1}\noutput: {view_factors: true}\n")
        self.look(1e-6)

    def test_not_asked_for(self):
        for value in ([], ["--set", "output.view_factors=false"]):
            self.write("deck.yml", cube(0.5, 1) + "method: {elements: 1, degree: 0}\n")
            out = self.done("run", "deck.yml", "-o", "a.h5", *value).stdout
            self.assertNotIn("view factors", out)
            self.assertNotIn("/polyrad/view_factors", self.done("info", "a.h5").stdout)

    def test_tolerance_that_cannot_be_met(self):
        """Written, marked, and said."""
        self.write("deck.yml", cube(0.5, 1) + "method: {elements: 1, degree: 0}\n"
                   "accuracy: {tolerance: 1e-15}\noutput: {view_factors: true}\n")
        p = self.call("run", "deck.yml", "-o", "a.h5")
        self.assertEqual(p.returncode, 0)
        self.assertRegex(p.stderr, r"\Adeck.yml: warning: the view factors [^\n]* rounding [^\n]*\n\Z")
        self.assertIn("(NOT CONVERGED)", p.stdout)
        info = self.done("info", "a.h5").stdout
        self.assertRegex(info, r"view factors:\n +converged +NO\n +reason +rounding")

    def test_bad_values(self):
        for value, words in (("yes", "allowed are false, true"), ("True", "did you mean 'true'"),
                             ("1", "allowed are"), ("[true]", "is not a name"), ("", "is not a name")):
            self.write("deck.yml", cube() + "output:\n  view_factors: %s\n" % value)
            for verb in ("run", "check", "study"):
                message = self.refused(2, verb, "deck.yml")
                self.assertIn(words, message)
                self.assertRegex(message, r"\Adeck\.yml:\d+:\d+: error: 'view_factors'")
            self.assertEqual(self.files(), ["deck.yml"])
        self.write("deck.yml", cube() + "output: {view_factor: true}\n")
        self.assertIn("did you mean 'view_factors'", self.refused(2, "run", "deck.yml"))


if __name__ == "__main__":
    unittest.main()
