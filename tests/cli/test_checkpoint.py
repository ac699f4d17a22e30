"""Runs that are stopped by a signal: a checkpoint that restarts to the same bits, or a clean end.

POLYRAD_TEST_FULL=1 takes ten times as many moments. The seed is printed; POLYRAD_TEST_SEED sets it.
"""

import itertools
import os
import random
import re
import signal
import subprocess
import sys
import time
import unittest

from test_cli import Case, CORNER, PROGRAM, triangle
from waiting import HANG, has_opened, until, until_ready, used_by_children

FULL = bool(os.environ.get("POLYRAD_TEST_FULL"))
N_MOMENT = 200 if FULL else 20
SEED = int(os.environ.get("POLYRAD_TEST_SEED", time.time_ns() % 10**6))
BOTH = (signal.SIGTERM, signal.SIGUSR1)

# What may differ between a run and the same run in pieces; checksums are also of these.
OWN = re.compile(r"attribute: <(started|command|checksum|seconds_\w+|peak_memory_bytes) of <(/[\w/]+)>>"
                 r"|dataset: </polyrad/checksums>")

CORNER_FACES = (triangle("floor", [[0, 0, 0], [1, 0, 0], [0, 1, 0]], [0, 0, 1], 0.5, 0.5)
                + triangle("x0", [[0, 0, 0], [0, 1, 0], [0, 0, 1]], [1, 0, 0], 0.9, 1)
                + triangle("y0", [[0, 0, 0], [0, 0, 1], [1, 0, 0]], [0, 1, 0], 0.5, 0.3))
BLOCKER = triangle("blocker", [[.1, .1, .2], [.4, .1, .2], [.1, .4, .2]], [0, 0, 1], 0.3, 0)
PROBE = "probes:\n  - {name: a, surface: floor, at: [0.3, 0.3, 0]}\n"


def plates(n, tolerance):
    """View factors of n * n triangles below a blocker and n * n above it; all else takes no time."""
    faces = BLOCKER
    for i, j in itertools.product(range(n), range(n)):
        p = [[i / n, j / n], [(i + 1) / n, j / n], [i / n, (j + 1) / n]]
        faces += (triangle("floor", [[*x, 0] for x in p], [0, 0, 1], 0, 0)
                  + triangle("ceiling", [[*x, 1] for x in p], [0, 0, -1], 0, 0))
    return (faces + PROBE + "method: {mesh: uniform, elements: 1, degree: 0}\n"
            "output: {view_factors: true}\naccuracy: {tolerance: %g}\n" % tolerance)


DECKS = {
    "hierarchical": CORNER_FACES + PROBE + "method: {mesh: paper, elements: 8, matrix: hierarchical, "
                    "quadrature_tolerance: 1e-8}\n",
    "dense": CORNER_FACES + PROBE + "method: {mesh: paper, elements: 6, quadrature_tolerance: 1e-9}\n",
    "adaptive": CORNER_FACES + PROBE + "accuracy: {tolerance: 1e-5}\n",
    "shadow": CORNER_FACES + BLOCKER + PROBE + "method: {mesh: uniform, elements: 12, degree: 1, "
              "matrix: hierarchical, quadrature_tolerance: 1e-5}\n",
    "factors": plates(5, 1e-11),
}


def before_main(number):
    """For preexec_fn: the signal comes while the program is loaded, and waits for it."""
    def send():
        signal.pthread_sigmask(signal.SIG_BLOCK, BOTH)
        os.kill(os.getpid(), number)

    return send


