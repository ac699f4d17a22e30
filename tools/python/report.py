"""tools/report: the studies on one page."""

import argparse
import importlib
import os
from pathlib import Path

from report_context import Context, Section
from result import Problem, run

ROOT = Path(__file__).resolve().parents[2]
SECTIONS = {"work": "report_work", "quadrature": "report_quadrature", "paper": "report_paper", "stability": "report_stability"}

STYLE = """
body { font: 16px/1.5 system-ui, sans-serif; color: #222; max-width: 70rem; margin: 2rem auto; padding: 0 1rem }
table { border-collapse: collapse; margin: 1rem 0; font-size: 14px; display: block; overflow-x: auto }
th, td { border-bottom: 1px solid #ddd; padding: .2rem .6rem; text-align: right; white-space: nowrap }
th:first-child, td:first-child { text-align: left }
figure { margin: 1.5rem 0 } img { max-width: 100% } figcaption { color: #555; font-size: 14px }
h2 { margin-top: 3rem; border-top: 2px solid #222; padding-top: .5rem } nav a { margin-right: 1.5rem }
"""


def page(sections: dict[str, Section]) -> str:
    links = "".join(f'<a href="#{name}">{s.title}</a>' for name, s in sections.items())
    body = "\n".join(f'<h2 id="{name}">{s.title}</h2>\n{s.html}' for name, s in sections.items())
    return (
        '<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n<title>polyrad: report</title>\n'
        f"<style>{STYLE}</style>\n</head>\n<body>\n<h1>polyrad: speed, accuracy, stability</h1>\n"
        f"<nav>{links}</nav>\n{body}\n</body>\n</html>\n"
    )


def write_whole(path: Path, data: bytes) -> None:
    """No reader ever sees half of it."""
    part = path.with_suffix(".part")
    part.write_bytes(data)
    part.replace(path)


def publish(context: Context, figures: list[Path]) -> None:
    """The figures of a report in docs/img, where the documents show them."""
    for figure in figures:
        write_whole(context.docs / figure.name, figure.read_bytes())


def options() -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="tools/report", description=__doc__)
    parser.add_argument("-o", dest="folder", type=Path, default=Path("report"), metavar="FOLDER")
    parser.add_argument("--full", action="store_true")
    parser.add_argument("--only", action="append", choices=SECTIONS)
    parser.add_argument("--from", dest="known", type=Path, metavar="FOLDER")
    parser.add_argument("--docs", action="store_true")
    return parser.parse_args()


def main() -> None:
    given = options()
    if given.known and not given.known.is_dir():
        raise Problem(f"--from: there is no folder {given.known}; give that of an earlier report", 2)
    polyrad = Path(os.environ.get("POLYRAD", ROOT / "build/release/polyrad"))
    docs = ROOT / "docs/img" if given.docs else None
    context = Context(polyrad, ROOT, given.folder.resolve(), given.full, given.known, docs)
    chosen = [name for name in SECTIONS if not given.only or name in given.only]
    sections = {name: importlib.import_module(SECTIONS[name]).section(context) for name in chosen}
    if context.docs:
        publish(context, [path for section in sections.values() for path in section.figures])
    given.folder.mkdir(parents=True, exist_ok=True)
    path = given.folder / "report.html"
    write_whole(path, page(sections).encode())
    print(f"written {path}")


if __name__ == "__main__":
    run(main)
