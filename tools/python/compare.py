"""Two studies of one deck side by side: what became slower or less accurate beyond the noise."""

import argparse
import sys
from dataclasses import dataclass

import numpy as np

from result import Problem, Result, names_in, run, text
from study_table import table

PROVENANCE = ("version", "git_revision", "machine", "threads", "started")
# A run of which the host takes one processor away takes twice as long; rounding and the order of
# LU's threads change errors in the last digits.
SLOWER, LESS_ACCURATE, LEAST_SECONDS = 1.5, 1.02, 0.05


@dataclass
class Study:
    result: Result
    keys: list[str]
    runs: dict[tuple[str, ...], int]  # values of the varied keys: row
    columns: dict[str, np.ndarray]

    def stamp(self, name: str) -> str:
        return text(self.result.file["polyrad"].attrs.get(name, "unknown"))


def read(path: str) -> Study:
    result = Result(path)
    columns = table(result)
    keys = [name for name in columns if "." in name]
    if not keys:
        raise Problem(f"the study in {path} varies no key")
    values = [names_in(columns[name]) for name in keys]
    return Study(result, keys, {row: i for i, row in enumerate(zip(*values, strict=True))}, columns)


def ratio(before: float, after: float) -> float:
    """after / before; 1 where there was nothing to compare with, infinite where it was lost."""
    if before == after or not np.isfinite(before):
        return 1.0
    return after / before if before > 0 and np.isfinite(after) else np.inf


def judge(before: Study, after: Study, row: tuple[str, ...], options) -> tuple[list[str], list[str]]:
    """Cells of the row's line, and what is worse."""
    i, j = before.runs[row], after.runs[row]
    cells, worse = [*row], []
    for name, limit, word in (
        ("error", options.less_accurate, "LESS ACCURATE"),
        ("seconds_total", options.slower, "SLOWER"),
    ):
        old, new = before.columns[name][i], after.columns[name][j]
        change = ratio(old, new)
        cells += [f"{old:.4g}", f"{new:.4g}", f"{change:.3g}"]
        timed = name == "seconds_total"
        if timed and (before.stamp("machine") != after.stamp("machine") or new < options.least_seconds):
            continue
        if change > limit:
            worse.append(word)
    return [*cells, " ".join(worse)], worse


def show(lines: list[list[str]]) -> None:
    width = [max(len(line[c]) for line in lines) for c in range(len(lines[0]))]
    for line in lines:
        print("  ".join(cell.rjust(w) for cell, w in zip(line, width, strict=True)).rstrip())


def arguments() -> argparse.Namespace:
    options = argparse.ArgumentParser(prog="compare", description=__doc__)
    options.add_argument("before", metavar="BEFORE.h5")
    options.add_argument("after", metavar="AFTER.h5")
    for name, value, what in (
        ("--slower", SLOWER, "ratio of times from which a run counts as slower"),
        ("--less-accurate", LESS_ACCURATE, "ratio of errors from which it counts as less accurate"),
        ("--least-seconds", LEAST_SECONDS, "runs that take less are not judged by time"),
    ):
        options.add_argument(name, type=float, default=value, help=f"{what} (default {value})")
    return options.parse_args()


def main() -> None:
    options = arguments()
    before, after = read(options.before), read(options.after)
    if before.keys != after.keys:
        raise Problem(
            f"{options.before} varies {', '.join(before.keys)}, but {options.after} varies "
            f"{', '.join(after.keys)}: compare two runs of one study",
            2,
        )
    for name in PROVENANCE:
        print(f"{name:>13}: {before.stamp(name)}  ->  {after.stamp(name)}")
    if before.stamp("machine") != after.stamp("machine"):
        print("      machine: not the same; times are shown, not judged")
    both = [row for row in before.runs if row in after.runs]
    if not both:
        raise Problem(f"{options.before} and {options.after} have no run in common", 2)
    judged = [judge(before, after, row, options) for row in both]
    show([[*before.keys, "error", "after", "ratio", "seconds", "after", "ratio", ""]] +
         [cells for cells, _ in judged])
    for study, other, path in ((before, after, options.before), (after, before, options.after)):
        only = len([row for row in study.runs if row not in other.runs])
        if only:
            print(f"{only} runs are in {path} only")
    bad = sum(bool(worse) for _, worse in judged)
    print(f"{bad} of {len(both)} runs are worse beyond the noise")
    sys.exit(bad > 0)


run(main)