class Signals(Case):
    def start(self, *words, **more):
        env = dict(os.environ, LC_ALL="C", OMP_NUM_THREADS="2")
        return subprocess.Popen([PROGRAM, *words], cwd=self.folder, env=env, text=True,
                                stdout=subprocess.PIPE, stderr=subprocess.PIPE, **more)

    def stop(self, moment, number, *words):
        """Start, and send a signal when it has handlers and has worked for a moment [s of processor time];
        exit code and stderr."""
        p = self.start(*words)
        until_ready(p, number, moment)
        return self.end(p, number)

    def end(self, p, number):
        p.send_signal(number)
        _, err = p.communicate(timeout=HANG)
        return p.returncode, err

    def assert_same(self, a, b):
        p = subprocess.run(["h5diff", self.path(a), self.path(b)], text=True, stdout=subprocess.PIPE,
                           stderr=subprocess.STDOUT)
        lines = [line for line in p.stdout.splitlines() if not re.match(r"\d+ differences found", line)]
        self.assertEqual([line for line in lines if not OWN.fullmatch(re.sub(r" and .*", "", line))], [],
                         "files differ")
        self.assertGreater(len(lines), 0, "two runs differ at least in their command")

    def write_deck(self, name):
        """The deck and its result; the processor time that it took."""
        self.write("deck.yml", "scene:\n  triangles:\n" + DECKS[name])
        before = used_by_children()
        self.done("run", "deck.yml", "-o", "whole.h5", "--quiet")
        return used_by_children() - before

    words = ("run", "deck.yml", "-o", "pieces.h5", "--quiet", "--checkpoint", "c.h5", "--restart", "c.h5")

    def look(self, name, n, rng):
        """Stopped at random moments, each time until it is done; the first time as early as possible."""
        whole = self.write_deck(name)
        for k in range(n):
            moment, number = k and 1.1 * whole * rng.random(), rng.choice(BOTH)
            before = used_by_children()
            code, err = self.stop(moment, number, *self.words)
            told = "%s, %s after %.3f of %.3f s: %d, %s" % (name, number.name, moment, whole, code, err)
            self.assertIn(code, (0, 85) if k else (85,), told)
            if code == 0:  # threads that wait for each other use time, too, on a busy machine more
                whole = min(whole, used_by_children() - before)
            else:
                self.assertEqual(self.files(), ["c.h5", "deck.yml", "whole.h5"], told)
                self.assertIn("stopped by %s; checkpoint written to c.h5" % number.name, err)
                code, err = self.stop(rng.choice((0, 0.05 * whole)), number, *self.words)
                if code == 85:  # at once again
                    self.assertRegex(err, "checkpoint (written to|stays as it was in) c.h5")
                else:
                    self.assertEqual((code, err), (0, ""), told)
                    os.remove(self.path("pieces.h5"))
                p = self.call(*self.words)
                self.assertEqual((p.returncode, p.stderr), (0, ""), told)
                os.remove(self.path("c.h5"))
            self.assertEqual(self.files(), ["deck.yml", "pieces.h5", "whole.h5"], told)
            self.assert_same("whole.h5", "pieces.h5")
            os.remove(self.path("pieces.h5"))

    def test_random_moments(self):
        print("seed %d" % SEED, file=sys.__stderr__)
        rng = random.Random(SEED)
        for name in DECKS:
            with self.subTest(name):
                self.look(name, N_MOMENT // len(DECKS), rng)

    def test_before_the_first_line_of_main(self):
        """A signal that came while the program was loaded, and was blocked by who started it."""
        self.write_deck("dense")
        for number in BOTH:
            p = self.start(*self.words, preexec_fn=before_main(number))
            _, err = p.communicate(timeout=HANG)
            self.assertEqual(p.returncode, 85, err)
            self.assertIn("stopped by %s; checkpoint written to c.h5" % number.name, err)
            self.done(*self.words)
            self.assert_same("whole.h5", "pieces.h5")
            os.remove(self.path("c.h5"))

    def test_without_checkpoint(self):
        """Killed by the signal, with a sentence, and nothing written."""
        self.write("deck.yml", "scene:\n  triangles:\n" + DECKS["shadow"].replace("12", "40")
                   + "study: {vary: {method.degree: [1]}}\n")
        for number in BOTH:
            for verb in (["run"], ["study"], ["assemble", "--part", "1/2"]):
                for moment in (0, 0.2):
                    code, err = self.stop(moment, number, *verb, "deck.yml", "-o", "out.h5")
                    self.assertEqual(code, -number, err)
                    self.assertRegex(err, r"\Astopped by %s; nothing is written[^\n]*\n\Z" % number.name)
                    self.assertEqual(self.files(), ["deck.yml"])

    def test_view_factors(self):
        """Stopped among them, and within a pair: they would take much longer."""
        self.write("deck.yml", "scene:\n  triangles:\n" + plates(5, 1e-13))
        for number in BOTH:
            code, err = self.stop(3, number, "run", "deck.yml", "-o", "out.h5", "--quiet")
            self.assertEqual(code, -number, err)
            self.assertRegex(err, r"\Astopped by %s; nothing is written[^\n]*\n\Z" % number.name)
            self.assertEqual(self.files(), ["deck.yml"])

    def test_verbs_that_write_nothing(self):
        """The signal ends them, whenever it comes."""
        for words in (("check", CORNER), ("info", "none.h5"), ("--help",), ("--version",)):
            for number in BOTH:
                p = self.start(*words, preexec_fn=before_main(number))
                self.assertEqual((*p.communicate(timeout=HANG), p.returncode), ("", "", -number), words)
        os.mkfifo(self.path("pipe"))
        for number in BOTH:
            p = self.start("check", "pipe")
            until(p, lambda: has_opened(p, self.path("pipe")))
            self.assertEqual(self.end(p, number), (-number, ""))

    def test_deck_from_a_pipe(self):
        """Nobody writes to it: the signal ends the wait. There is nothing to keep yet, and the same command
        begins anew."""
        os.mkfifo(self.path("pipe"))
        for number in BOTH:
            for verb in ("run", "study"):
                code, err = self.stop(0, number, verb, "pipe", "-o", "out.h5")
                self.assertEqual((code, err[:60].split(":")[0].strip()),
                                 (-number, "stopped by %s; nothing is written" % number.name))
            code, err = self.stop(0, number, "run", "pipe", *self.words[2:])
            self.assertEqual((code, err), (85, "c.h5 does not exist yet: the run starts from the beginning\n"
                                               "stopped by %s before the deck was read; nothing is written: "
                                               "to begin, give the same command again\n" % number.name))
            self.assertEqual(self.files(), ["pipe"])

    def test_mesh_from_a_pipe(self):
        """The deck is read, the scene is not: the checkpoint holds what is known, and a run goes on from it."""
        os.mkfifo(self.path("pipe"))
        self.write("deck.yml", "scene:\n  mesh: {file: pipe}\n  surfaces: {all: {rho: 0.5, emission: 1}}\n"
                               "method: {elements: 1}\n")
        for number in BOTH:
            code, err = self.stop(0, number, *self.words)
            self.assertEqual(code, 85, err)
            self.assertEqual(self.files(), ["c.h5", "deck.yml", "pipe"])
        p = self.start(*self.words)
        self.write("pipe", "usemtl all\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
        _, err = p.communicate(timeout=HANG)
        self.assertEqual((p.returncode, err), (0, ""))
        self.assertEqual(self.files(), ["c.h5", "deck.yml", "pieces.h5", "pipe"])

    def test_whole_deck_from_a_pipe(self):
        """It is read to its end, in however many pieces it comes."""
        os.mkfifo(self.path("pipe"))
        text = "scene:\n  triangles:\n" + CORNER_FACES + "method: {elements: 1}\n"
        p = self.start("run", "pipe", "-o", "out.h5", "--quiet")
        with open(self.path("pipe"), "w") as pipe:
            for line in text.splitlines(keepends=True):
                pipe.write(line)
                pipe.flush()
        _, err = p.communicate(timeout=HANG)
        self.assertEqual((p.returncode, err), (0, ""))

    def test_checkpoint_over_the_deck(self):
        """Refused also when a signal came before there was time to look."""
        self.write_deck("dense")
        before = self.read("deck.yml")
        for number in BOTH:
            for words in (("deck.yml", "-o", "o.h5"), ("o.h5", "-o", "o.h5")):
                code, err = self.stop(0, number, "run", "deck.yml", "--checkpoint", *words)
                self.assertEqual(code, 2, err)
                self.assertIn("would overwrite", err)
                self.assertEqual((self.read("deck.yml"), self.files()), (before, ["deck.yml", "whole.h5"]))


class Parts(Case):
    def same_as_one_run(self, name, n):
        self.write("deck.yml", "scene:\n  triangles:\n" + DECKS[name])
        self.done("run", "deck.yml", "-o", "whole.h5", "--quiet")
        files = ["deck_part_%d_of_%d.h5" % (i, n) for i in range(1, n + 1)]
        for i, file in enumerate(files):
            text = self.done("assemble", "deck.yml", "--part", "%d/%d" % (i + 1, n)).stdout
            self.assertIn("part %d of %d" % (i + 1, n), text)
            self.assertIn("written " + file, text)
        self.done("solve", "deck.yml", "--parts", *files, "-o", "joined.h5", "--quiet")
        self.assertEqual(self.files(), ["deck.yml", *files, "joined.h5", "whole.h5"])
        Signals.assert_same(self, "whole.h5", "joined.h5")
        self.assertIn("polyrad part", self.done("info", files[0]).stdout)

    def test_same_bits(self):
        self.same_as_one_run("shadow", 4)

    def test_same_bits_of_a_dense_matrix(self):
        self.same_as_one_run("dense", 2)

    def test_missing_part(self):
        self.done("assemble", CORNER, *Restart.small, "--part", "1/2", "-o", "a.h5")
        text = self.refused(2, "solve", CORNER, *Restart.small[:2], "--parts", "a.h5", quiet=False)
        self.assertIn("part 2 of 2 is missing; polyrad assemble DECK --part 2/2 makes it", text)
        text = self.refused(2, "solve", CORNER, "--set", "method.elements=2", "--parts", "a.h5")
        self.assertIn("a.h5 was made with other --set options (method.elements=1)", text)
        self.assertEqual(self.files(), ["a.h5"])

    def test_adaptive(self):
        self.write("deck.yml", "scene:\n  triangles:\n" + DECKS["adaptive"])
        text = self.refused(2, "assemble", "deck.yml", "--part", "1/2")
        self.assertIn("adaptive run cannot be assembled in parts", text)
        self.assertIn("mesh by hand", text)

    def test_usage(self):
        self.assertIn("needs --part I/N", self.refused(2, "assemble", CORNER))
        self.assertIn("got '3/2'", self.refused(2, "assemble", CORNER, "--part", "3/2"))
        self.assertIn("needs the parts", self.refused(2, "solve", CORNER))
        self.assertIn("needs the parts", self.refused(2, "solve", CORNER, "--parts"))


class Restart(Case):
    small = ("--set", "method.elements=1", "--quiet")

    def test_missing_checkpoint(self):
        text = self.refused(3, "run", CORNER, *self.small, "--restart", "no.h5")
        self.assertIn("cannot read no.h5: No such file", text)
        text = self.refused(3, "run", CORNER, *self.small, "--restart", "no.h5", "--checkpoint", "c.h5")
        self.assertIn("cannot read no.h5", text)
        self.assertEqual(self.files(), [])

    def test_the_first_of_many_times(self):
        """The same name for both: there need not be one yet."""
        p = self.call("run", CORNER, *self.small, "--restart", "c.h5", "--checkpoint", "c.h5")
        self.assertEqual((p.returncode, p.stderr),
                         (0, "c.h5 does not exist yet: the run starts from the beginning\n"))
        self.assertEqual(self.files(), ["cube_corner.vtkhdf"])

    def test_a_result_is_no_checkpoint(self):
        self.done("run", CORNER, *self.small, "-o", "r.h5")
        text = self.refused(3, "run", CORNER, *self.small, "--restart", "r.h5")
        self.assertIn("r.h5 is not a polyrad checkpoint (a result?)", text)

    def test_a_pipe_is_no_checkpoint(self):
        """Nor a result or a part. Refused at once: nobody may ever write to it."""
        os.mkfifo(self.path("pipe"))
        for words in (("run", CORNER, *self.small, "--restart", "pipe"), ("info", "pipe"),
                      ("study", "--collect", "pipe"), ("solve", CORNER, *self.small, "--parts", "pipe")):
            self.assertIn("cannot read pipe: ", self.refused(3, *words))
        self.assertEqual(self.files(), ["pipe"])

    def test_where_it_cannot_be_written(self):
        """Told before the work is done, not after."""
        text = self.refused(3, "run", CORNER, *self.small, "--checkpoint", "no/such.h5")
        self.assertIn("cannot write no/such.h5: No such file", text)
        text = self.refused(2, "run", CORNER, *self.small, "-o", "a.h5", "--checkpoint", "a.h5")
        self.assertIn("would overwrite", text)
        self.assertEqual(self.files(), [])

    def test_usage(self):
        self.assertIn("--checkpoint needs", self.refused(2, "run", CORNER, "--checkpoint"))
        self.assertIn("are for polyrad run", self.refused(2, "study", CORNER, "--restart", "a.h5"))


if __name__ == "__main__":
    unittest.main()
