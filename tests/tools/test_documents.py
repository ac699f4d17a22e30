"""Everything that README.md and docs/*.md show is run, in a folder of its own for each document.

    ```sh                  commands, in turn; a failing one fails the test
    ```yaml                a deck: polyrad run; a part of one is put into a small deck: polyrad check
    ```LANGUAGE NAME       is written to the file NAME first
    ```python              is run, with the project's Python module
    ```c                   is in examples/, as it stands
    ```text, or none       what is not to be run: formulas, output

A comment `<!-- not run: reason -->` on the line before a block leaves it out. `build/release/polyrad`, `polyrad` and
`tools/NAME` are those of this build; unless POLYRAD_TEST_FULL=1, runs have a tolerance of 0.3 and coarse pictures.
"""

import os
import re
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

from project import ROOT

PROGRAM = Path(os.environ.get("POLYRAD", ROOT / "build/release/polyrad")).absolute()
DOCUMENTS = [ROOT / "README.md", *sorted(ROOT.glob("docs/*.md"))]
BLOCK = re.compile(r"^(?:<!-- (?P<comment>.*?) -->\n)?```(?P<info>.*)\n(?P<text>(?:.*\n)*?)```$", re.MULTILINE)
KNOWN = {"sh", "yaml", "python", "c", "obj", "text", ""}
QUICK = "" if os.environ.get("POLYRAD_TEST_FULL") else "--set accuracy.tolerance=0.3 --set output.sampling=1"
SCENE = "scene: {triangles: [{vertices: [[0,0,0],[1,0,0],[0,1,0]], rho: 0.5, emission: 1}]}\n"
SHIM = """#!/bin/sh
verb=$1
[ "$verb" = run ] || exec {program} "$@"
exec {program} "$@" {quick}
"""


def blocks(document):
    for found in BLOCK.finditer(document.read_text(encoding="utf-8")):
        line = document.read_text(encoding="utf-8")[: found.start()].count("\n") + 1
        language, _, name = found["info"].partition(" ")
        yield line, found["comment"] or "", language, name, found["text"]


def whole_deck(part: str) -> str:
    """A part of a deck as one that can be checked: with a scene, with triangles for its surfaces."""
    if not part.lstrip().startswith("surfaces"):
        return SCENE + part
    triangles = (
        f"    - {{name: {n}, vertices: [[0,0,{z}],[1,0,{z}],[0,1,{z}]]}}\n"
        for z, n in enumerate(surface_names(part))
    )
    return "scene:\n  triangles:\n" + "".join(triangles) + part


def surface_names(part: str) -> list[str]:
    return re.findall(r"(\w+): \{(?:rho|emissivity)", part)


def mesh_of(part: str) -> str:
    """An OBJ file with a face for each surface that a deck names."""
    made = ""
    for z, name in enumerate(surface_names(part)):
        made += f"v 0 0 {z}\nv 1 0 {z}\nv 0 1 {z}\nusemtl {name}\nf -3 -2 -1\n"
    return made


class Documents(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        if not PROGRAM.exists():
            raise unittest.SkipTest(f"no program {PROGRAM}")

    def folder(self) -> Path:
        """Like the project's folder, but for what is written there."""
        holder = tempfile.TemporaryDirectory()
        self.addCleanup(holder.cleanup)
        made = Path(holder.name)
        for name in ("inputs", "tools", "examples", "docs"):
            (made / name).symlink_to(ROOT / name)
        shim = made / "build/release/polyrad"
        shim.parent.mkdir(parents=True)
        shim.write_text(SHIM.format(program=PROGRAM, quick=QUICK))
        shim.chmod(0o755)
        return made

    def run_in(self, folder: Path, command: list, text: str) -> None:
        env = dict(
            os.environ,
            PATH=os.pathsep.join([str(folder / "build/release"), os.environ["PATH"]]),
            PYTHONPATH=str(ROOT / "python"),
            POLYRAD_LIBRARY=str(PROGRAM.parent / "libpolyrad.so"),
        )
        done = subprocess.run(command, cwd=folder, env=env, capture_output=True, text=True, timeout=900)
        if done.returncode == 3 and "render" in text and "PyPI" in done.stderr + done.stdout:
            self.skipTest(done.stderr.strip())
        self.assertEqual(done.returncode, 0, f"{text}\n{done.stdout}\n{done.stderr}")

    def run_block(self, folder: Path, document: Path, line: int, language: str, name: str, text: str) -> None:
        self.assertIn(language, KNOWN, f"{document.name}:{line}")
        if name:
            (folder / name).write_text(text)
        if language == "sh":
            # tools are called by their real path: what they need is found from there
            script = re.sub(r"(?m)(^|\s)tools/", rf"\1{ROOT}/tools/", text)
            self.run_in(folder, ["bash", "-e", "-c", script], script)
        elif language == "yaml":
            whole = re.search(r"(?m)^scene:", text) is not None
            deck = folder / (name or f"deck_{line}.yml")
            deck.write_text(text if whole else whole_deck(text))
            mesh = re.search(r"mesh: \{file: ([\w.]+)", text)
            if mesh and not (folder / mesh[1]).exists():
                (folder / mesh[1]).write_text(mesh_of(text))
            verb = "run" if whole and not name else "check"  # by name: commands follow
            self.run_in(folder, ["build/release/polyrad", verb, deck], text)
        elif language == "python":
            self.run_in(folder, [sys.executable, "-c", text], text)
        elif language == "c":
            examples = [path.read_text() for path in ROOT.glob("examples/*.c")]
            self.assertIn(text, examples, f"{document.name}:{line} is not in examples/")

    def test_marks_have_reasons(self):
        for document in DOCUMENTS:
            for line, comment, language, _, _ in blocks(document):
                if comment:
                    self.assertRegex(comment, r"^not run.*: .{15,}", f"{document.name}:{line}")

    def test_no_commands_hide_in_indented_blocks(self):
        for document in DOCUMENTS:
            plain = BLOCK.sub("", document.read_text(encoding="utf-8"))
            hidden = re.findall(r"(?m)^    (?:tools/|build/|polyrad |meson |cc |pip |ninja ).*", plain)
            self.assertEqual(hidden, [], document.name)

    def test_links_lead_somewhere(self):
        for document in DOCUMENTS:
            for target in re.findall(r"\]\(([^)#:]+)(?:#[^)]*)?\)", document.read_text(encoding="utf-8")):
                self.assertTrue((document.parent / target).exists(), f"{document.name}: {target}")


def add_test(document: Path) -> None:
    def test(self):
        folder = self.folder()
        for line, comment, language, name, text in blocks(document):
            if not comment.startswith("not run"):
                with self.subTest(block=f"{document.name}:{line}"):
                    self.run_block(folder, document, line, language, name, text)

    setattr(Documents, "test_" + document.stem.lower(), test)


for document in DOCUMENTS:
    add_test(document)

if __name__ == "__main__":
    unittest.main()
