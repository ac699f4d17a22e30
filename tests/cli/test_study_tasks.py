"""A study in pieces: --tasks, --task I/N, --collect. The table is that of the study in one piece."""

import re
import shutil
import subprocess
import unittest

import test_cli

TIMES = r"seconds_\w+"


class Tasks(test_cli.Case):
    def setUp(self):
        super().setUp()
        with open(test_cli.CORNER) as f:
            self.scene = f.read()
        self.study("{vary: {method.grading: [1, 2], method.elements: [1, 2]}}")

    def study(self, text):
        self.write("deck.yml", self.scene + "study: %s\n" % text)

    def call(self, *words, **more):
        return super().call(*words, "--threads", "1", **more)  # BLAS rounds otherwise with two

    def tasks(self, n, *words):
        for k in range(1, n + 1):
            self.done("study", "deck.yml", "--task", "%d/%d" % (k, n), "--quiet", *words)
        return sorted(name for name in self.files() if "_task_" in name)

    def columns(self, name):
        """Columns of a table, without times."""
        if not shutil.which("h5dump"):
            self.skipTest("h5dump is not installed")
        p = subprocess.run(["h5dump", "-m", "%.17g", "-g", "/polyrad/study", self.path(name)],
                           text=True, stdout=subprocess.PIPE, check=True)
        parts = re.split(r'(?m)^   DATASET "(.*)" \{$', p.stdout)
        return {n: text for n, text in zip(parts[1::2], parts[2::2]) if not re.fullmatch(TIMES, n)}

    def same_table(self, n, *words):
        files = self.tasks(n, *words)
        self.assertEqual(len(files), n)
        whole = self.done("study", "deck.yml", "-o", "whole.h5", *words).stdout
        parts = self.done("study", "--collect", *reversed(files), "-o", "parts.h5").stdout
        cut = lambda text: [line.split()[:-3] for line in text.splitlines()[1:-2]]
        self.assertEqual(cut(whole), cut(parts))
        self.assertEqual(whole.splitlines()[-2], parts.splitlines()[-2])  # which reference
        columns = self.columns("whole.h5")
        self.assertGreater(len(columns), 7)
        self.assertEqual(columns, self.columns("parts.h5"))
        return files

    def test_same_table(self):
        files = self.same_table(4)
        self.assertEqual(files[0], "cube_corner_task_1_of_4.vtkhdf")
        text = self.done("info", files[2]).stdout
        self.assertTrue(text.startswith(files[2] + ": polyrad result, task of a study\n"), text)
        self.assertRegex(text, r"task 3 of 4 of a study:\n +method.grading +2\n +method.elements +1\n")
        self.assertIn("mean_radiosity", text)  # a full result

    def test_named_reference_is_the_last_task(self):
        self.study("{vary: {method.elements: [1, 2]}, reference: {elements: 4}}")
        files = self.same_table(3)
        self.assertEqual(self.done("study", "deck.yml", "--tasks").stdout.split(), files)
        self.assertIn("method.elements        reference", self.done("info", files[2]).stdout)

    def test_adaptive(self):
        self.study("{vary: {accuracy.tolerance: [1e-1, 1e-2]}}")
        self.same_table(2)

    def errors(self):
        """Column error of whole.h5 as the study prints it."""
        lines = self.done("study", "deck.yml", "-o", "again.h5").stdout.splitlines()
        at = lines[0].split().index("error")
        return [float(line.split()[at]) for line in lines[1:-2]]

    def test_values_against_a_tolerance(self):
        errors, said = {}, {"solution": "|u_h - reference|", "reported": "|reported u - reference|"}
        for values, words in said.items():
            self.study("{vary: {method.elements: [1, 2]}, reference: {tolerance: 1e-5}, values: %s}" % values)
            self.same_table(3)
            self.assertIn(words, self.done("study", "--collect", *[f for f in self.files() if "_task_" in f],
                                           "-o", "c.h5").stdout)
            errors[values] = self.errors()
        for u_h, star in zip(errors["solution"], errors["reported"]):
            self.assertGreater(u_h, 2 * star)  # u* gains a power of h
        # the paper's Table 4.2: errors of u_h halve with h, here on other points
        self.assertAlmostEqual(errors["solution"][0], 2.99e-2, delta=5e-4)

    def test_repeats_change_times_only(self):
        once = self.done("study", "deck.yml", "-o", "once.h5", "--set", "study.repeats=1")
        thrice = self.done("study", "deck.yml", "-o", "thrice.h5", "--set", "study.repeats=3")
        self.assertEqual(self.columns("once.h5"), self.columns("thrice.h5"))
        self.assertEqual(once.stderr, thrice.stderr)

    def test_overrides(self):
        files = self.same_table(4, "--set", "scene.triangles.0.rho=0.25")
        self.done("study", "deck.yml", "--task", "2/4", "--quiet")
        self.assertIn("its --set options are others",
                      self.refused(2, "study", "--collect", *files))

    def test_list_of_tasks(self):
        self.study("{vary: {method.elements: [%s]}}" % ", ".join(map(str, range(1, 13))))
        lines = self.done("study", "deck.yml", "--tasks").stdout.splitlines()
        self.assertEqual(lines, sorted(lines))
        self.assertEqual((len(lines), lines[8]), (12, "cube_corner_task_09_of_12.vtkhdf"))
        self.assertEqual(self.files(), ["deck.yml"])

    def test_default_name_of_the_table(self):
        files = self.tasks(4)
        self.done("study", "--collect", *files, "--quiet")
        self.assertIn("cube_corner_study.h5", self.files())

    def test_run_without_a_solution(self):
        """Its row stays empty, as in the study in one piece; the reason is told when it runs."""
        self.study("{vary: {method.solver: [gmres, lu]}}")
        words = ("--set", "method.elements=3", "--set", "method.solver_tolerance=1e-18")
        text = self.refused(1, "study", "deck.yml", "--task", "1/2", "--quiet", *words)
        self.assertIn("GMRES did not converge", text)
        self.done("study", "deck.yml", "--task", "2/2", "--quiet", *words)
        files = [name for name in self.files() if "_task_" in name]
        p = self.call("study", "--collect", *files, "-o", "parts.h5")
        self.assertEqual((p.returncode, p.stderr), (0, files[0] + ": task 1 has no solution\n"))
        self.call("study", "deck.yml", "-o", "whole.h5", *words)
        self.assertEqual(self.columns("whole.h5"), self.columns("parts.h5"))

    def test_singular_run(self):
        """No result at all: the task's file says so, and the table is made without it."""
        self.write("deck.yml", test_cli.tetrahedron(1)
                   + "study: {vary: {scene.triangles.3.rho: [1, 0.5]}}\n")
        self.refused(1, "study", "deck.yml", "--task", "1/2", "--quiet")
        self.done("study", "deck.yml", "--task", "2/2", "--quiet")
        files = [name for name in self.files() if "_task_" in name]
        self.assertEqual(len(files), 2)
        self.assertIn("of a study, without a solution", self.done("info", files[0]).stdout)
        p = self.call("study", "--collect", *files)
        self.assertEqual((p.returncode, p.stderr), (0, files[0] + ": task 1 has no solution\n"))

    def test_wrong_numbers(self):
        for bad in ("0/4", "5/4", "1", "1/4/2", "1/4x", "-1/4", "a/b", ""):
            self.assertIn("--task needs I/N", self.refused(2, "study", "deck.yml", "--task", bad))
        text = self.refused(2, "study", "deck.yml", "--task", "2/5")
        self.assertIn("the study has 4 runs, but --task 2/5 says 5; give 1/4 to 4/4", text)
        self.assertEqual(self.files(), ["deck.yml"])
        self.assertIn("unknown option", self.refused(2, "run", "deck.yml", "--task", "1/4"))

    def test_files_that_do_not_fit(self):
        files = self.tasks(4)
        self.assertIn("no file of task 2 and 1 more; run polyrad study DECK --task 2/4",
                      self.refused(2, "study", "--collect", files[0], files[2]))
        self.assertIn("are both task 1 of 4",
                      self.refused(2, "study", "--collect", files[0], *files))
        self.assertIn("needs a FILE", self.refused(2, "study", "--collect"))
        self.done("run", test_cli.CORNER, "-o", "other.h5", "--quiet", "--set", "method.elements=1")
        self.assertIn("other.h5 holds no task of a study",
                      self.refused(3, "study", "--collect", files[0], "other.h5"))
        self.assertIn("deck.yml is not a polyrad result",
                      self.refused(3, "study", "--collect", "deck.yml"))
        self.write("cut.h5", self.read(files[1])[:-1000])
        self.assertIn("cannot read cut.h5", self.refused(3, "study", "--collect", "cut.h5"))
        self.scene += "\n# changed since\n"
        self.study("{vary: {method.grading: [1, 2], method.elements: [1, 2]}}")
        self.done("study", "deck.yml", "--task", "2/4", "--quiet")
        self.assertIn("its deck is another", self.refused(2, "study", "--collect", *files))


if __name__ == "__main__":
    unittest.main()
