"""Files of a command: nothing given is written over, places are tried before work, every write is checked.

The seed of random choices is printed; POLYRAD_TEST_SEED sets it.
"""

import itertools
import os
import random
import re
import shutil
import subprocess
import sys
import time
import unittest
import zlib

from test_cli import Case, PROGRAM, SCENE

SEED = int(os.environ.get("POLYRAD_TEST_SEED", time.time_ns() % 10**6))

MESH = "g floor\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"
DECK = """scene:
  mesh: {file: m.obj}
  triangles:
    - {name: wall, vertices: [[0,0,0],[0,1,0],[0,0,1]], rho: 0.5, emission: 1}
  surfaces: {floor: {rho: 0.5, emission: 0}}
method: {mesh: uniform, elements: %s, degree: 0}
output: {file: out.h5}
study: {vary: {scene.mesh.file: [m.obj, n.obj]}}
"""
TOO_LARGE = 4096  # elements of a run that would take hours, or is refused for its size
SOON = 20         # [s] of processor time: what is refused before work takes none of it


def spellings(rng):
    """Functions that make another name of a file in the test's folder, and what they are."""
    def up(case, name):
        return "../" + os.path.basename(case.folder) + "/" + name

    def symbolic(case, name):
        os.symlink(rng.choice((name, case.path(name))), case.path("link"))
        return "link"

    def chain(case, name):
        os.symlink(name, case.path("first"))
        os.symlink("./first", case.path("second"))
        return "second"

    def folder(case, name):
        os.symlink(".", case.path("here"))
        return "here/" + name

    def hard(case, name):
        os.link(case.path(name), case.path("hard"))
        return "hard"

    return {"same": lambda case, name: name, "dot": lambda case, name: "./" + name,
            "slashes": lambda case, name: ".///" + name, "up": up, "absolute": lambda case, name: case.path(name),
            "around": lambda case, name: case.path("sub/../" + name), "symbolic": symbolic, "chain": chain,
            "folder": folder, "hard": hard}


LINKS = ("link", "first", "second", "here", "hard")


class Files(Case):
    def setUp(self):
        super().setUp()
        os.mkdir(self.path("sub"))
        self.write("m.obj", MESH)
        self.write("n.obj", MESH)
        self.write("deck.yml", DECK % 1)
        self.write("large.yml", DECK % TOO_LARGE)

    def limited(self, *words):
        """A call with little processor time: one that begins to work is killed."""
        def limit():
            import resource
            resource.setrlimit(resource.RLIMIT_CPU, (SOON, SOON))
        return self.call(*words, preexec_fn=limit)

    def contents(self):
        return {name: self.read(name) for name in self.files()
                if name not in LINKS and os.path.isfile(self.path(name))}


