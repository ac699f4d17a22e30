"""Reading result files of polyrad (layout: docs/format.md), with errors of one sentence."""

import argparse
import re
import sys
from collections.abc import Callable
from functools import cache, cached_property
from pathlib import Path

import h5py
import numpy as np


LAGRANGE_QUADRILATERAL = 70  # VTK's number


class Problem(Exception):
    """What stops a picture, in one sentence; code 2: what was asked for, 3: the file."""

    def __init__(self, message: str, code: int = 3):
        super().__init__(message)
        self.code = code


def run(main: Callable[[], None]) -> None:
    """Call main; a Problem becomes its sentence on stderr and its exit code."""
    try:
        main()
    except Problem as problem:
        print(f"{Path(sys.argv[0]).stem}: {problem}", file=sys.stderr)
        sys.exit(problem.code)


def text(value) -> str:
    return value.decode(errors="replace") if isinstance(value, bytes) else str(value)


def names_in(values: np.ndarray) -> list[str]:
    """Fixed-length or variable-length strings of a dataset."""
    return [text(value).rstrip("\0 ") for value in values]


def pretty_unit(unit: str) -> str:
    return re.sub(r"m(\d)", lambda m: "m" + "²³"[int(m[1]) - 2] if m[1] in "23" else m[0], unit)


@cache
def lagrange_quads(order: int) -> np.ndarray:
    """[order^2, 4]: corners of the parts of a Lagrange quadrilateral, as places among its points
    (corners, then sides, then the inside row by row)."""
    s, m = order, order - 1
    place = np.empty((s + 1, s + 1), int)  # [j, i]
    place[[0, 0, s, s], [0, s, s, 0]] = range(4)
    for k, side in enumerate((place[0, 1:s], place[1:s, s], place[s, 1:s], place[1:s, 0])):
        side[:] = 4 + k * m + np.arange(m)
    place[1:s, 1:s] = 4 + 4 * m + np.arange(m * m).reshape(m, m)
    corners = [place[:-1, :-1], place[:-1, 1:], place[1:, 1:], place[1:, :-1]]
    return np.stack(corners, axis=-1).reshape(-1, 4)


class Result:
    """An open result file."""

    def __init__(self, path: str):
        self.path = path
        if not Path(path).exists():
            raise Problem(f"there is no file {path}")
        try:
            self.file = h5py.File(path, "r")
        except OSError as error:
            raise Problem(f"{path} is not a file that HDF5 can read ({error})") from None

    def dataset(self, name: str) -> h5py.Dataset:
        found = self.file.get(name)
        if not isinstance(found, h5py.Dataset):
            raise Problem(f"{self.path} holds no dataset {name}; was it written by polyrad run?")
        return found

    def array(self, name: str) -> np.ndarray:
        """Values of a dataset; of CellData one for each cell of corners()."""
        value = self.dataset(name)[()]
        return self.of_parts(value) if name.startswith("VTKHDF/CellData/") else value

    def of_parts(self, value: np.ndarray) -> np.ndarray:
        order = self.orders
        return np.repeat(value, np.maximum(order, 1) ** 2, axis=0) if order.any() else value

    @property
    def title(self) -> str:
        """The deck's title, else the file's name."""
        group = self.file.get("polyrad")
        deck = text(group.attrs.get("deck", "")) if group is not None else ""
        found = re.search(r"^title:[ ]*(.*?)[ ]*(?:[ ]#.*)?$", deck, re.MULTILINE)
        title = found[1].strip("\"'") if found else ""
        return title or Path(self.path).stem

    def diagnostic(self, name: str):
        group = self.file.get("polyrad/diagnostics")
        return None if group is None else group.attrs.get(name)

    def field(self, dataset: str, band: str | None = None) -> tuple[np.ndarray, str, str]:
        """One band of a dataset [n] or [n, band]: values, unit, name of the band (or "")."""
        found = self.dataset(dataset)
        values = np.asarray(self.array(dataset), float)
        unit = pretty_unit(text(found.attrs.get("unit", "W/m2")))
        if values.ndim == 1 or values.shape[1] == 1:
            if band not in (None, "0", *self.bands):
                raise Problem(f"{self.path} has one band only, so no band '{band}'", 2)
            return values.reshape(len(values)), unit, ""
        bands = self.bands or [str(i) for i in range(values.shape[1])]
        chosen = bands[0] if band is None else band
        if chosen.isdigit() and chosen not in bands and int(chosen) < len(bands):
            chosen = bands[int(chosen)]
        if chosen not in bands:
            raise Problem(f"{self.path} has no band '{chosen}'; it has {', '.join(bands)}", 2)
        return values[:, bands.index(chosen)], unit, chosen

    @property
    def bands(self) -> list[str]:
        """Names of the bands."""
        group = self.file.get("polyrad")
        return names_in(group.attrs.get("bands", [])) if group is not None else []

    @cached_property
    def orders(self) -> np.ndarray:
        """Of each cell of the file: the order of a Lagrange quadrilateral, 0 of a linear cell."""
        count = np.diff(self.array("VTKHDF/Offsets"))
        types = self.file.get("VTKHDF/Types")
        lagrange = types[()] == LAGRANGE_QUADRILATERAL if types is not None else False
        return np.where(lagrange, np.sqrt(count).round().astype(int) - 1, 0)

    def corners(self) -> np.ndarray:
        """Four point numbers a linear cell; triangles repeat their last one. A Lagrange cell of order
        s is cut into s x s."""
        connectivity = self.array("VTKHDF/Connectivity")
        offsets = self.array("VTKHDF/Offsets")
        count = np.diff(offsets)
        if self.orders.any():
            quads = [connectivity[first + lagrange_quads(s)] for first, s in zip(offsets, self.orders)]
            return np.concatenate(quads)
        if len(count) == 0 or count.min() < 3 or count.max() > 4:
            raise Problem(f"{self.path}: the cells are not triangles and quadrilaterals")
        return connectivity[offsets[:-1, None] + np.minimum(np.arange(4), count[:, None] - 1)]


def parser(description: str, files: str = "FILE") -> argparse.ArgumentParser:
    """The options that every picture has."""
    kind = Path(sys.argv[0]).stem.removeprefix("plot_")
    made = argparse.ArgumentParser(prog=f"tools/plot {kind}", description=description)
    made.add_argument("file", metavar=files, nargs="+" if files == "FILE..." else None)
    made.add_argument(
        "-o", "--output", metavar="PICTURE", help=".png, .svg or .pdf; default FILE.png"
    )
    made.add_argument("--title", help="instead of the deck's title")
    return made


def save(figure, wanted: str | None, result: str) -> None:
    path = Path(wanted) if wanted else Path(result).with_suffix(".png")
    try:
        figure.savefig(path, dpi=200, facecolor="white")
    except ValueError:
        raise Problem(f"{path}: a picture's name ends in .png, .svg or .pdf", 2) from None
    except OSError as error:
        raise Problem(f"{path} cannot be written: {error.strerror}") from None
