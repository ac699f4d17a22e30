"""The program as users meet it: exit codes, messages, files written and files left alone.

    POLYRAD=build/release/polyrad POLYRAD_INPUTS=inputs python3 -m unittest discover tests/cli

Standard library only. Every test runs in a folder of its own, which is also the working folder of
the program.
"""

import os
import re
import resource
import shutil
import subprocess
import tempfile
import time
import unittest
from unittest import mock

from waiting import HANG

PROGRAM = os.path.abspath(os.environ.get("POLYRAD", "build/release/polyrad"))
INPUTS = os.path.abspath(os.environ.get("POLYRAD_INPUTS", "inputs"))
CORNER = os.path.join(INPUTS, "cube_corner.yml")

ONE = "scene:\n  triangles:\n    - {%s}\n"  # a deck of one triangle
GOOD = "vertices: [[0,0,0],[1,0,0],[0,1,0]], rho: 0.5, emission: 1"
SCENE = ONE % ("name: floor, " + GOOD)  # three lines: sections appended to it start on line 4

# name: deck, expected words. @@ stands where the error is; it is not part of the deck.
BAD_DECKS = {
    "unknown_section": (SCENE + "@@methd: {elements: 1}\n", "did you mean 'method'"),
    "unknown_method_key": (SCENE + "method:\n  @@elementz: 1\n", "did you mean 'elements'"),
    "unknown_triangle_key": (ONE % (GOOD.replace("rho", "@@roh")), "did you mean 'rho'"),
    "unknown_output_key": (SCENE + "output: {@@fil: a.h5}\n", "did you mean 'file'"),
    "duplicate_section": (SCENE + "title: a\n@@title: b\n", "first given on line 4"),
    "duplicate_key": (SCENE + "method:\n  degree: 1\n  @@degree: 2\n", "duplicate key 'degree'"),
    "word_for_number": (SCENE + "method: {elements: @@many}\n", "'elements' is many"),
    "quoted_number": (SCENE + 'method: {elements: @@"8"}\n', "whole number"),
    "hexadecimal_number": (SCENE + "method: {elements: @@0x10}\n", "whole number"),
    "fraction_for_whole": (SCENE + "method: {elements: @@1.5}\n", "whole number"),
    "no_elements": (SCENE + "method: {elements: @@0}\n", "from 1 to"),
    "negative_degree": (SCENE + "method: {degree: @@-1}\n", "from 0 to"),
    "degree_too_high": (SCENE + "method: {degree: @@1000}\n", "from 0 to"),
    "grading_below_one": (SCENE + "method: {grading: @@0.5}\n", "from 1 to 8"),
    "fraction_in_graded_mesh": (SCENE + "method: {mesh: graded, grading: @@1.5}\n", "mesh: graded"),
    "misspelt_choice": (SCENE + "method: {mesh: @@papper}\n", "did you mean 'paper'"),
    "bounces_without_neumann": (SCENE + "method: {solver: lu, bounces: @@3}\n", "neumann"),
    "tolerance_zero": (SCENE + "accuracy: {tolerance: @@0}\n", "greater than 0"),
    "rho_above_one": (ONE % GOOD.replace("0.5", "@@1.5"), "from 0 to 1"),
    "negative_emission": (ONE % GOOD.replace("emission: 1", "emission: @@-1"), "0 or more"),
    "nan_coordinate": (ONE % GOOD.replace("[0,0,0]", "[0,0,@@.nan]"), "finite"),
    "huge_coordinate": (ONE % GOOD.replace("[0,0,0]", "[0,0,@@1e999]"), "finite"),
    "two_vertices": (ONE % "vertices: @@[[0,0,0],[1,0,0]], rho: 1, emission: 1", "3 points"),
    "four_coordinates": (ONE % GOOD.replace("[1,0,0]", "@@[1,0,0,0]"), "a list of 3 numbers"),
    "no_vertices": ("scene:\n  triangles:\n    - @@{rho: 1, emission: 1}\n", "no 'vertices'"),
    "zero_normal": (ONE % (GOOD + ", normal: @@[0,0,0]"), "not zero"),
    "normal_and_side": (ONE % (GOOD + ", normal: [0,0,1], side: @@front"), "remove one"),
    "two_gradings": (ONE % (GOOD + ", grading: @@[1, 2]"), "3 (edges) or 6"),
    "no_scene": ("@@title: nothing to see\n", "no 'scene'"),
    "empty_file": ("@@", "empty"),
    "list_at_the_top": ("@@[1, 2]\n", "no mapping"),
    "no_triangles": ("scene:\n  triangles: @@[]\n", "at least one triangle"),
    "open_bracket": ("scene:\n  triangles: [1, 2\nmethod@@: {}\n", "not valid YAML"),
    "tab": ("scene:\n@@\ttriangles: []\n", "tab"),
    "not_utf8": (SCENE.encode() + b"title: caf@@\xe9\n", "UTF-8"),
    "alias": (SCENE + "title: @@*title\n", "not supported"),
    "second_document": (SCENE + "@@---\ntitle: b\n", "second document"),
    "three_values_for_two_bands": ("bands: [a, b]\n" + ONE % GOOD.replace("0.5", "@@[0, 0, 0]"),
                                   "2 bands"),
    "band_named_twice": ("bands: [a, @@a]\n" + SCENE, "named twice"),
    "probe_without_place": (SCENE + "probes:\n  - @@{name: a}\n", "no 'at'"),
    "unknown_field": (SCENE + "output: {fields: [radiosity, @@colour]}\n", "irradiance"),
    "study_of_unknown_key": (SCENE + "study: {vary: {@@method.elemnts: [1, 2]}}\n",
                             "did you mean 'elements'"),
    "study_of_bad_value": (SCENE + "study: {vary: {method.elements: [1, @@0]}}\n", "from 1 to"),
    "study_without_such_reference":
        (SCENE + "study: {vary: {method.elements: [1, 2]}, reference: @@first}\n", "last"),
}