class NothingIsOverwritten(Files):
    def commands(self):
        """name: command without outputs, the files it is given, and options that name an output."""
        for part in (1, 2):
            self.done("assemble", "deck.yml", "--part", "%d/2" % part, "-o", "part%d.h5" % part, "--quiet")
        for task in (1, 2):
            self.done("study", "deck.yml", "--task", "%d/2" % task, "-o", "task%d.h5" % task, "--quiet")
        scene = ["deck.yml", "m.obj", "n.obj"]
        both = ("-o", "--checkpoint")
        return {
            "run": (["run", "deck.yml"], scene, both),
            "run_override": (["run", "deck.yml", "--set", "scene.mesh.file=n.obj"], scene, both),
            "solve": (["solve", "deck.yml", "--parts", "part1.h5", "part2.h5"], scene + ["part1.h5", "part2.h5"], both),
            "study": (["study", "deck.yml"], scene, ("-o",)),
            "task": (["study", "deck.yml", "--task", "1/2"], scene, both),
            "collect": (["study", "--collect", "task1.h5", "task2.h5"], ["task1.h5", "task2.h5"], ("-o",)),
            "assemble": (["assemble", "deck.yml", "--part", "1/2"], scene, ("-o",)),
        }

    def look(self, words, option, given, spelling, before):
        name = spelling(self, given)
        p = self.call(*words, option, name)
        for link in LINKS:
            if os.path.lexists(self.path(link)):
                os.unlink(self.path(link))
        self.assertEqual(p.returncode, 2, p.stdout + p.stderr)
        self.assertRegex(p.stderr, r"\Aerror: the \w+ \([^\n]*\) would overwrite the [^\n]*; give another file by "
                         + option + r"\n\Z")
        self.assertEqual(p.stdout, "")
        self.assertIn(given, p.stderr)
        self.assertEqual(self.contents(), before)

    def test_every_verb_input_and_spelling(self):
        print("seed %d" % SEED, file=sys.__stderr__)
        commands, before = self.commands(), self.contents()
        names = spellings(random.Random(SEED))
        n = 0
        for verb, (words, inputs, options) in commands.items():
            for given, option, spelling in itertools.product(inputs, options, names):
                with self.subTest(verb=verb, given=given, option=option, spelling=spelling):
                    self.look(words, option, given, names[spelling], before)
                    n += 1
        self.assertGreater(n, 250)

    def test_deck_of_another_folder(self):
        """The mesh is beside the deck, the output where one works."""
        before = self.contents()
        p = subprocess.run([PROGRAM, "run", "../deck.yml", "-o", "../m.obj"], cwd=self.path("sub"), text=True,
                           stdout=subprocess.PIPE, stderr=subprocess.PIPE)
        self.assertEqual(p.returncode, 2, p.stderr)
        self.assertEqual(self.contents(), before)
        p = subprocess.run([PROGRAM, "run", "../deck.yml", "-o", "m.obj", "--quiet"], cwd=self.path("sub"), text=True,
                           stdout=subprocess.PIPE, stderr=subprocess.PIPE)
        self.assertEqual((p.returncode, p.stderr), (0, ""))  # another file of this name

    def test_output_of_the_deck(self):
        for name in ("deck.yml", "./m.obj", "n.obj"):
            for verb in (["run", "deck.yml"], ["study", "deck.yml", "--task", "1/2", "-o", name]):
                text = self.refused(2, *verb, "--set", "output.file=" + name)
                self.assertIn("would overwrite", text)

    def test_default_names(self):
        """Names that the program chooses: NAME.vtkhdf, NAME_study.h5, NAME_part_1_of_2.h5."""
        deck = (DECK % 1).replace("output: {file: out.h5}\n", "")
        for name, words in (("a.vtkhdf", ["run", "a.vtkhdf"]), ("a_study.h5", ["study", "a_study.h5"]),
                            ("a_part_1_of_2.h5", ["assemble", "a_part_1_of_2.h5", "--part", "1/2"])):
            self.write(name, deck)
            more = [] if name == "a.vtkhdf" else ["--set", "output.file=a.h5"]
            self.assertIn("would overwrite the deck", self.refused(2, *words, *more))
            self.assertEqual(self.read(name).decode(), deck)
        for task in (1, 2):
            self.done("study", "deck.yml", "--task", "%d/2" % task, "-o", "task%d.h5" % task, "--quiet")
        os.rename(self.path("task1.h5"), self.path("out_study.h5"))
        before = self.contents()
        self.assertIn("the table (out_study.h5) would overwrite the file of a task",
                      self.refused(2, "study", "--collect", "out_study.h5", "task2.h5"))
        self.assertEqual(self.contents(), before)

    def test_outputs_of_one_command(self):
        """Result and checkpoint, of which neither is there yet, or both are."""
        for there in (False, True):
            if there:
                self.write("x.h5", "precious")
            before = self.contents()
            for name in ("x.h5", "./x.h5", "sub/../x.h5", self.path("x.h5"), ".//x.h5"):
                text = self.refused(2, "run", "deck.yml", "-o", "x.h5", "--checkpoint", name)
                self.assertIn("the checkpoint (%s) would overwrite the result (x.h5)" % name, text)
            self.assertEqual(self.contents(), before)

    def test_restart_is_only_for_the_checkpoint(self):
        """--checkpoint X --restart X is how runs go on; -o X --restart X would lose the work."""
        self.write("c.ck", "precious")
        for name in ("c.ck", "./c.ck", self.path("c.ck")):
            text = self.refused(2, "run", "deck.yml", "-o", name, "--restart", "c.ck")
            self.assertIn("would overwrite the checkpoint of --restart (c.ck)", text)
            text = self.refused(3, "run", "deck.yml", "--checkpoint", name, "--restart", "c.ck")
            self.assertIn("c.ck is not a polyrad checkpoint", text)
        self.assertEqual(self.read("c.ck"), b"precious")
        os.remove(self.path("c.ck"))
        p = self.call("run", "deck.yml", "--quiet", "--checkpoint", "./c.ck", "--restart", "c.ck")
        self.assertEqual((p.returncode, p.stderr), (0, "c.ck does not exist yet: the run starts from the beginning\n"))

    def test_temporary_name(self):
        """FILE.PID.tmp, which is made anew, may be the name of a deck."""
        script = 'cp deck.yml out.h5.$$.tmp && exec "$0" run out.h5.$$.tmp -o out.h5'
        p = subprocess.run(["sh", "-c", script, PROGRAM], cwd=self.folder, text=True, stdout=subprocess.PIPE,
                           stderr=subprocess.PIPE)
        self.assertEqual(p.returncode, 2, p.stderr)
        self.assertIn("would overwrite the deck", p.stderr)
        self.assertEqual([self.read(name) for name in self.files() if name.endswith(".tmp")], [self.read("deck.yml")])

    def test_links_of_the_system(self):
        """/dev/stdout leads to a file here; the link itself must stay."""
        before = os.readlink("/dev/stdout")
        with open(self.path("through.h5"), "wb") as f:
            p = subprocess.run([PROGRAM, "run", "deck.yml", "-o", "/dev/stdout", "--quiet"], cwd=self.folder, stdout=f,
                               stderr=subprocess.PIPE)
        self.assertEqual((p.returncode, p.stderr), (0, b""))
        self.assertEqual(os.readlink("/dev/stdout"), before)
        self.assertIn("polyrad result", self.done("info", "through.h5").stdout)


