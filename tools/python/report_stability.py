"""The stability laboratory: the studies that inputs/studies/stability/index.yml lists, a table, a figure
and a verdict each."""

import html
import re
import shlex
import sys
from pathlib import Path

import numpy as np

from command import output_of
from report_context import Context, Section, grid, image, provenance
from result import Problem, Result, names_in
from study_table import table


def entries(folder: Path) -> list[dict[str, str]]:
    """The items of index.yml: keys of one line, or folded texts (>-)."""
    found = []
    for item in re.split(r"^- ", (folder / "index.yml").read_text(), flags=re.MULTILINE)[1:]:
        pairs = re.findall(r"^ *(\w+): (?:>-\n)?((?:.|\n(?= {4}))*)", item, flags=re.MULTILINE)
        found.append({key: " ".join(value.split()) for key, value in pairs})
    return found


def words(text: str) -> list[str]:
    """A list of one line, [a, b]."""
    return [word.strip() for word in text.strip("[]").split(",")]


def cells(column: np.ndarray) -> list[str]:
    if column.dtype.kind in "OS":
        return [Path(name).stem if name.endswith(".obj") else name for name in names_in(column)]
    return [f"{value:.4g}" if np.isfinite(value) else "-" for value in column]


def rows_of(study: Result, wanted: list[str]) -> str:
    """What is varied, and the wanted columns."""
    columns = table(study)
    keys = [name for name in columns if "." in name] + [name for name in wanted if name in columns]
    texts = [cells(columns[name]) for name in keys]
    head = [name.split(".", 1)[-1].replace("_", " ") for name in keys]
    return grid(head, [list(row) for row in zip(*texts, strict=True)])


def figure(ctx: Context, entry: dict[str, str], studies: list[Result]) -> Path | None:
    """By tools/plot study; None where none of its numbers is above zero."""
    path = ctx.folder / "stability" / f"stability_{entry['id']}.svg"
    path.parent.mkdir(parents=True, exist_ok=True)
    plot = Path(__file__).parent / "plot_study.py"
    try:
        output_of(sys.executable, plot, *[s.path for s in studies], *shlex.split(entry["plot"]), "-o", path)
    except Problem as problem:
        print(f"report: no figure of {entry['id']}: {problem}", file=sys.stderr)
        return None
    return path


def part(ctx: Context, entry: dict[str, str], folder: Path) -> tuple[str, list[Path]]:
    names = words(entry["decks"])
    studies = [ctx.study("stability", folder / name, Path(name).stem) for name in names]
    text = [f"<h3>{html.escape(entry['title'])}</h3>", f"<p><b>Verdict.</b> {html.escape(entry['verdict'])}</p>"]
    text.append(f"<p><b>The program.</b> {html.escape(entry['program'])}</p>")
    path = figure(ctx, entry, studies[:1])
    if path:
        text.append(image(path, f"{entry['title']}: {provenance(studies[0])}"))
    text += [rows_of(study, words(entry["columns"])) for study in studies]
    return "\n".join(text), [path] if path else []


def section(ctx: Context) -> Section:
    folder = ctx.root / "inputs/studies/stability"
    parts = [part(ctx, entry, folder) for entry in entries(folder)]
    figures = [path for _, paths in parts for path in paths]
    return Section("Stability", "\n".join(text for text, _ in parts), figures)
