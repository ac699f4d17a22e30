"""Runs of polyrad for the paper's tables and figures: results kept in a folder, one a name."""

from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from command import output_of
from paper_mesh import Solution
from result import Result

SIDE = 100  # of the grid of a sub-triangle on which runs are compared (theory 7)


@dataclass
class Study:
    """u_h of the runs of a study on the closed grid: value[run] is [triangle, sub-triangle, r, phi, band]."""

    n: list[int]
    unknowns: list[int]
    value: list[np.ndarray]

    def errors(self, band=0, weight=(1, 1, 1)) -> list[tuple[float, tuple[int, int, float, float]]]:
        """Largest difference from the last run, and its triangle, sub-triangle, phi and r; the error
        of every triangle is multiplied with its weight."""
        found = []
        for value in self.value[:-1]:
            off = np.abs(value - self.value[-1])[..., band] * np.reshape(weight, (-1, 1, 1, 1))
            t, s, j, i = np.unravel_index(off.argmax(), off.shape)
            found.append((float(off.max()), (int(t), int(s), i / (SIDE - 1), j / (SIDE - 1))))
        return found


@dataclass
class Runs:
    """Where polyrad is, where the decks are, and where results are kept."""

    polyrad: Path
    root: Path
    folder: Path
    done: set = field(default_factory=set)

    def deck(self, name: str) -> Path:
        return self.root / "inputs/studies" / name

    def result(self, deck: Path, name: str, settings: list[str]) -> Result:
        """polyrad run, once for each name."""
        path = self.folder / f"{name}.vtkhdf"
        if name not in self.done:
            output_of(self.polyrad, "run", deck, "-o", path, "--quiet", *settings)
            self.done.add(name)
        return Result(str(path))

    def triangles(self, deck: str) -> np.ndarray:
        """Their vertices [t, 3, 3]."""
        return self.solution(deck, 1, 1 + deck.endswith("p2.yml")).triangles

    def solution(self, deck: str, n: int, p: int, name="", settings: list[str] | None = None) -> Solution:
        """u_h of the paper's method, P1 on P(N,p); other settings need a name of their own."""
        given = ["--set", f"method.elements={n}", "--set", "output.sampling=1", *(settings or [])]
        return Solution(self.result(self.deck(deck), f"{deck[:-4]}{name}_{n}", given), n, p)

    def study(self, deck: str, numbers: list[int], settings: list[str] | None = None, bands=1) -> Study:
        """The runs of a study for these N, the last of which is the reference."""
        common = [self.deck(deck), "--set", f"study.vary.method.elements={numbers}", "--quiet"]
        common += [part for setting in settings or [] for part in ("--set", setting)]
        study = Study(numbers, [], [])
        for i in range(1, len(numbers) + 1):
            path = self.folder / "task.h5"
            output_of(self.polyrad, "study", *common, "--task", f"{i}/{len(numbers)}", "-o", path)
            task = Result(str(path)).file["polyrad/task"]
            study.unknowns.append(int(task.attrs["unknowns"]))
            study.value.append(task["value"][()].reshape(-1, 6, SIDE, SIDE, bands))
        return study
