"""Hard use: killed at any moment, full disks, read-only folders, two runs writing one file, files cut
short, far too large scenes. Each ends in a clear message, and nothing is lost.

    POLYRAD=build/release/polyrad POLYRAD_INPUTS=inputs python3 -m unittest tests/cli/test_hard_use.py

POLYRAD_TEST_FULL=1: a hundred kills instead of ten, files cut at a thousand places.
"""

import math
import os
import random
import shutil
import signal
import subprocess
import unittest

import test_cli
from waiting import HANG, is_larger, until, until_ready, used_by_children

FULL = os.environ.get("POLYRAD_TEST_FULL") == "1"
SEED = int(os.environ.get("RAD_TEST_SEED", "2003"))
# A file of 0.7 MB; one thread, because BLAS rounds otherwise with more of them.
LARGE = ("--threads", "1", "--set", "method.elements=1", "--set", "output.sampling=32")


class Case(test_cli.Case):
    def start(self, *words, **more):
        env = dict(os.environ, LC_ALL="C")
        return subprocess.Popen([test_cli.PROGRAM, *words], cwd=self.folder, env=env, text=True,
                                stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, **more)

    def run_large(self, name, rho):
        """A result of a good size, told apart by its rho."""
        self.done("run", test_cli.CORNER, "-o", name, "--quiet", *LARGE, "--set",
                  "scene.triangles.0.rho=%g" % rho)
        return self.content(name)

    def content(self, name):
        """The solution in a file that is whole: polyrad reads all of it, h5dump prints it."""
        self.done("info", name)
        if not shutil.which("h5dump"):
            self.skipTest("h5dump is not installed")
        p = subprocess.run(["h5dump", "-m", "%.17g", "-d", "/polyrad/solution/value", "-y",
                            self.path(name)], text=True, stdout=subprocess.PIPE, check=True)
        return p.stdout.split("\n", 1)[1]

    def mount(self, name, size):
        """A disk of its own, or the test is skipped: only root can mount."""
        os.mkdir(self.path(name))
        p = subprocess.run(["mount", "-t", "tmpfs", "-o", "size=%d" % size, "polyrad_test",
                            self.path(name)], stderr=subprocess.PIPE, text=True)
        if p.returncode:
            self.skipTest("no disk can be mounted here: " + p.stderr.strip())
        self.addCleanup(subprocess.run, ["umount", self.path(name)], check=True)


