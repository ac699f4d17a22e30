"""The paper, reproduced: its tables and computed figures beside ours, as a section of tools/report and as
the made parts of docs/paper.md (tools/paper)."""

import argparse
import html
import os
import re
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import paper_tables as tables
import report_paper_figures as meshes
import report_paper_solutions as solutions
import view
from paper_runs import Runs
from paper_tables import Table
from report_context import Section, image
from result import Problem, run

ROOT = Path(__file__).resolve().parents[2]


class Figure(NamedTuple):
    name: str  # of the file: paper_NAME.svg
    title: str
    caption: str
    draw: Callable  # (runs, full): a figure of matplotlib


FIGURES = [
    Figure("2_2", "Figures 2.2 and 2.3", "What a sector, and a quarter plane, give to a plane through its peak.", meshes.figure_2_2),
    Figure("3_4", "Figure 3.4", "The partition P(3,2) of the square.", meshes.figure_3_4),
    Figure("3_5", "Figure 3.5", "P(3,2) in all six sub-triangles of the reference triangle.", meshes.figure_3_5),
    Figure("3_6", "Figure 3.6", "P(2,2) on S1.", meshes.figure_3_6),
    Figure("3_7", "Figure 3.7", "Collocation points on S1, P(2,2), i* = 0.", meshes.figure_3_7),
    Figure("3_8", "Figure 3.8", "The same with constants in one row.", meshes.figure_3_8),
    Figure("4_1", "Figure 4.1", "Radiosity of S1, seen from (5, 5, 5).", solutions.figure_4_1),
    Figure("4_2", "Figure 4.2", "u on the arcs (4.7) about the vertex.", solutions.figure_4_2),
    Figure("4_3", "Figure 4.3", "Its derivative at r = 0.01, p = 1.", solutions.figure_4_3),
    Figure("4_4", "Figure 4.4", "The same, p = 2.", solutions.figure_4_4),
    Figure("exponents", "(4.6)", "Exponents from three points h, 2h, 4h.", solutions.figure_exponents),
    Figure("4_5", "Figure 4.5", "Solution of S2, seen from (5, 5, 2).", solutions.figure_4_5),
]


def drawn(figure: Figure, runs: Runs, full: bool, folder: Path) -> Path:
    """The figure as an SVG file, the same bytes for the same numbers."""
    path = folder / f"paper_{figure.name}.svg"
    view.save_svg(figure.draw(runs, full), path)
    return path


def all_tables(runs: Runs, full: bool) -> dict[str, Table]:
    """By the name of their place in docs/paper.md. Not full: without N = 16, and (4.6) from N = 16."""
    n = [1, 2, 4, 8, 16] if full else [1, 2, 4, 8]
    return {
        "table 3.1": tables.table_3_1(),
        "table 4.2": tables.table_cube(runs, "4.2", n),
        "formula 4.6": tables.table_4_6_formula(runs, 32 if full else 16),
        "table 4.3": tables.table_cube(runs, "4.3", [1, 2, 4, 8]),
        "table 4.5": tables.table_4_5(runs),
        "table 4.6": tables.table_wedge(runs, n),
    }


def with_tables(page: str, made: dict[str, Table]) -> str:
    """The text of docs/paper.md with what stands between its marks made anew."""
    for name, table in made.items():
        mark, end = f"<!-- {name}: made by tools/paper -->\n", f"<!-- end of {name} -->"
        if mark not in page or end not in page:
            raise Problem(f"docs/paper.md has no place for {name}, between '{mark.strip()}' and '{end}'")
        before, rest = page.split(mark)
        page = f"{before}{mark}\n{table.markdown()}\n\n{end}{rest.split(end, 1)[1]}"
    return page


def differences(page: str) -> str:
    """The list at the end of docs/paper.md, what differs and how it was settled, as HTML."""
    text = page.split("## Where the paper and we differ, and how it was settled")[1]
    items = re.split(r"^\d+\. ", text, flags=re.MULTILINE)[1:]
    found = []
    for item in items:
        line = html.escape(" ".join(item.split()))
        line = re.sub(r"\*\*(.*?)\*\*", r"<b>\1</b>", line)
        line = re.sub(r"`(.*?)`", r"<code>\1</code>", line)
        line = re.sub(r"(?<!\w)\*(\w[^*]*)\*", r"<i>\1</i>", line)
        found.append(f"<li>{line}</li>")
    return "<h3>Where the paper and we differ, and how it was settled</h3>\n<ol>" + "\n".join(found) + "</ol>"


def contents(runs: Runs, full: bool, page: str) -> tuple[str, list[Path]]:
    """All of it as HTML that needs no other file, and the figures as files. PAGE: text of docs/paper.md."""
    parts = [table.page() for table in all_tables(runs, full).values()]
    files = [drawn(figure, runs, full, runs.folder) for figure in FIGURES]
    for figure, file in zip(FIGURES, files, strict=True):
        parts.append(image(file, f"{figure.title}. {figure.caption}"))
    return "\n".join([*parts, differences(page)]), files


def section(ctx):
    """The section of tools/report."""
    folder = Path(ctx.folder) / "paper"
    folder.mkdir(parents=True, exist_ok=True)
    runs = Runs(Path(ctx.polyrad), Path(ctx.root), folder)
    page = (Path(ctx.root) / "docs/paper.md").read_text()
    return Section("The paper, reproduced", *contents(runs, ctx.full, page))


def places(page: str) -> list[str]:
    """The names of the made parts of docs/paper.md."""
    return re.findall(r"<!-- (.*): made by tools/paper -->", page)


def main() -> None:
    options = argparse.ArgumentParser(prog="tools/paper", description=__doc__)
    options.add_argument("--docs", default=str(ROOT / "docs"), help="default: docs; holds paper.md, img/")
    options.add_argument("--short", action="store_true", help="smaller N, no tables: a look at the figures")
    options = options.parse_args()
    polyrad = Path(os.environ.get("POLYRAD", ROOT / "build/release/polyrad"))
    docs = Path(options.docs)
    page = docs / "paper.md"
    (docs / "img").mkdir(exist_ok=True)
    with tempfile.TemporaryDirectory() as folder:
        runs = Runs(polyrad, ROOT, Path(folder))
        if not options.short:
            page.write_text(with_tables(page.read_text(), all_tables(runs, full=True)))
        for figure in FIGURES:
            drawn(figure, runs, not options.short, docs / "img")


if __name__ == "__main__":
    run(main)
