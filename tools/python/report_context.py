"""What the sections of tools/report share: where things are, studies that are run once, figures as text."""

import base64
import html
import sys
from dataclasses import dataclass, field
from pathlib import Path

from command import output_of
from result import Result


@dataclass
class Section:
    title: str
    html: str
    figures: list[Path] = field(default_factory=list)


@dataclass
class Context:
    """`known`: a folder of a report made before, or None."""

    polyrad: Path
    root: Path
    folder: Path
    full: bool = False
    known: Path | None = None
    docs: Path | None = None

    def place(self, section: str, name: str) -> tuple[Path, bool]:
        """A file of a section, and whether it is there already: here, or in the known report."""
        path = self.folder / section / name
        path.parent.mkdir(parents=True, exist_ok=True)
        known = self.known / section / name if self.known else None
        return (known, True) if known and known.is_file() else (path, False)

    def study(self, section: str, deck: Path, name: str, settings: list[str] | None = None) -> Result:
        """A study's file; its table shows which of its runs have failed."""
        path, is_there = self.place(section, f"{name}.h5")
        if not is_there:
            print(f"report: {deck.relative_to(self.root)} {' '.join(settings or [])}", file=sys.stderr)
            given = [part for setting in settings or [] for part in ("--set", setting)]
            output_of(self.polyrad, "study", deck, "-o", path, "--quiet", *given)
        return Result(str(path))


def image(path: Path, caption: str) -> str:
    """A figure that needs no file."""
    data = base64.b64encode(path.read_bytes()).decode()
    text = html.escape(caption)
    return (
        f'<figure><img alt="{text}" src="data:image/svg+xml;base64,{data}">'
        f"<figcaption>{text}</figcaption></figure>"
    )


def grid(head: list[str], rows: list[list[str]]) -> str:
    """A table; cells are texts."""

    def line(tag: str, cells: list[str]) -> str:
        return "<tr>" + "".join(f"<{tag}>{html.escape(c)}</{tag}>" for c in cells) + "</tr>"

    body = "\n".join(line("td", row) for row in rows)
    return f"<table>\n{line('th', head)}\n{body}\n</table>"


def provenance(result: Result) -> str:
    """Machine, threads, version and date of a study."""
    about = result.file["polyrad"].attrs
    words = {key: about[key] for key in ("machine", "threads", "version", "started", "git_revision")}
    said = {k: v.decode() if isinstance(v, bytes) else str(v) for k, v in words.items()}
    return (
        f"{said['machine']}, {said['threads']} threads, polyrad {said['version']} "
        f"({said['git_revision'][:8]}), {said['started'][:10]}"
    )
