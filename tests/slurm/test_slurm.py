"""tools/slurm in a real Slurm: a study as an array of four, a matrix in four parts, a run that is cut by
its time limit and goes on.

    POLYRAD=build/release/polyrad POLYRAD_INPUTS=inputs tests/slurm/run
"""

import os
import re
import shutil
import subprocess
import unittest

import cluster

PROGRAM = os.path.abspath(os.environ.get("POLYRAD", "build/release/polyrad"))
INPUTS = os.path.abspath(os.environ.get("POLYRAD_INPUTS", "inputs"))
ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
TOOLS = os.path.join(ROOT, "tools", "slurm")
JOB = os.path.join(TOOLS, "job.sbatch")
CORNER = os.path.join(INPUTS, "cube_corner.yml")
STUDY = "study: {vary: {method.grading: [1, 2], method.elements: [1, 2]}}\n"
# About a second on one thread.
LONG = ("--set", "method.elements=4", "--set", "method.solver=lu", "--set", "method.quadrature_tolerance=1e-13")

# A program in polyrad's place that is held up on its first run, so that whatever the machine's speed it
# meets the time limit in the midst of its work. Everything else, and every signal, is polyrad's.
SLOW = """\
#!/usr/bin/env python3
import os, signal, subprocess, sys
sys.path.insert(0, %r)
from waiting import until_ready
p = subprocess.Popen([%r] + sys.argv[1:])
def stop(*_):
    p.send_signal(signal.SIGCONT)
    p.send_signal(signal.SIGUSR1)
signal.signal(signal.SIGUSR1, stop)
if sys.argv[1] == "run" and not os.environ.get("SLURM_RESTART_COUNT"):
    until_ready(p, signal.SIGUSR1, 0.1)
    p.send_signal(signal.SIGSTOP)
sys.exit(p.wait())
"""