class PlacesAreTried(Files):
    def verbs(self):
        # all but collect would take hours
        yield ["run", "large.yml"], ("-o", "--checkpoint")
        yield ["study", "large.yml"], ("-o",)
        yield ["study", "large.yml", "--task", "1/2"], ("-o", "--checkpoint")
        yield ["assemble", "large.yml", "--part", "1/2"], ("-o",)
        yield ["solve", "large.yml", "--parts", "a.h5", "b.h5"], ("-o", "--checkpoint")
        yield ["study", "--collect", "a.h5"], ("-o",)

    def look(self, place, why, **more):
        for words, options in self.verbs():
            for option in options:
                with self.subTest(place=place, words=words, option=option):
                    p = self.limited(*words, option, place)
                    self.assertEqual(p.returncode, 3, p.stdout + p.stderr)
                    self.assertRegex(p.stderr, r"\Acannot write [^\n]*: %s; [^\n]*\n\Z" % why)
                    self.assertEqual(p.stdout, "")

    def test_places(self):
        longest = os.pathconf(self.folder, "PC_NAME_MAX")
        before = self.contents()
        for place, why in (("no/such/x.h5", "No such file or directory"), ("deck.yml/x.h5", "Not a directory"),
                           ("sub", "Is a directory"), (".", "Is a directory"), ("a" * (longest - 3), "File name too long"),
                           ("a" * (longest + 1), "File name too long"), ("sub/" * 2000 + "x", "File name too long")):
            self.look(place, why)
        self.assertEqual(self.contents(), before)
        self.assertEqual(os.listdir(self.path("sub")), [])

    def test_pipe(self):
        """Nobody may ever read it. So a pipe is refused, by name and by the deck, but for one that is open."""
        os.mkfifo(self.path("pipe"))
        self.write("pipe.yml", DECK.replace("out.h5", "pipe") % 1)
        before = self.files()
        for words in (("run", "deck.yml", "-o", "pipe"), ("study", "deck.yml", "-o", "./pipe"), ("run", "pipe.yml"),
                      ("assemble", "deck.yml", "--part", "1/2", "-o", "pipe"),
                      ("run", "deck.yml", "--checkpoint", "pipe")):
            text = self.refused(2, *words)
            self.assertRegex(text, r"\Aerror: the (result|table|part|checkpoint) cannot be written to (\./)?pipe, which is "
                                   r"a named pipe; give a file by (-o|--checkpoint)\n\Z")
        p = subprocess.run([PROGRAM, "run", "deck.yml", "-o", "/dev/stdout", "--quiet"], cwd=self.folder,
                           stdout=subprocess.PIPE, stderr=subprocess.PIPE)
        self.assertEqual((p.returncode, p.stdout[:4]), (0, b"\x89HDF"), p.stderr)
        self.assertEqual(self.files(), before)

    def test_rights(self):
        if os.geteuid() == 0:
            self.skipTest("root may write anywhere")
        os.chmod(self.path("sub"), 0o500)
        self.write("old.h5", "precious")
        os.chmod(self.path("old.h5"), 0o400)
        for place in ("sub/x.h5", "old.h5"):
            self.look(place, "Permission denied")

    def test_folder_that_nobody_may_write_to(self):
        self.look("/proc/x.h5", "(No such file or directory|Permission denied|Read-only file system)")

    def test_longest_name(self):
        """What passes the trial can be written."""
        suffix = len(".%d.tmp" % 2**22)  # the largest number of a process
        name = "a" * (os.pathconf(self.folder, "PC_NAME_MAX") - suffix)
        self.done("run", "deck.yml", "-o", name, "--quiet")
        self.assertIn(name, self.files())

    def test_trial_leaves_nothing(self):
        """An old file and its folder are as they were when the deck is refused after the trial."""
        self.write("old.h5", "precious")
        self.write("white.yml", (DECK % 1).replace("rho: 0.5", "rho: 2"))
        before = self.contents()
        self.refused(2, "run", "white.yml", "-o", "old.h5")
        self.assertEqual(self.contents(), before)


