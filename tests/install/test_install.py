"""The installed tree as users meet it: program, header, libraries, pkg-config file, example, Python module.

POLYRAD_BUILD and POLYRAD_SOURCE name the build and source folders; POLYRAD_MESON is the program meson.
"""

import os
import pathlib
import re
import shlex
import shutil
import subprocess
import sys
import tempfile
import unittest

BUILD, SOURCE = (pathlib.Path(os.environ[k]) for k in ("POLYRAD_BUILD", "POLYRAD_SOURCE"))
CC = shlex.split(os.environ.get("CC") or "cc")
CALLS = {"create", "solve", "get_summary", "evaluate", "evaluate_at", "surface_means", "surface_errors", "surface_heat",
         "view_factors", "error_text", "warning", "free", "version"}


def run(*command, **more):
    p = subprocess.run([str(c) for c in command], text=True, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                       timeout=900, **more)
    if p.returncode:
        raise AssertionError(f"{command}: {p.returncode}\n{p.stdout}")
    return p.stdout


class Install(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory(prefix="polyrad_install_")
        cls.addClassCleanup(cls.folder.cleanup)
        cls.root = pathlib.Path(cls.folder.name)
        run(*shlex.split(os.environ.get("POLYRAD_MESON", "meson")), "install", "-C", BUILD, "--no-rebuild",
            "--destdir", cls.root / "dest")
        header = next(cls.root.rglob("polyrad.h"))
        cls.prefix, cls.pc = header.parent.parent, next(cls.root.rglob("polyrad.pc"))
        cls.shared, cls.static = next(cls.root.rglob("libpolyrad.so")), next(cls.root.rglob("libpolyrad.a"))
        cls.environment = dict(os.environ, LD_LIBRARY_PATH=str(cls.shared.parent), OMP_NUM_THREADS="1")

    def pkg_config(self, *options):
        if not shutil.which("pkg-config"):
            self.skipTest("pkg-config is not installed")
        path = os.pathsep.join(filter(None, [str(self.pc.parent), os.environ.get("PKG_CONFIG_PATH")]))
        return shlex.split(run("pkg-config", *options, "polyrad", env=dict(os.environ, PKG_CONFIG_PATH=path)))

    def check_example(self, program):
        out = run(program, env=self.environment)
        self.assertRegex(out, r"^\d+ unknowns, error at most \d\.\de-0\d W/m2\n")
        # the floor has rho 0.5 and no E: u = h / 2; means of both are below the lamp's
        for u, h in re.findall(r"radiosity ([\d.]+), irradiance ([\d.]+) W", out):
            self.assertAlmostEqual(float(u), float(h) / 2, delta=0.011)
        mean = dict(re.findall(r"mean radiosity of (\w+): ([\d.]+)", out))
        self.assertEqual(set(mean), {"floor", "lamp", "wall"})
        # 1 - y^2 over the triangle (0,0) (1,0) (0,1): mean 5/6
        self.assertGreater(float(mean["lamp"]), 100 * 5 / 6)
        self.assertLess(float(mean["lamp"]), 100 * 5 / 6 + 0.1 * float(mean["wall"]) + 5)
        return out

    def test_example_shared_and_static(self):
        source, program = SOURCE / "examples/cube_corner.c", self.root / "cube_corner"
        here = "--define-variable=prefix=" + str(self.prefix)
        flags = self.pkg_config(here, "--cflags", "--libs")
        strict = ["-std=c99", "-Wall", "-Wextra", "-Wpedantic", "-Werror"]
        run(*CC, *strict, source, *flags, "-o", program)
        shared = self.check_example(program)
        # OpenBLAS lists libgfortran, for its static library alone; it is there only with a Fortran compiler
        parts = [f for f in self.pkg_config("--static", "--libs") if f not in ("-lpolyrad", "-lgfortran")]
        run(*CC, *strict, source, *self.pkg_config(here, "--cflags"), self.static, *parts, "-o", program)
        self.assertNotIn("libpolyrad", run("ldd", program))
        self.assertEqual(self.check_example(program), shared)

    def test_header_alone(self):
        text = '#include "polyrad.h"\n#include "polyrad.h"\nint use(polyrad *p);\n' \
               'int use(polyrad *p) { return polyrad_solve(p, 0) == POLYRAD_OK; }\n'
        for compiler, standard in ((CC, "c99"), (CC, "c17"), (["c++"], "c++11"), (["c++"], "c++17")):
            with self.subTest(compiler=compiler, standard=standard):
                if not shutil.which(compiler[0]):
                    self.skipTest(compiler[0] + " is not installed")
                run(*compiler, "-x", "c++" if "++" in standard else "c", "-std=" + standard, "-Wall", "-Wextra",
                    "-Wpedantic", "-Werror", "-fsyntax-only", "-I", self.prefix / "include", "-", input=text)

    def test_only_the_api_is_exported(self):
        names = {line.split()[-1] for line in run("nm", "-D", "--defined-only", self.shared).splitlines()}
        self.assertEqual(names, {"polyrad_" + c for c in CALLS})

    def help(self):
        return run(self.prefix / "bin/polyrad", "--help", env=self.environment)

    def page(self, name):
        return next(self.root.rglob(name)).read_text().replace("\\-", "-")

    def test_man_pages_say_what_help_says(self):
        text = self.help()
        commands = re.findall(r"^([a-z]+) {2,}\S", text, re.MULTILINE)
        options = re.findall(r"^  (-[-a-z]+)", text, re.MULTILINE)
        self.assertTrue({"run", "check", "study", "info"} <= set(commands) and "--threads" in options)
        whole = self.page("polyrad.1")
        for word in commands + options:
            self.assertIn("\\fB" + word + "\\fR", whole)
        for command in commands:
            page = self.page(f"polyrad-{command}.1")
            self.assertIn(f"polyrad {command} ", page)
            synopsis = "".join(re.findall(rf"^  polyrad {command} .*(?:\n {{8}}.*)*", text, re.MULTILINE))
            for option in options:  # those of its synopsis, and no others
                self.assertEqual(f"\\fB{option}\\fR" in page,
                                 bool(re.search(rf"(?<![\w-]){option}(?![\w-])", synopsis)), (command, option))

    def test_man_page_of_the_deck_has_every_key(self):
        page, text = self.page("polyrad.5"), (SOURCE / "docs/format.md").read_text()
        keys = re.findall(r"^\| `([a-z_.]+)` \|", text.split("## 4.")[0].split("## 3.")[1], re.MULTILINE)
        self.assertGreater(len(keys), 30)
        for key in keys:
            self.assertIn(f"\\fB{key}\\fR", page)

    def test_man_pages_are_well_formed(self):
        if not shutil.which("groff"):
            self.skipTest("groff is not installed")
        for path in self.root.rglob("man?/polyrad*"):
            self.assertEqual(run("groff", "-man", "-Kutf8", "-Tutf8", "-ww", "-z", path), "", path)

    def complete(self, *words, folder=None):
        script = next(self.root.rglob("completions/polyrad"))
        code = f'source {script}; COMP_WORDS=("$@"); COMP_CWORD=$(($# - 1)); _polyrad; printf "%s\\n" "${{COMPREPLY[@]}}"'
        return run("bash", "-c", code, "bash", self.prefix / "bin/polyrad", *words, cwd=folder or self.root,
                   env=self.environment).split()

    def test_completion(self):
        commands = re.findall(r"^([a-z]+) {2,}\S", self.help(), re.MULTILINE)
        self.assertEqual(set(self.complete("")), {*commands, "--help", "--version"})
        self.assertEqual(self.complete("st"), ["study"])
        self.assertTrue({"-o", "--set", "--threads", "--quiet", "--help"} <= set(self.complete("run", "-")))
        self.assertEqual(set(self.complete("info", "-")), {"--help"})
        self.assertEqual(self.complete("check", "--qu"), [])
        self.assertEqual(self.complete("run", "--threads", ""), ["1"])  # nproc heeds OMP_NUM_THREADS
        files = self.root / "files"
        files.mkdir(exist_ok=True)
        for name in ("a.yml", "b.vtkhdf", "c.txt"):
            (files / name).touch()
        self.assertEqual(self.complete("run", "", folder=files), ["a.yml"])
        self.assertEqual(self.complete("info", "", folder=files), ["b.vtkhdf"])
        self.assertEqual(sorted(self.complete("run", "-o", "", folder=files)), ["a.yml", "b.vtkhdf", "c.txt"])

    def test_program(self):
        out = run(self.prefix / "bin/polyrad", "--version")
        self.assertIn("polyrad", out)

    def test_document_shows_the_example(self):
        code = re.search(r"```c\n(.*?)```", (SOURCE / "docs/library.md").read_text(), re.DOTALL).group(1)
        self.assertEqual(code, (SOURCE / "examples/cube_corner.c").read_text())

    def test_python(self):
        venv = SOURCE / ".venv/bin/python"  # that of tools/venv, which has numpy
        python = os.environ.get("POLYRAD_PYTHON") or (venv if venv.exists() else sys.executable)
        if subprocess.run([python, "-c", "import numpy"], stderr=subprocess.DEVNULL).returncode:
            self.skipTest(f"numpy is not installed for {python}")
        environment = dict(self.environment, POLYRAD_LIBRARY=str(self.shared), PYTHONPATH=str(SOURCE / "python"),
                           PYTHONDONTWRITEBYTECODE="1")
        run(python, pathlib.Path(__file__).with_name("python_module.py"), env=environment)


if __name__ == "__main__":
    unittest.main()
