"""The paper, reproduced: its tables and computed figures beside ours, as a section of tools/report and as
the made parts of docs/paper.md (tools/paper)."""

import argparse
import os
import re
import tempfile
from pathlib import Path

import paper_tables as tables
from paper_runs import Runs
from paper_tables import Table
from result import Problem, run

ROOT = Path(__file__).resolve().parents[2]


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


def places(page: str) -> list[str]:
    """The names of the made parts of docs/paper.md."""
    return re.findall(r"<!-- (.*): made by tools/paper -->", page)


def main() -> None:
    options = argparse.ArgumentParser(prog="tools/paper", description=__doc__)
    options.add_argument("--page", default=str(ROOT / "docs/paper.md"), help="default: docs/paper.md")
    options = options.parse_args()
    polyrad = Path(os.environ.get("POLYRAD", ROOT / "build/release/polyrad"))
    page = Path(options.page)
    with tempfile.TemporaryDirectory() as folder:
        runs = Runs(polyrad, ROOT, Path(folder))
        page.write_text(with_tables(page.read_text(), all_tables(runs, full=True)))


if __name__ == "__main__":
    run(main)
