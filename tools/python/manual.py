#!/usr/bin/env python3
"""Man pages of polyrad, from what the program and its documents say: polyrad(1), one page for each
command, and polyrad(5), the deck.

    manual.py PROGRAM FORMAT.md FOLDER     PROGRAM --help and sections 2-4 of FORMAT.md into FOLDER/man1, man5

meson install calls it, with a FOLDER relative to the prefix. Standard library only.
"""

import os
import re
import subprocess
import sys
from pathlib import Path


def roff(text: str) -> str:
    """One line or paragraph of markdown as roff: code and strong words bold, links by their text."""
    text = re.sub(r"\[([^]]*)\]\([^)]*\)", r"\1", text.replace("\\|", "|").replace("\\", "\\e"))
    text = text.replace("-", "\\-").replace("'", "\\(aq").replace("`` ", "").replace(" ``", "")
    text = re.sub(r"`([^`]*)`", r"\\fB\1\\fR", text)
    text = re.sub(r"\*\*(.+?)\*\*", r"\\fB\1\\fR", text)
    return "\\&" + text if text.startswith(".") else text


def head(name: str, section: int, version: str, what: str) -> list[str]:
    return [f'.TH {name.upper()} {section} "" "polyrad {version}" "polyrad"', ".SH NAME",
            f"{roff(name)} \\- {roff(what)}"]


class Help:
    """The parts of PROGRAM --help."""

    def __init__(self, program: str):
        say = lambda option: subprocess.run([program, option], check=True, capture_output=True, text=True).stdout  # noqa: E731
        self.version = say("--version").split()[1]
        first, *blocks = re.split(r"\n\n", say("--help").rstrip("\n"))
        self.what = first.partition(": ")[2]
        self.synopsis: dict[str, list[str]] = {}
        self.commands: dict[str, str] = {}
        self.options: dict[str, str] = {}
        for block in blocks:
            self.read(block)

    def read(self, block: str) -> None:
        if block.startswith("  polyrad"):
            for line in re.sub(r"\n {8,}", " ", block).splitlines():
                words = line.split()
                self.synopsis.setdefault(words[1], []).append(" ".join(words))
        elif re.match(r"  -", block):
            for line in re.sub(r"\n {8,}", " ", block).splitlines():
                option, what = re.match(r"  (-\S+(?: [A-Z][A-Z/=]*)*) +(.*)", line).groups()
                self.options[option] = what
        elif re.match(r"[a-z]+ {2}", block):
            for line in re.sub(r"\n {4,}", " ", block).splitlines():
                name, what = line.split(None, 1)
                self.commands[name] = what
        else:
            self.rest = block.replace("\n", " ")

    def of(self, command: str) -> dict[str, str]:
        """The options in the synopsis of a command."""
        text = " ".join(self.synopsis[command])
        return {o: w for o, w in self.options.items() if re.search(rf"(?<![\w-]){re.escape(o.split()[0])}(?![\w-])", text)}


def options(listed: dict[str, str]) -> list[str]:
    made = [".SH OPTIONS"] if listed else []
    for option, what in listed.items():
        name, _, value = option.partition(" ")
        made += [".TP", f"\\fB{roff(name)}\\fR" + (f" \\fI{roff(value)}\\fR" if value else ""), roff(what)]
    return made


def end(h: Help, *others: str) -> list[str]:
    return [".SH EXIT STATUS", roff(h.rest.partition(": ")[2]), ".SH SEE ALSO", ", ".join(f"\\fB{roff(o[:-3])}\\fR{o[-3:]}" for o in others)]


def main_page(h: Help) -> list[str]:
    made = head("polyrad", 1, h.version, h.what) + [".SH SYNOPSIS", ".nf"]
    made += [roff(line) for lines in h.synopsis.values() for line in lines] + [".fi", ".SH COMMANDS"]
    for name, what in h.commands.items():
        made += [".TP", f"\\fB{name}\\fR", roff(what)]
    return made + options(h.options) + end(h, *(f"polyrad-{c}(1)" for c in h.commands), "polyrad(5)")


def command_page(h: Help, command: str) -> list[str]:
    what = h.commands[command]
    made = head("polyrad-" + command, 1, h.version, what) + [".SH SYNOPSIS", ".nf"]
    made += [*map(roff, h.synopsis[command]), ".fi"]
    return made + [".SH DESCRIPTION", roff(what[0].upper() + what[1:]) + "."] + options(h.of(command)) + end(h, "polyrad(1)", "polyrad(5)")


def cells(row: str) -> list[str]:
    return [c.strip() for c in re.split(r"(?<!\\)\|", row.strip().strip("|"))]


def table(rows: list[str]) -> list[str]:
    """A tagged paragraph a row: the first cell, then the others after the names of their columns."""
    names, made = cells(rows[0]), []
    for row in rows[2:]:
        first, *others = cells(row)
        said = [f"{n}: {c}" if n and n != "meaning" else c for n, c in zip(names[1:], others) if c]
        made += [".TP", roff(first), roff(". ".join(s.rstrip(".") for s in said) + ".")]
    return made


def deck_page(h: Help, markdown: str) -> list[str]:
    made = head("polyrad", 5, h.version, "the deck of polyrad, in YAML")
    text = "".join(re.findall(r"^## [234]\. .*?(?=^## |\Z)", markdown, re.MULTILINE | re.DOTALL))
    for part in re.split(r"\n{2,}(?![^`]*\n```(?:\n|\Z))", text.strip()):
        lines = part.split("\n")
        if lines[0].startswith("#"):
            level, title = lines.pop(0).split(" ", 1)
            made.append((".SH " if level == "##" else ".SS ") + roff(re.sub(r"^\d+\. ", "", title)))
        if not lines:
            continue
        if lines[0].startswith("```"):
            made += [".PP", ".nf", ".RS 4", *(roff(line).replace("\\fB", "`").replace("\\fR", "`") for line in lines[1:] if line != "```"), ".RE", ".fi"]
        elif lines[0].startswith("|"):
            made += table(lines)
        elif lines[0].startswith("- "):
            for item in re.split(r"\n(?=- )", "\n".join(lines)):
                made += [".IP \\(bu 2", roff(" ".join(item[2:].split()))]
        else:
            made += [".PP", roff(" ".join(" ".join(lines).split()))]
    return made + [".SH SEE ALSO", "\\fBpolyrad\\fR(1)"]


def pages(program: str, markdown: str) -> dict[str, list[str]]:
    h = Help(program)
    made = {"polyrad.1": main_page(h), "polyrad.5": deck_page(h, markdown)}
    return made | {f"polyrad-{c}.1": command_page(h, c) for c in h.commands}


def main() -> None:
    program, markdown, folder = sys.argv[1:]
    program = str(Path(os.environ.get("MESON_BUILD_ROOT", "."), program).absolute())
    prefix = os.environ.get("MESON_INSTALL_DESTDIR_PREFIX")
    to = Path(prefix, folder) if prefix else Path(folder)
    for name, lines in pages(program, Path(markdown).read_text(encoding="utf-8")).items():
        path = to / f"man{name[-1]}" / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text("\n".join(line for line in lines if line) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