class EveryWriteIsChecked(Files):
    def printing(self):
        """Commands that print."""
        self.done("run", "deck.yml", "-o", "r.h5", "--quiet")
        for task in (1, 2):
            self.done("study", "deck.yml", "--task", "%d/2" % task, "-o", "task%d.h5" % task, "--quiet")
        for part in (1, 2):
            self.done("assemble", "deck.yml", "--part", "%d/2" % part, "-o", "part%d.h5" % part, "--quiet")
        return (["--help"], ["-h"], ["--version"], ["run", "--help"], ["info", "r.h5"], ["info", "task1.h5"],
                ["check", "deck.yml"], ["run", "deck.yml"], ["study", "deck.yml"], ["study", "deck.yml", "--tasks"],
                ["study", "deck.yml", "--task", "1/2"], ["study", "--collect", "task1.h5", "task2.h5"],
                ["assemble", "deck.yml", "--part", "1/2"], ["solve", "deck.yml", "--parts", "part1.h5", "part2.h5"])

    def test_full_device_and_closed(self):
        if not os.path.exists("/dev/full"):
            self.skipTest("no /dev/full here")
        for words in self.printing():
            for to, why in ((">/dev/full", "No space left on device"), (">&-", "Bad file descriptor"),
                            ("</dev/null >&- <&-", "Bad file descriptor")):
                with self.subTest(words=words, to=to):
                    p = subprocess.run(["sh", "-c", '"$0" "$@" ' + to, PROGRAM, *words], cwd=self.folder, text=True,
                                       stderr=subprocess.PIPE)
                    self.assertEqual(p.returncode, 3, p.stderr)
                    self.assertRegex(p.stderr, r"\Aerror: what was printed could not be written to standard output"
                                               r"(: %s)?; [^\n]*\n\Z" % why)

    def test_quiet_needs_no_output(self):
        p = subprocess.run(["sh", "-c", '"$0" run deck.yml --quiet >&-', PROGRAM], cwd=self.folder, stderr=subprocess.PIPE)
        self.assertEqual((p.returncode, p.stderr), (0, b""))

    def test_an_error_stays_the_error(self):
        for to in (">/dev/full", ">&-"):
            p = subprocess.run(["sh", "-c", '"$0" run no.yml ' + to, PROGRAM], cwd=self.folder, text=True,
                               stderr=subprocess.PIPE)
            self.assertEqual(p.returncode, 3)
            self.assertTrue(p.stderr.startswith("no.yml: "), p.stderr)

    def test_messages_do_not_end_in_files(self):
        """With standard streams closed, files that are opened do not take their numbers."""
        self.write("warns.yml", (DECK % 1).replace("[0,0,1]]", "[0,0.5,1]]").replace("[0,1,0],", "[0,0.5,0],"))
        self.assertIn("warning", self.call("run", "warns.yml", "-o", "open.h5").stderr)
        for to in (">&- 2>&-", "2>&-", "<&- >&- 2>&-"):
            p = subprocess.run(["sh", "-c", 'exec "$0" run warns.yml -o closed.h5 ' + to, PROGRAM], cwd=self.folder,
                               stdout=subprocess.DEVNULL)
            self.assertEqual(p.returncode, 3 if to.startswith((">", "<")) else 0, to)
            self.assertIn("polyrad result", self.done("info", "closed.h5").stdout)  # checksums agree
            self.assertEqual(self.read("closed.h5")[:8], b"\x89HDF\r\n\x1a\n")