class Slurm(unittest.TestCase):
    """One cluster for all; the job that has to wait for its limit is submitted first."""

    @classmethod
    def setUpClass(cls):
        cls.cluster = cluster.Cluster()
        cls.addClassCleanup(cls.cluster.__exit__)
        cls.cluster.start()
        cls.folder = os.path.join(cls.cluster.folder, "work")
        os.mkdir(cls.folder)
        with open(CORNER) as f:
            cls.write("deck.yml", f.read() + STUDY)
        cls.write("slow", SLOW % (os.path.join(ROOT, "tests", "cli"), PROGRAM))
        os.chmod(os.path.join(cls.folder, "slow"), 0o755)
        # Slurm signals up to 30 s early, and looks every 30 s: at once, and not at the very end.
        cls.cut = cls.submit("--time=1", "--signal=B:USR1@55", "--output=cut.log", JOB, "run",
                             "deck.yml", "-o", "cut.vtkhdf", "--quiet", *LONG,
                             program=os.path.join(cls.folder, "slow"))

    @classmethod
    def write(cls, name, text):
        with open(os.path.join(cls.folder, name), "w") as f:
            f.write(text)

    @classmethod
    def read(cls, name):
        with open(os.path.join(cls.folder, name)) as f:
            return f.read()

    @classmethod
    def files(cls):
        return sorted(os.listdir(cls.folder))

    @classmethod
    def submit(cls, *words, program=PROGRAM):
        cls.cluster.environment["POLYRAD"] = program
        return cls.cluster.submit("--cpus-per-task=1", *words, cwd=cls.folder)

    def here(self, *words):
        """The program without Slurm, with as many threads as the jobs have."""
        p = subprocess.run([PROGRAM, *words, "--threads", "1"], cwd=self.folder, text=True,
                           stdout=subprocess.PIPE, stderr=subprocess.PIPE)
        self.assertEqual((p.returncode, p.stderr), (0, ""))
        return p.stdout

    def numbers(self, name, dataset):
        if not shutil.which("h5dump"):
            self.skipTest("h5dump is not installed")
        p = subprocess.run(["h5dump", "-m", "%.17g", "-y", "-d", dataset, name], cwd=self.folder,
                           text=True, stdout=subprocess.PIPE, check=True)
        return p.stdout.split("\n", 1)[1]

    def test_study(self):
        """The table from an array of four tasks is that of one process."""
        self.cluster.environment["POLYRAD"] = PROGRAM
        text = self.cluster.call(os.path.join(TOOLS, "study"), "deck.yml", "-o", "table.h5", "--",
                                 "--cpus-per-task=1", "--output=study_%j.log", cwd=self.folder)
        found = re.fullmatch(r"(\d+): 4 tasks, cube_corner_task_1_of_4.vtkhdf .. "
                             r"cube_corner_task_4_of_4.vtkhdf\n(\d+): the table, .*\n", text)
        self.assertTrue(found, text)
        array, table = found.groups()
        self.assertEqual(set(self.cluster.wait(array).values()), {"COMPLETED"}, self.logs())
        self.assertEqual(len(self.cluster.state(array)), 4)
        self.assertEqual(self.cluster.wait(table), {table: "COMPLETED"}, self.logs())
        self.here("study", "deck.yml", "-o", "whole.h5", "--quiet")
        for column in ("method.elements", "unknowns", "error", "ratio", "eoc", "residual"):
            column = "/polyrad/study/" + column
            self.assertEqual(self.numbers("table.h5", column), self.numbers("whole.h5", column))

    def test_parts(self):
        """A matrix assembled by an array of four, solved by one job: the same bits as in one run."""
        words = ("--quiet", "--set", "method.elements=4", "--set", "method.matrix=hierarchical",
                 "--set", "method.quadrature_tolerance=1e-6")
        self.cluster.environment["POLYRAD"] = PROGRAM
        text = self.cluster.call(os.path.join(TOOLS, "parts"), "4", "deck.yml", "-o", "joined.vtkhdf",
                                 *words, "--", "--cpus-per-task=1", "--output=parts_%j.log",
                                 cwd=self.folder)
        found = re.fullmatch(r"(\d+): 4 parts, deck_part_1_of_4.h5 .. deck_part_4_of_4.h5\n"
                             r"(\d+): the solution, .*\n", text)
        self.assertTrue(found, text)
        array, solve = found.groups()
        self.assertEqual(list(self.cluster.wait(array).values()), 4 * ["COMPLETED"], self.logs())
        self.assertEqual(self.cluster.wait(solve), {solve: "COMPLETED"}, self.logs())
        self.here("run", "deck.yml", "-o", "one.vtkhdf", *words)
        value = "/polyrad/solution/value"
        self.assertEqual(self.numbers("joined.vtkhdf", value), self.numbers("one.vtkhdf", value))

    def logs(self):
        return "".join(self.read(name) for name in self.files() if name.endswith(".log"))

    def test_time_limit(self):
        """Cut, requeued, and finished: the same bits as in one go, and no checkpoint is left."""
        self.assertEqual(self.cluster.wait(self.cut), {self.cut: "COMPLETED"}, self.logs())
        log = self.read("cut.log")
        self.assertIn("stopped by SIGUSR1; checkpoint written to polyrad_%s.checkpoint" % self.cut, log)
        self.assertIn("goes into the queue again", log)
        self.assertFalse([name for name in self.files() if "checkpoint" in name])
        self.here("run", "deck.yml", "-o", "whole.vtkhdf", "--quiet", *LONG)
        value = "/polyrad/solution/value"
        self.assertEqual(self.numbers("cut.vtkhdf", value), self.numbers("whole.vtkhdf", value))

    def test_bad_deck(self):
        """The job fails with polyrad's own code and sentence."""
        self.write("bad.yml", "scene: {triangle: []}\n")
        job = self.submit("--output=bad.log", JOB, "run", "bad.yml")
        self.assertEqual(self.cluster.wait(job), {job: "FAILED"})
        self.assertRegex(self.read("bad.log"), r"(?m)^bad\.yml:1:\d+: error: unknown key 'triangle'")

    def test_no_program(self):
        job = self.submit("--output=none.log", JOB, "run", "deck.yml", program="/nowhere/polyrad")
        self.assertEqual(self.cluster.wait(job), {job: "FAILED"})
        self.assertIn("there is no program '/nowhere/polyrad'; export POLYRAD", self.read("none.log"))


if __name__ == "__main__":
    unittest.main()