def triangle(name, vertices, normal, rho=0.5, emission=1.0):
    return "    - {name: %s, vertices: %s, normal: %s, rho: %g, emission: %g}\n" % (
        name, vertices, normal, rho, emission)


def tetrahedron(rho):
    """Closed: every face looks inside."""
    v = [[1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]]
    faces = ""
    for k in range(4):
        corners = [p for i, p in enumerate(v) if i != k]
        faces += triangle("face_%d" % k, corners, v[k], rho)
    return "scene:\n  triangles:\n" + faces + "method: {elements: 1}\n"


def kill_on_file_larger_than(size):
    return lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (size, size))


def limit_memory(size):
    return lambda: resource.setrlimit(resource.RLIMIT_AS, (size, size))


def limit_processor(seconds):
    """Of processor time, of all threads, which does not depend on how busy the machine is."""
    return lambda: resource.setrlimit(resource.RLIMIT_CPU, (seconds, seconds))


class Case(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.mkdtemp(prefix="polyrad_cli_")
        self.addCleanup(shutil.rmtree, self.folder)

    def path(self, name):
        return os.path.join(self.folder, name)

    def write(self, name, text):
        with open(self.path(name), "wb") as f:
            f.write(text if isinstance(text, bytes) else text.encode())
        return name

    def read(self, name):
        with open(self.path(name), "rb") as f:
            return f.read()

    def files(self):
        return sorted(os.listdir(self.folder))

    def call(self, *words, threads=2, **more):
        env = dict(os.environ, LC_ALL="C", OMP_NUM_THREADS=str(threads))
        p = subprocess.run([PROGRAM, *words], cwd=self.folder, env=env, text=True,
                           stdout=subprocess.PIPE, stderr=subprocess.PIPE, timeout=HANG, **more)
        # a line a minute, on a machine so busy that a run takes minutes
        p.stderr = re.sub(r"(?m)^progress: .* GB\n", "", p.stderr)
        return p

    def done(self, *words, **more):
        """The program does what it was told, without a word on stderr."""
        p = self.call(*words, **more)
        self.assertEqual((p.returncode, p.stderr), (0, ""), p.stdout)
        return p

    def refused(self, code, *words, quiet=True, **more):
        """Exit code, one sentence on stderr, and (quiet) nothing on stdout; returns the sentence."""
        p = self.call(*words, **more)
        self.assertEqual(p.returncode, code, p.stdout + p.stderr)
        self.assertRegex(p.stderr, r"\A[^\n]{20,600}\n\Z", "one line on stderr")
        if quiet:
            self.assertEqual(p.stdout, "")
        return p.stderr


class Usage(Case):
    def tearDown(self):
        self.assertEqual(self.files(), [])

    def test_help(self):
        text = self.done("--help").stdout
        for word in ("run DECK", "check DECK", "study DECK", "info FILE", "--set KEY=VALUE",
                     "--threads N", "--quiet", "-o FILE", "Exit codes"):
            self.assertIn(word, text)

    def test_help_after_each_command(self):
        for verb in ("run", "check", "study", "info"):
            self.assertIn("polyrad %s" % verb, self.done(verb, "--help").stdout)

    def test_version(self):
        self.assertRegex(self.done("--version").stdout, r"\Apolyrad \d+\.\d+\.\d+ \(\w+.*\)\n")

    def test_no_arguments(self):
        p = self.call()
        self.assertEqual((p.returncode, p.stdout), (2, ""))
        self.assertIn("polyrad run DECK", p.stderr)

    def test_unknown_command(self):
        self.assertIn("'frobnicate'", self.refused(2, "frobnicate"))

    def test_unknown_option(self):
        self.assertIn("'--frob'", self.refused(2, "run", CORNER, "--frob"))

    def test_command_without_operand(self):
        for verb, operand in (("run", "DECK"), ("check", "DECK"), ("study", "DECK"), ("info", "FILE")):
            self.assertIn("needs a %s" % operand, self.refused(2, verb))

    def test_missing_deck(self):
        for verb in ("run", "check", "study"):
            text = self.refused(3, verb, "no_such.yml")
            self.assertTrue(text.startswith("no_such.yml: "), text)
            self.assertIn("No such file", text)

    def test_folder_as_deck(self):
        self.assertIn("Is a directory", self.refused(3, "run", "."))

    def test_two_decks(self):
        self.assertIn("one file at a time", self.refused(2, "run", CORNER, "other.yml"))

    def test_bad_threads(self):
        for bad in ("0", "-1", "two", "2.5", "", "99999999999999999999"):
            text = self.refused(2, "run", CORNER, "--threads", bad)
            self.assertIn("got '%s'" % bad, text)

    def test_option_without_value(self):
        self.assertIn("-o needs", self.refused(2, "run", CORNER, "-o"))
        self.assertIn("--set needs", self.refused(2, "run", CORNER, "--set"))
        self.assertIn("--threads needs", self.refused(2, "run", CORNER, "--threads"))

    def test_bad_override(self):
        text = self.refused(2, "run", CORNER, "--set", "methd.elements=1")
        self.assertTrue(text.startswith("--set methd.elements=1: error: "), text)
        self.assertIn("did you mean 'method'", text)
        text = self.refused(2, "run", CORNER, "--set", "method.elements=0")
        self.assertIn("from 1 to", text)
        self.assertIn("there is no '='", self.refused(2, "run", CORNER, "--set", "method.elements"))

    def test_study_without_section(self):
        self.assertIn("no section `study`", self.refused(2, "study", CORNER))


class BadDecks(Case):
    """Errors of the deck: PATH:LINE:COLUMN, and nothing written. Tests are made from the table."""

    def look(self, deck, words):
        text = deck if isinstance(deck, bytes) else deck.encode()
        self.assertEqual(text.count(b"@@"), 1, "one mark in the deck")
        before = text[:text.index(b"@@")]
        line = before.count(b"\n") + 1
        column = len(before.rsplit(b"\n", 1)[-1]) + 1
        self.write("deck.yml", text.replace(b"@@", b""))
        for verb in ("run", "check", "study"):
            message = self.refused(2, verb, "deck.yml")
            start = "deck.yml:%d:%d: error: " % (line, column)
            self.assertEqual(message[:len(start)], start, message)
            self.assertIn(words, message[len(start):])
        self.assertEqual(self.files(), ["deck.yml"])

    def test_good_deck_passes(self):
        """The deck from which most of the bad ones are made is good."""
        self.write("deck.yml", SCENE + "method: {elements: 1}\n")
        self.done("run", "deck.yml")
        self.assertEqual(self.files(), ["deck.vtkhdf", "deck.yml"])


def add_bad_decks():
    for name, (deck, words) in BAD_DECKS.items():
        def test(self, deck=deck, words=words):
            self.look(deck, words)
        setattr(BadDecks, "test_" + name, test)


add_bad_decks()


class Scenes(Case):
    """Decks that read well but hold a scene that cannot be solved: PATH:LINE, nothing written."""

    def look(self, deck, line, *words):
        self.write("deck.yml", deck)
        for verb in ("run", "check"):
            text = self.refused(2, verb, "deck.yml")
            start = "deck.yml:%d: error: " % line if line else "deck.yml: error: "
            self.assertEqual(text[:len(start)], start, text)
            for word in words:
                self.assertIn(word, text)
        self.assertEqual(self.files(), ["deck.yml"])

    def test_triangle_of_three_points_on_a_line(self):
        self.look(SCENE + triangle("flat", [[3, 0, 0], [4, 0, 0], [6, 0, 0]], [0, 0, 1]), 4,
                  "triangle 2 (flat)", "degenerate", "on a line")

    def test_triangle_with_equal_vertices(self):
        self.look(SCENE + triangle("flat", [[3, 0, 0], [4, 0, 0], [4, 0, 0]], [0, 0, 1]), 4,
                  "triangle 2 (flat)", "degenerate", "vertices 2 and 3")

    def test_duplicate_triangle(self):
        self.look(SCENE + triangle("again", [[1, 0, 0], [0, 1, 0], [0, 0, 0]], [0, 0, 1]), 4,
                  "triangle 2 (again)", "triangle 1 (floor)", "same normal")

    def test_slit_is_no_duplicate(self):
        self.write("deck.yml", SCENE + triangle("below", [[0, 0, 0], [0, 1, 0], [1, 0, 0]], [0, 0, -1])
                   + triangle("seen", [[0, 0, 1], [0, 1, 1], [1, 0, 1]], [0, 0, -1])
                   + "method: {elements: 1}\n")
        self.done("run", "deck.yml")

    def test_normal_not_perpendicular(self):
        self.look(SCENE + triangle("tilted", [[3, 0, 0], [4, 0, 0], [3, 1, 0]], [0, 1, 1]), 4,
                  "triangle 2 (tilted)", "normal [0, 1, 1]", "45 degrees")

    def test_no_rho(self):
        self.look(ONE % "name: a, vertices: [[0,0,0],[1,0,0],[0,1,0]], emission: 1", 3,
                  "triangle 1 (a)", "no rho")

    def test_properties_of_unknown_surface(self):
        self.look(SCENE + "  surfaces:\n    flor: {rho: 1}\n", 5, "did you mean 'floor'")

    def test_probe_off_the_surface(self):
        self.look(SCENE + "probes:\n  - {name: up, surface: floor, at: [0.2, 0.2, 0.1]}\n", 5,
                  "probe up", "(0.2, 0.2, 0.1)", "does not lie on floor")

    def test_probe_outside_every_triangle(self):
        self.look(SCENE + "probes:\n  - {name: out, at: [0.9, 0.9, 0]}\n", 5,
                  "probe out", "does not lie on any surface")

    def test_probe_on_unknown_surface(self):
        self.look(SCENE + "probes:\n  - {name: a, surface: flor, at: [0.2, 0.2, 0]}\n", 5,
                  "probe a", "'flor'", "does not exist")

    def test_touching_triangles_are_a_warning(self):
        """A T-junction: told on stderr, and the run goes on."""
        self.write("deck.yml", SCENE
                   + triangle("wall", [[0, 0, 0], [0.5, 0, 0], [0, 0, 1]], [0, 1, 0])
                   + "method: {elements: 1}\n")
        p = self.call("run", "deck.yml", "--quiet")
        self.assertEqual((p.returncode, p.stdout), (0, ""))
        self.assertRegex(p.stderr, r"\Adeck\.yml:4: warning: triangle 2 \(wall\) touches triangle 1 "
                                   r"\(floor\)[^\n]*\n\Z")
        self.assertIn("deck.vtkhdf", self.files())


class Closed(Case):
    def test_white_everywhere_is_refused(self):
        self.write("deck.yml", tetrahedron(1))
        for solver in ("lu", "gmres", "neumann"):
            text = self.refused(1, "run", "deck.yml", "--quiet", "--set", "method.solver=" + solver)
            for word in ("singular", "closed", "rho = 1", "face_"):
                self.assertIn(word, text)
            self.assertEqual(self.files(), ["deck.yml"])

    def test_grey_everywhere_is_not(self):
        """E = 1, rho = 0.5: u = 2 exactly."""
        self.write("deck.yml", tetrahedron(0.5))
        text = self.done("run", "deck.yml").stdout
        means = re.findall(r"face_\d +\S+ +(\S+)", text)
        self.assertEqual(len(means), 4, text)
        for mean in means:
            self.assertAlmostEqual(float(mean), 2, delta=1e-8)


class Output(Case):
    """What is written where, and what stays when it cannot be."""

    small = ("--set", "method.elements=1", "--quiet")

    def test_default_name(self):
        """The name in the deck, in the working folder."""
        self.done("run", CORNER, *self.small)
        self.assertEqual(self.files(), ["cube_corner.vtkhdf"])

    def test_o_wins_over_the_deck(self):
        self.done("run", CORNER, "-o", "mine.h5", *self.small)
        self.assertEqual(self.files(), ["mine.h5"])

    def test_quiet_prints_nothing(self):
        self.assertEqual(self.done("run", CORNER, *self.small).stdout, "")

    def test_summary(self):
        text = self.done("run", CORNER, "--set", "method.elements=1").stdout
        for word in ("72 unknowns", "floor", "wall_x0", "wall_y0", "middle", "residual",
                     "written  cube_corner.vtkhdf"):
            self.assertIn(word, text)

    def test_set_overrides(self):
        text = self.done("run", CORNER, "--set", "method.elements=2", "--set", "method.degree=0",
                         "--set", "title=Another", "--set", "output.file=named.h5").stdout
        self.assertIn("72 elements, 72 unknowns", text)
        self.assertTrue(text.startswith("Another\n"), text)
        self.assertEqual(self.files(), ["named.h5"])

    def test_last_set_wins(self):
        text = self.done("run", CORNER, "--set", "method.elements=4",
                         "--set", "method.elements=1").stdout
        self.assertIn("72 unknowns", text)

    def test_missing_folder(self):
        text = self.refused(3, "run", CORNER, "-o", "no/such/file.h5", *self.small)
        self.assertIn("cannot write no/such/file.h5: No such file", text)
        self.assertEqual(self.files(), [])

    def test_folder_as_file(self):
        os.mkdir(self.path("taken"))
        text = self.refused(3, "run", CORNER, "-o", "taken", *self.small)
        self.assertIn("cannot write taken: Is a directory", text)
        self.assertEqual((self.files(), os.listdir(self.path("taken"))), (["taken"], []))

    def test_device_full(self):
        """No half file under the final name, nor under a temporary one."""
        text = self.refused(3, "run", CORNER, "-o", "out.h5", *self.small,
                            preexec_fn=kill_on_file_larger_than(4096))
        self.assertIn("cannot write out.h5: File too large", text)
        self.assertEqual(self.files(), [])

    def test_device_full_leaves_the_old_file(self):
        self.write("out.h5", b"what was here before")
        self.refused(3, "run", CORNER, "-o", "out.h5", *self.small,
                     preexec_fn=kill_on_file_larger_than(4096))
        self.assertEqual(self.files(), ["out.h5"])
        self.assertEqual(self.read("out.h5"), b"what was here before")

    def test_full_device_file(self):
        if not os.path.exists("/dev/full"):
            self.skipTest("no /dev/full here")
        text = self.refused(3, "run", CORNER, "-o", "/dev/full", *self.small)
        self.assertIn("No space left", text)

    def test_summary_into_full_device(self):
        if not os.path.exists("/dev/full"):
            self.skipTest("no /dev/full here")
        with open("/dev/full", "w") as full:
            p = subprocess.run([PROGRAM, "--help"], stdout=full, stderr=subprocess.PIPE, text=True)
            q = subprocess.run([PROGRAM, "run", CORNER, "-o", self.path("a.h5"), "--set",
                                "method.elements=1"], stdout=full, stderr=subprocess.PIPE, text=True)
        self.assertEqual(q.returncode, 3)
        self.assertIn("standard output", q.stderr)
        self.assertIn(p.returncode, (0, 3))

    def test_success_replaces_the_old_file(self):
        self.write("out.h5", b"what was here before")
        self.done("run", CORNER, "-o", "out.h5", *self.small)
        self.assertEqual(self.files(), ["out.h5"])
        self.assertEqual(self.read("out.h5")[:8], b"\x89HDF\r\n\x1a\n")

    def test_study_into_missing_folder(self):
        self.write("deck.yml", SCENE + "study: {vary: {method.elements: [1, 2]}}\n")
        self.refused(3, "study", "deck.yml", "-o", "no/table.h5", "--quiet")
        self.assertEqual(self.files(), ["deck.yml"])


class Memory(Case):
    """Runs that cannot fit are refused before anything is computed, with both numbers."""

    def look(self, verb):
        def limit():
            limit_memory(1500 * 1000 * 1000)()
            limit_processor(10)()  # killed if it assembles; being refused takes 30 ms

        text = self.refused(3, verb, CORNER, "--set", "method.elements=32", "--set",
                            "method.matrix=dense", quiet=False, preexec_fn=limit)
        found = re.search(r"needs (\S+) GB of memory.* (\S+) GB are available", text)
        self.assertTrue(found, text)
        need, have = map(float, found.groups())
        self.assertTrue(8 * 73728 ** 2 / 1e9 < need < 2.5 * 8 * 73728 ** 2 / 1e9, text)
        self.assertTrue(0.2 < have < 1.5, text)
        self.assertEqual(self.files(), [])
        return text

    def test_run(self):
        self.assertIn("73728 unknowns", self.look("run"))

    def test_check(self):
        self.look("check")

    def test_lu_is_told_of_gmres(self):
        """LU needs twice the memory: the message says what would do."""
        text = self.refused(3, "run", CORNER, "--set", "method.elements=8", "--set",
                            "method.solver=lu", quiet=False,
                            preexec_fn=limit_memory(600 * 1000 * 1000))
        self.assertIn("GB of memory for 4608 unknowns", text)

    def test_enough_memory(self):
        self.done("run", CORNER, "--set", "method.elements=1",
                  preexec_fn=limit_memory(1500 * 1000 * 1000))

    def test_hierarchical_is_refused(self):
        """Both forms are too large."""
        text = self.refused(3, "run", CORNER, "--set", "method.elements=32", "--set",
                            "method.quadrature_tolerance=1e-10", quiet=False,
                            preexec_fn=limit_memory(900 * 1000 * 1000))
        self.assertRegex(text, r"needs \S+ GB of memory for 73728 unknowns.* \S+ GB are available")
        self.assertEqual(self.files(), [])

    def test_a_limit_makes_it_hierarchical(self):
        """8 x 4608^2 bytes do not fit, the compressed form does; without a limit it is dense."""
        words = (CORNER, "--set", "method.elements=8", "--set",
                 "method.quadrature_tolerance=1e-8")
        limit, left = 1000 * 1000 * 1000, 155 * 1000 * 1000  # less than the dense form takes
        free = self.done("check", *words, threads=1, preexec_fn=limit_memory(limit)).stdout
        self.assertIn(", dense;", free)
        available = 1e6 * float(re.search(r"of (\S+) MB available", free).group(1))
        tight = limit_memory(int(limit - available + left))
        held = self.done("run", *words, threads=1, preexec_fn=tight).stdout
        self.assertIn("matrix   hierarchical", held)
        self.assertEqual(self.files(), ["cube_corner.vtkhdf"])

    def predicted(self, *words):
        text = self.done("check", *words).stdout
        return float(re.search(r"holds (\S+) MB", text).group(1))

    @mock.patch.dict(os.environ, MALLOC_PERTURB_="0")  # Meson's value makes unused memory resident
    def test_prediction(self):
        """Peak memory within a factor of 1.5 of what check says."""
        factor = 1.5
        decks = (("method.elements=1",),
                 ("method.elements=4", "method.solver=lu"),
                 ("method.elements=4", "method.matrix=hierarchical"),
                 ("method.elements=8", "method.solver=gmres"),
                 ("method.elements=8", "method.matrix=hierarchical",
                  "method.quadrature_tolerance=5e-5"),
                 ("method.mesh=graded", "method.elements=1", "method.degree=7"),
                 ("method.mesh=uniform", "method.elements=12", "method.degree=0"))
        for sets in decks:
            words = [CORNER] + [w for one in sets for w in ("--set", one)]
            predicted = self.predicted(*words)
            self.done("run", *words, "-o", "m.h5", "--set", "method.solver_tolerance=1e-9")
            p = subprocess.run(["h5dump", "-a", "/polyrad/diagnostics/peak_memory_bytes",
                                self.path("m.h5")], stdout=subprocess.PIPE, text=True)
            took = float(re.search(r"\(0\): (\S+)", p.stdout).group(1)) / 1e6
            self.assertTrue(took / factor < predicted < took * factor,
                            "%s: predicted %g MB, took %g MB" % (sets, predicted, took))


class Repeat(Case):
    """Equal runs give bitwise equal files, apart from times."""

    def dump(self, name, path, *options):
        p = subprocess.run(["h5dump", *options, path, self.path(name)], text=True,
                           stdout=subprocess.PIPE, stderr=subprocess.PIPE)
        self.assertEqual(p.returncode, 0, p.stderr)
        return p.stdout.split("\n", 1)[1]  # the first line names the file

    def look(self, *more):
        if not shutil.which("h5diff") or not shutil.which("h5dump"):
            self.skipTest("h5diff and h5dump are not installed")
        for name in ("a.h5", "b.h5"):
            os.makedirs(self.path(name[0]))
            # the same command line, in two folders
            env = dict(os.environ, OMP_NUM_THREADS="2")
            p = subprocess.run([PROGRAM, "run", CORNER, "-o", "out.h5", "--quiet", *more], env=env,
                               cwd=self.path(name[0]), timeout=HANG)
            self.assertEqual(p.returncode, 0)
            second = int(time.time())
            while int(time.time()) == second:  # the time of start differs, which is told in seconds
                time.sleep(0.01)
        pair = [self.path("a/out.h5"), self.path("b/out.h5")]
        p = subprocess.run(["h5diff", "-v", *pair], text=True, stdout=subprocess.PIPE)
        differ, same = [], 0
        for name, n in re.findall(r"^(?:attribute|dataset|group +): +?<([^>]*>?)> and .*?"
                                  r"^(\d+) differences found", p.stdout, re.M | re.S):
            same += n == "0"
            if n != "0":
                differ.append(name)
        self.assertGreater(same, 60, p.stdout)
        self.assertIn("started of </polyrad>", differ)  # h5diff does see differences
        times = r"(seconds_\w+|started|checksum|peak_memory_bytes) of <.*|/polyrad/checksums"
        self.assertEqual([name for name in differ if not re.fullmatch(times, name)], [])
        for group in ("/VTKHDF", "/polyrad/solution", "/polyrad/probes", "/polyrad/triangles"):
            first = self.dump("a/out.h5", group, "-m", "%.17g", "-g")
            self.assertEqual(first, self.dump("b/out.h5", group, "-m", "%.17g", "-g"))
            self.assertGreater(len(first), 1000)
        self.assertEqual(os.path.getsize(pair[0]), os.path.getsize(pair[1]))

    def test_lu(self):
        self.look("--set", "method.elements=2")

    def test_gmres(self):
        self.look("--set", "method.elements=3", "--set", "method.solver=gmres")

    def test_a_change_is_seen(self):
        """The comparison above can fail."""
        if not shutil.which("h5dump"):
            self.skipTest("h5dump is not installed")
        for name, rho in (("a.h5", "0.5"), ("b.h5", "0.5000000000001")):
            self.done("run", CORNER, "-o", name, "--quiet", "--set", "method.elements=1", "--set",
                      "scene.triangles.0.rho=" + rho)
        dumps = [self.dump(name, "/polyrad/solution", "-m", "%.17g", "-g")
                 for name in ("a.h5", "b.h5")]
        self.assertNotEqual(*dumps)


class Solvers(Case):
    def test_gmres_that_does_not_converge(self):
        """Exit 1, and the file is written all the same, marked as not converged."""
        text = self.refused(1, "run", CORNER, "-o", "out.h5", "--set", "method.elements=3", "--set",
                            "method.solver=gmres", "--set", "method.solver_tolerance=1e-18",
                            quiet=False)
        self.assertIn("GMRES did not converge", text)
        self.assertIn("asked for 1.00e-18", text)
        self.assertEqual(self.files(), ["out.h5"])
        self.assertRegex(self.done("info", "out.h5").stdout, r"converged +NO\n")

    def test_not_converged_is_told_in_the_summary(self):
        p = self.call("run", CORNER, "--set", "method.elements=3", "--set", "method.solver=gmres",
                      "--set", "method.solver_tolerance=1e-18")
        self.assertEqual(p.returncode, 1)
        self.assertIn("NOT CONVERGED", p.stdout)

    def test_gmres_that_converges(self):
        self.done("run", CORNER, "-o", "out.h5", "--set", "method.elements=1", "--set",
                  "method.solver=gmres")
        self.assertRegex(self.done("info", "out.h5").stdout, r"converged +yes\n")

    def test_neumann_prints_the_bound_of_the_rest(self):
        """kappa^(b+1) / (1 - kappa) max E, E = 1; and it is a bound."""
        words = ("--set", "method.elements=1", "--set", "method.quadrature_tolerance=1e-12")
        full = self.done("run", CORNER, "--set", "method.solver=lu", *words).stdout
        exact = float(re.search(r"wall_x0 +\S+ +(\S+)", full).group(1))
        for bounces in (0, 3, 8):
            text = self.done("run", CORNER, *words, "--set", "method.solver=neumann", "--set",
                             "method.bounces=%d" % bounces).stdout
            found = re.search(r"neumann, (\d+) bounces, the rest is below (\S+) W/m2; kappa (\S+),",
                              text)
            self.assertTrue(found, text)
            self.assertEqual(int(found.group(1)), bounces)
            rest, kappa = float(found.group(2)), float(found.group(3))
            self.assertAlmostEqual(rest / (kappa ** (bounces + 1) / (1 - kappa)), 1, delta=0.02)
            mean = float(re.search(r"wall_x0 +\S+ +(\S+)", text).group(1))
            self.assertTrue(0 < exact - mean <= rest, (exact, mean, rest))


class Check(Case):
    def test_prints_sizes_and_solves_nothing(self):
        text = self.done("check", CORNER, "--set", "method.elements=8").stdout
        self.assertIn("3 triangles", text)
        self.assertIn("1152 elements, 4608 unknowns", text)
        self.assertRegex(text, r"matrix +169\.9 MB")  # 8 x 4608^2 bytes
        self.assertRegex(text, r"holds \S+ MB of \S+ MB available")
        self.assertRegex(text, r"skipped +33\.3 %")  # each face sees the two others
        self.assertRegex(text, r"time +about \S+ s\n")
        self.assertNotIn("radiosity", text)
        self.assertEqual(self.files(), [])

    def test_unknowns_of_the_paper(self):
        for p, numbers in ((1, (72, 288, 1152, 4608, 18432)), (2, (72, 576, 3168, 16272))):
            for k, number in enumerate(numbers):
                text = self.done("check", CORNER, "--set", "method.elements=%d" % 2 ** k, "--set",
                                 "method.grading=%d" % p).stdout
                self.assertIn(" %d unknowns" % number, text)

    def test_is_quick(self):
        """Killed by a limit of half the processor time of the run that it predicts (18432 unknowns); it needs
        a thirtieth of the limit."""
        self.done("check", CORNER, "--set", "method.elements=16", "--set",
                  "method.quadrature_tolerance=1e-12", preexec_fn=limit_processor(6))


class Accuracy(Case):
    """A deck that only asks for an accuracy."""

    def test_tolerance_is_met(self):
        for tolerance in ("1e-2", "1e-4"):
            text = self.done("run", CORNER, "--set", "accuracy.tolerance=" + tolerance).stdout
            bound = float(re.search(r"error +of the radiosity at any point at most \S+ W/m2: (\S+) of", text).group(1))
            self.assertTrue(0 < bound <= float(tolerance), text)
            self.assertRegex(self.done("info", "cube_corner.vtkhdf").stdout, r"error bound +\d")

    def test_method_keys_are_obeyed(self):
        text = self.done("run", CORNER, "--set", "method.elements=1").stdout
        self.assertIn("paper, N = 1", text)
        self.assertNotIn("adaptive", text)

    def test_check_shows_exponents(self):
        text = self.done("check", CORNER).stdout
        self.assertIn("adaptive", text)
        self.assertIn("0.763362", text)  # the edges of the paper's S1
        self.assertIn("0.744986", text)  # its corner
        self.assertEqual(self.files(), [])

    def test_left_out_is_told(self):
        text = self.done("run", CORNER, "--set", "scene.triangles.0.rho=0").stdout
        self.assertRegex(text, r"left out +unknowns on 1 triangle: black")

    def test_tolerance_out_of_reach(self):
        """Exit 1, the reason, and the best result all the same."""
        text = self.refused(1, "run", CORNER, "-o", "best.h5", "--set", "accuracy.tolerance=1e-10",
                            quiet=False, preexec_fn=limit_memory(800 * 1000 * 1000))
        self.assertRegex(text, r"tolerance 1e-10 was not reached.*memory")
        self.assertEqual(self.files(), ["best.h5"])
        self.assertRegex(self.done("info", "best.h5").stdout, r"converged +NO\n")


class Study(Case):
    def table(self, text):
        return [line.split() for line in text.splitlines() if re.match(r" +\d", line)]

    def setUp(self):
        super().setUp()
        with open(CORNER) as f:
            self.write("deck.yml", f.read() + "study: {vary: {method.elements: [1, 2, 4]}}\n")

    def test_table_and_file(self):
        text = self.done("study", "deck.yml", "-o", "table.h5").stdout
        rows = self.table(text)
        self.assertEqual([(r[0], r[1]) for r in rows], [("1", "72"), ("2", "288"), ("4", "1152")])
        errors = [float(r[2]) for r in rows[:2]]
        self.assertTrue(0.5 > errors[0] > 1.5 * errors[1] > 0, errors)
        self.assertEqual(rows[2][2], "-")  # the reference itself
        self.assertIn("EOC", text)
        self.assertIn("written table.h5", text)
        self.assertEqual(self.files(), ["deck.yml", "table.h5"])

    def test_two_keys(self):
        text = self.done("study", "deck.yml", "--set",
                         "study.vary={method.degree: [0, 1], method.elements: [1, 2]}").stdout
        self.assertEqual([tuple(r[:3]) for r in self.table(text)],
                         [("0", "1", "18"), ("0", "2", "72"), ("1", "1", "72"), ("1", "2", "288")])

    def test_named_reference(self):
        text = self.done("study", "deck.yml", "--set",
                         "study.reference={mesh: graded, grading: 2, degree: 4, elements: 1}").stdout
        errors = [float(r[2]) for r in self.table(text)]
        self.assertEqual(len(errors), 3)
        self.assertTrue(errors[0] > errors[1] > errors[2] > 0, errors)

    def test_runs_of_different_scenes_are_not_compared(self):
        """A varied rho makes problems of their own: each has its reference, last or named."""
        for reference in ("last", "{mesh: graded, grading: 2, degree: 3, elements: 1}"):
            study = f"study={{vary: {{method.elements: [1, 2, 3]}}, reference: {reference}}}"
            apart = [row[2:4] for rho in ("0.1", "0.7")
                     for row in self.table(self.done("study", "deck.yml", "--set", study, "--set",
                                                     f"scene.triangles.0.rho={rho}").stdout)]
            both = study.replace("vary: {", "vary: {scene.triangles.0.rho: [0.1, 0.7], ")
            text = self.done("study", "deck.yml", "--set", both).stdout
            self.assertEqual([row[3:5] for row in self.table(text)], apart)
            self.assertIn("of the same scene", text)
            other = study.replace(
                "[1, 2, 3]", "[1, 2, 3], scene.triangles.0.rho: [0.1, 0.7]")
            rows = self.table(self.done("study", "deck.yml", "--set", other).stdout)
            self.assertEqual([row[3:5] for row in rows[::2] + rows[1::2]], apart)

    def test_stability(self):
        text = self.done("study", "deck.yml", "--set",
                         "study={vary: {method.elements: [1, 2]}, stability: true}",
                         "-o", "table.h5").stdout
        self.assertIn("|inverse|", text)
        info = self.done("info", "table.h5").stdout
        for word in ("inverse_norm", "inverse_matrix", "condition", "spectral_radius"):
            self.assertIn(word, info)
        self.assertIn("'stability' cannot be 'maybe'",
                      self.refused(2, "study", "deck.yml", "--set", "study.stability=maybe"))

    def test_default_name_and_quiet(self):
        self.assertEqual(self.done("study", "deck.yml", "--quiet").stdout, "")
        self.assertEqual(self.files(), ["cube_corner_study.h5", "deck.yml"])

    def test_info(self):
        self.done("study", "deck.yml", "-o", "table.h5", "--quiet")
        text = self.done("info", "table.h5").stdout
        self.assertTrue(text.startswith("table.h5: polyrad study\n"), text)
        self.assertIn("study (3 runs)", text)
        for word in ("method.elements", "unknowns", "error", "eoc", "seconds_total", "1152"):
            self.assertIn(word, text)


class Info(Case):
    def test_result(self):
        self.done("run", CORNER, "-o", "out.h5", "--quiet", "--set", "method.elements=1")
        text = self.done("info", "out.h5").stdout
        self.assertTrue(text.startswith("out.h5: polyrad result\n"), text)
        for pattern in (r"title +Cube corner", r"unknowns +72\n", r"converged +yes\n", r"threads +\d",
                        r"command +\S*polyrad run ", r"surfaces \(3\)", r"wall_y0 +0\.5 ",
                        r"probes \(2\)", r"/polyrad/solution/value +\[72, 1\] W/m2", r"total +\S+ s"):
            self.assertRegex(text, pattern)

    def test_garbage(self):
        self.write("garbage.h5", os.urandom(5000))
        self.assertIn("not HDF5", self.refused(3, "info", "garbage.h5"))

    def test_empty_file(self):
        self.write("empty.h5", b"")
        self.assertIn("not HDF5", self.refused(3, "info", "empty.h5"))

    def test_truncated_result(self):
        self.done("run", CORNER, "-o", "out.h5", "--quiet", "--set", "method.elements=1")
        whole = self.read("out.h5")
        for size in (8, 100, 5000, len(whole) // 2, len(whole) - 1):
            self.write("cut.h5", whole[:size])
            self.assertIn("cut.h5", self.refused(3, "info", "cut.h5"))

    def test_folder(self):
        self.assertIn("Is a directory", self.refused(3, "info", "."))

    def test_missing_file(self):
        self.assertIn("No such file", self.refused(3, "info", "nothing.h5"))

    def test_deck(self):
        self.assertIn("not a polyrad result", self.refused(3, "info", CORNER))


if __name__ == "__main__":
    unittest.main()