class Damaged(Files):
    """A file that lost a bit is refused, or it was a bit that holds nothing; never another number."""

    def setUp(self):
        super().setUp()
        for task in (1, 2):
            self.done("study", "deck.yml", "--task", "%d/2" % task, "-o", "task%d.h5" % task, "--quiet")
        self.done("study", "--collect", "task1.h5", "task2.h5", "-o", "table.h5", "--quiet")
        self.rng = random.Random(SEED)

    def flips(self, name, n):
        """The file with one bit changed, n times; put back at the end."""
        whole = self.read(name)
        for _ in range(n):
            at, bit = self.rng.randrange(len(whole)), self.rng.randrange(8)
            changed = bytearray(whole)
            changed[at] ^= 1 << bit
            self.write(name, bytes(changed))
            with self.subTest(seed=SEED, name=name, at=at, bit=bit):
                yield
        self.write(name, whole)

    def look(self, name, n, *words):
        told, found = self.done(*words).stdout, 0
        for _ in self.flips(name, n):
            p = self.call(*words)
            self.assertIn(p.returncode, (0, 3), p.stderr)
            if p.returncode == 0:
                self.assertEqual((p.stdout, p.stderr), (told, ""))
            else:
                self.assertRegex(p.stderr, r"\A[^\n]*%s[^\n]*\n\Z" % name)
                self.assertEqual(p.stdout, "")
                found += "damaged" in p.stderr
        self.assertGreater(found, n // 2)

    def test_info(self):
        print("seed %d" % SEED, file=sys.__stderr__)
        for name in ("task1.h5", "table.h5"):
            self.look(name, 40, "info", name)

    def test_collect(self):
        self.look("task1.h5", 40, "study", "--collect", "task1.h5", "task2.h5", "-o", "again.h5")

    def compressed(self, whole):
        """Where the last compressed block begins."""
        def is_one(at):
            try:
                return len(zlib.decompressobj().decompress(whole[at:])) > 1000
            except zlib.error:
                return False
        return max(m.start() for m in re.finditer(b"x[\x5e\x9c]", whole) if is_one(m.start()))

    def test_a_value(self):
        """The solution of a run: before, one wrong byte made it a run that has none."""
        whole = self.read("task1.h5")
        if not shutil.which("h5dump"):
            self.skipTest("h5dump is not installed")
        for dataset in ("/polyrad/task/value", "/polyrad/task/area"):
            text = subprocess.run(["h5dump", "-p", "-H", "-d", dataset, self.path("task1.h5")], text=True, check=True,
                                  stdout=subprocess.PIPE).stdout
            at = re.search(r"OFFSET (\d+)", text)
            place = int(at[1]) + 5 if at else self.compressed(whole) + 40
            changed = bytearray(whole)
            changed[place] ^= 16
            self.write("task1.h5", bytes(changed))
            for words in (["info", "task1.h5"], ["study", "--collect", "task1.h5", "task2.h5", "-o", "c.h5"]):
                text = self.refused(3, *words)
                self.assertRegex(text, r"task1.h5 is damaged: dataset /\S+ is not as it was written; make it again\n")
                self.assertNotIn("c.h5", self.files())
            self.write("task1.h5", whole)
        self.done("study", "--collect", "task1.h5", "task2.h5", "-o", "c.h5", "--quiet")

    def test_repacked(self):
        """Another layout, the same contents."""
        if not shutil.which("h5repack"):
            self.skipTest("h5repack is not installed")
        told = self.done("info", "task1.h5").stdout
        for k, options in enumerate((["-f", "NONE"], ["-L"])):
            name = "packed%d.h5" % k
            subprocess.run(["h5repack", *options, self.path("task1.h5"), self.path(name)], check=True)
            self.assertNotEqual(self.read("task1.h5"), self.read(name))
            self.assertEqual(self.done("info", name).stdout.replace(name, "task1.h5"), told)


class Numbers(Files):
    def test_shares_and_threads(self):
        shares = ("4294967297/5", "1/4294967298", "0/5", "6/5", "-1/5", "1/-5", "+1/5", " 1/5", "1 /5", "1/ 5", "1/5 ",
                  "1/5x", "1.0/5", "1e0/5", "0x1/5", "1/5/5", "1//5", "/5", "1/", "/", "5", "", "1\n/5",
                  "18446744073709551617/18446744073709551618", "1/9999999999")
        for bad in shares:
            for words in (["assemble", "deck.yml", "--part"], ["study", "deck.yml", "--task"]):
                with self.subTest(bad=bad, words=words):
                    p = self.call(*words, bad)
                    self.assertEqual((p.returncode, p.stdout), (2, ""))
                    self.assertIn("%s needs I/N, for example 2/5, got '%s'" % (words[-1], bad), p.stderr)
        for bad in ("4294967297", "4097", "0", "-1", "+1", " 1", "1 ", "1x", "1.0", "1e0", "0x1", "",
                    "18446744073709551617"):
            for words in (["run", "deck.yml"], ["check", "deck.yml"], ["study", "deck.yml"]):
                p = self.call(*words, "--threads", bad)
                self.assertEqual((p.returncode, p.stdout), (2, ""), bad)
                self.assertIn("--threads needs a whole number from 1 to 4096, got '%s'" % bad, p.stderr)
        self.assertEqual(self.files(), ["deck.yml", "large.yml", "m.obj", "n.obj", "sub"])

    def test_good_ones(self):
        self.done("assemble", "deck.yml", "--part", "2/2", "-o", "a.h5", "--threads", "1")
        self.done("assemble", "deck.yml", "--part=02/2", "-o", "b.h5", "--threads=1")


if __name__ == "__main__":
    unittest.main()