class Killed(Case):
    def test_kill_at_random_moments(self):
        """The file is the old or the new one, whole; at most one .tmp is left, and told from it. Every
        second kill strikes while the file is being written."""
        chance = random.Random(SEED)
        before = used_by_children()
        new = self.run_large("out.h5", 0.25)
        whole = used_by_children() - before
        old = self.run_large("out.h5", 0.5)
        before = self.read("out.h5")
        self.assertNotEqual(old, new)
        survived = cut = 0
        for k in range(100 if FULL else 10):
            self.write("out.h5", before)
            p = self.start("run", test_cli.CORNER, "-o", "out.h5", "--quiet", *LARGE, "--set",
                           "scene.triangles.0.rho=0.25")
            temporary = "out.h5.%d.tmp" % p.pid
            if k % 2:
                size = chance.randrange(-1, len(before) * 5 // 4)  # larger than it gets: the run ends
                until(p, lambda: is_larger(self.path(temporary), size))
            else:
                until_ready(p, signal.SIGTERM, chance.uniform(0, whole))
            p.kill()
            message = p.communicate()[1]
            self.assertIn(p.returncode, (0, -signal.SIGKILL), message)
            self.assertLessEqual(set(self.files()), {"out.h5", temporary})
            if self.read("out.h5") != before:
                self.assertTrue(self.content("out.h5") == new, "seed %d, kill %d" % (SEED, k))
                survived += 1
            if os.path.exists(self.path(temporary)):
                os.remove(self.path(temporary))
                cut += 1
        print("of the runs %d had written their file, %d left a .tmp" % (survived, cut))
        self.assertTrue(self.run_large("out.h5", 0.25) == new)

    def test_interrupted(self):
        """Control-C and a batch system's SIGTERM leave nothing behind. The run takes some seconds."""
        # what a shell starts in the background ignores SIGINT, and so would its children
        self.addCleanup(signal.signal, signal.SIGINT, signal.signal(signal.SIGINT, signal.default_int_handler))
        self.run_large("out.h5", 0.5)
        before = self.read("out.h5")
        for number in (signal.SIGINT, signal.SIGTERM):
            for moment in (0, 0.1):
                p = self.start("run", test_cli.CORNER, "-o", "out.h5", "--quiet", "--set",
                               "method.elements=16")
                until_ready(p, signal.SIGTERM, moment)
                p.send_signal(number)
                p.communicate()
                self.assertEqual(p.returncode, -number)
                self.assertEqual(self.files(), ["out.h5"])
                self.assertEqual(self.read("out.h5"), before)


class Disks(Case):
    def test_full_disk(self):
        """Room for the old result but not for a second one: refused, the old one stays."""
        self.mount("disk", 1 << 19)
        small = ("--quiet", "--set", "method.elements=2", "--set", "output.sampling=1")
        self.done("run", test_cli.CORNER, "-o", "disk/out.h5", *small)
        before = self.read("disk/out.h5")
        text = self.refused(3, "run", test_cli.CORNER, "-o", "disk/out.h5", "--quiet", *LARGE)
        self.assertIn("cannot write disk/out.h5: No space left on device; free some space", text)
        self.assertEqual(os.listdir(self.path("disk")), ["out.h5"])
        self.assertEqual(self.read("disk/out.h5"), before)

    def test_full_disk_study(self):
        self.mount("disk", 1 << 14)
        self.write("deck.yml", test_cli.SCENE + "study: {vary: {method.elements: [1, 2]}}\n")
        self.write("disk/filler", b"x" * (1 << 14))
        text = self.refused(3, "study", "deck.yml", "-o", "disk/table.h5", "--quiet")
        self.assertIn("No space left", text)
        self.assertEqual(os.listdir(self.path("disk")), ["filler"])

    def test_read_only_disk(self):
        self.mount("disk", 1 << 20)
        self.write("disk/out.h5", b"what was here before")
        subprocess.run(["mount", "-o", "remount,ro", self.path("disk")], check=True)
        for name in ("disk/out.h5", "disk/new.h5"):
            text = self.refused(3, "run", test_cli.CORNER, "-o", name, "--quiet", "--set",
                                "method.elements=1")
            self.assertIn("cannot write %s: Read-only file system; name a file and folder that you "
                          "may write to" % name, text)
        self.assertEqual(os.listdir(self.path("disk")), ["out.h5"])
        self.assertEqual(self.read("disk/out.h5"), b"what was here before")

    def test_folder_without_permission(self):
        """As a user whom permissions stop; root becomes nobody."""
        os.mkdir(self.path("folder"))
        self.write("folder/out.h5", b"what was here before")
        os.chmod(self.path("folder"), 0o555)
        os.chmod(self.folder, 0o755)
        self.addCleanup(os.chmod, self.path("folder"), 0o755)
        shutil.copy(test_cli.PROGRAM, self.path("polyrad"))  # nobody may not read every build folder
        shutil.copy(test_cli.CORNER, self.path("deck.yml"))
        user = {} if os.geteuid() else {"user": 65534, "group": 65534, "extra_groups": []}
        for name in ("folder/new.h5", "folder/out.h5"):
            p = subprocess.run([self.path("polyrad"), "run", "deck.yml", "-o", name, "--quiet", "--set",
                                "method.elements=1"], cwd=self.folder, text=True,
                               stderr=subprocess.PIPE, **user)
            self.assertEqual(p.returncode, 3, p.stderr)
            self.assertRegex(p.stderr, r"\Acannot write %s: Permission denied; [^\n]*\n\Z" % name)
        self.assertEqual(os.listdir(self.path("folder")), ["out.h5"])
        self.assertEqual(self.read("folder/out.h5"), b"what was here before")


class TwoWriters(Case):
    def test_two_runs_one_file(self):
        """One of them wins, whole; the other's work is not mixed in."""
        results = [self.run_large("%d.h5" % k, rho) for k, rho in enumerate((0.25, 0.5))]
        for _ in range(10 if FULL else 3):
            pair = [self.start("run", test_cli.CORNER, "-o", "out.h5", "--quiet", *LARGE, "--set",
                               "scene.triangles.0.rho=%g" % rho) for rho in (0.25, 0.5)]
            for p in pair:
                message = p.communicate(timeout=HANG)[1]
                self.assertEqual((p.returncode, message), (0, ""))
            self.assertTrue(self.content("out.h5") in results)
            self.assertEqual(self.files(), ["0.h5", "1.h5", "out.h5"])


class CutShort(Case):
    def test_info(self):
        """Every beginning of a result is refused with its name; the whole is read."""
        self.done("run", test_cli.CORNER, "-o", "out.h5", "--quiet", "--set", "method.elements=1")
        whole = self.read("out.h5")
        step = max(1, len(whole) // (1000 if FULL else 40))
        for size in [0, 1, 8, *range(step, len(whole), step), len(whole) - 1]:
            self.write("cut.h5", whole[:size])
            self.assertIn("cut.h5", self.refused(3, "info", "cut.h5"))
        self.done("info", "out.h5")


class Checkpoints(Case):
    """A run that takes about a second, stopped in between."""

    words = ("run", test_cli.CORNER, "-o", "out.h5", "--quiet", "--threads", "1", "--set",
             "method.elements=4", "--set", "method.quadrature_tolerance=1e-13", "--checkpoint", "c.ck",
             "--restart", "c.ck")

    def stop(self, moment):
        """Ask the run to stop when it has worked for a moment; the process, which now writes its checkpoint."""
        p = self.start(*self.words)
        until_ready(p, signal.SIGUSR1, moment)
        p.send_signal(signal.SIGUSR1)
        return p

    def write_checkpoint(self):
        """In the middle of the run; the moment, at which it can be stopped again."""
        moment = 0.3
        for _ in range(8):  # earlier on a quick machine
            p = self.stop(moment)
            p.communicate(timeout=HANG)
            if p.returncode == 85:
                return moment
            moment /= 2
        self.fail("the run could not be stopped on its way")

    def test_cut_short(self):
        self.write_checkpoint()
        self.assertEqual(self.files(), ["c.ck"])
        whole = self.read("c.ck")
        for size in (0, 8, 511, 512, 5000, len(whole) // 2, len(whole) - 1):
            self.write("c.ck", whole[:size])
            text = self.refused(3, *self.words)
            self.assertRegex(text, r"\Ac\.ck is (damaged: cut, or changed|not a polyrad checkpoint)")
            self.assertEqual(self.files(), ["c.ck"])
            self.assertEqual(self.read("c.ck"), whole[:size])
        self.write("c.ck", whole)
        self.done(*self.words)

    def test_killed_while_it_is_written(self):
        """What was there before is whole, and a run goes on from it."""
        moment = self.write_checkpoint()
        before = self.read("c.ck")
        for k in range(20 if FULL else 2):
            p = self.stop(moment)
            temporary = "c.ck.%d.tmp" % p.pid
            until(p, lambda: os.path.exists(self.path(temporary)))
            p.kill()
            p.communicate()
            left = set(self.files()) - {"out.h5"}
            self.assertLessEqual(left, {"c.ck", temporary})
            if self.read("c.ck") == before and os.path.exists(self.path(temporary)):
                os.remove(self.path(temporary))
        self.done(*self.words)


class ManyTriangles(Case):
    """Who sees whom would take 1e12 bytes: told as soon as the scene is read."""

    def test_million_triangles(self):
        n = 708  # 2 x 708^2 triangles of a hilly square
        with open(self.path("hills.obj"), "w") as f:
            for j in range(n + 1):
                f.write("".join("v %g %g %g\n" % (i, j, 9 * math.sin(i / 25) * math.cos(j / 31))
                                for i in range(n + 1)))
            for j in range(n):
                first = range(j * (n + 1) + 1, j * (n + 1) + n + 1)
                f.write("".join("f %d %d %d\nf %d %d %d\n" %
                                (k, k + 1, k + n + 2, k, k + n + 2, k + n + 1) for k in first))
        self.write("deck.yml", "scene:\n  mesh: {file: hills.obj}\n"
                               "  surfaces: {hills: {rho: 0.5, emission: 1}}\n")
        text = self.refused(3, "run", "deck.yml", preexec_fn=test_cli.limit_memory(4 * 1000 ** 3))
        self.assertRegex(text, r"1002528 triangles, and the table of who sees whom takes 1\.01e\+03 "
                               r"GB, but only [23]\.\d+ GB are available; merge")
        self.assertEqual(self.files(), ["deck.yml", "hills.obj"])


if __name__ == "__main__":
    unittest.main()
