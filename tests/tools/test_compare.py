"""tools/compare: two studies side by side, what is worse is marked, and nothing else."""

import tempfile
import unittest
from pathlib import Path

import h5py
import numpy as np

import synthetic
from project import call


class Compare(unittest.TestCase):
    def setUp(self):
        holder = tempfile.TemporaryDirectory()
        self.addCleanup(holder.cleanup)
        self.folder = Path(holder.name)
        self.before = self.study("before.h5")

    def study(self, name: str, machine="A, 2 processors", **change) -> Path:
        """A study with times of a second and more, some columns multiplied row by row."""
        path = synthetic.write_study(self.folder / name, 1)
        with h5py.File(path, "a") as file:
            file["polyrad"].attrs["machine"] = machine
            file["polyrad"].attrs["git_revision"] = name
            values = file["study/method.elements"][()].astype(str)
            del file["study/method.elements"]
            file["study/method.elements"] = np.array(values, h5py.string_dtype())
            file["study/seconds_total"][...] *= 1000
            for column, factor in change.items():
                file[f"study/{column}"][...] *= factor
        return path

    def compare(self, after: Path, *options):
        return call("compare", self.before, after, *options)

    def marked(self, output: str) -> dict[str, str]:
        """Value of the varied key: the mark at the end of its row."""
        rows = [line.split() for line in output.splitlines() if " runs are " not in line]
        rows = [row for row in rows if row and row[0] in ("1", "2", "4", "8", "16") and len(row) > 6]
        return {row[0]: " ".join(row[7:]) for row in rows}

    def test_equal_studies_are_not_worse(self):
        made = self.compare(self.study("same.h5"))
        self.assertEqual((made.returncode, made.stderr), (0, ""))
        self.assertIn("before.h5  ->  same.h5", made.stdout)
        self.assertIn("0 of 5 runs are worse", made.stdout)
        self.assertEqual(set(self.marked(made.stdout).values()), {""})

    def test_noise_is_not_marked_and_what_is_beyond_it_is(self):
        after = self.study(
            "after.h5", seconds_total=[1.4, 1, 0.2, 1.6, 1], error=[1, 1.1, 1.01, 1.5, 1]
        )
        made = self.compare(after)
        self.assertEqual(made.returncode, 1, made.stderr)
        expected = {"1": "", "2": "LESS ACCURATE", "4": "", "8": "LESS ACCURATE SLOWER", "16": ""}
        self.assertEqual(self.marked(made.stdout), expected)
        self.assertIn("2 of 5 runs are worse", made.stdout)
        made = self.compare(after, "--slower", 2, "--less-accurate", 2)
        self.assertEqual(made.returncode, 0, made.stdout)

    def test_times_of_two_machines_are_not_judged(self):
        made = self.compare(self.study("other.h5", machine="B, 1 processors", seconds_total=9))
        self.assertEqual(made.returncode, 0, made.stdout)
        self.assertIn("not the same", made.stdout)

    def test_an_error_that_is_no_number_any_more(self):
        after = self.study("after.h5", error=[1, 1, 1, np.inf, 1])
        self.assertEqual(self.marked(self.compare(after).stdout)["8"], "LESS ACCURATE")
        after = self.study("nan.h5", error=[1, 1, np.nan, 1, 1])
        self.assertEqual(self.marked(self.compare(after).stdout)["4"], "LESS ACCURATE")

    def test_other_studies_are_refused(self):
        other = self.study("other.h5")
        with h5py.File(other, "a") as file:
            file.move("study/method.elements", "study/method.degree")
        made = self.compare(other)
        self.assertEqual(made.returncode, 2)
        self.assertIn("compare two runs of one study", made.stderr)
        result = synthetic.write(self.folder / "corner.vtkhdf", 4)
        for path in (result, self.folder / "absent.h5"):
            made = self.compare(path)
            self.assertEqual(made.returncode, 3)
            self.assertEqual(len(made.stderr.splitlines()), 1, made.stderr)
