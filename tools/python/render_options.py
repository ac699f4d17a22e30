"""The command line of tools/render."""

import argparse
from pathlib import Path

import numpy as np
from matplotlib import colormaps
from matplotlib.colors import to_rgb

import view  # noqa: F401 - brings the colour map ember
from raster import LARGEST
from result import Problem

SMALLEST = 16  # pixels
POINTS = ("--from", "--to", "--up")


class Parser(argparse.ArgumentParser):
    def error(self, message: str) -> None:
        raise Problem(f"{message}; see tools/render --help", 2)


def wrong(text: str) -> argparse.ArgumentTypeError:
    return argparse.ArgumentTypeError(text)


def number(low: float, high: float):
    """A type of argparse: a number from low to high."""

    def read(text: str) -> float:
        try:
            value = float(text)
        except ValueError:
            value = np.nan
        if not low <= value <= high:
            raise wrong(f"'{text}' is not a number from {low:g} to {high:g}")
        return value

    return read


def point(text: str) -> list[float]:
    try:
        value = [float(x) for x in text.split(",")]
    except ValueError:
        value = []
    if len(value) != 3 or not np.isfinite(value).all():
        raise wrong(f"'{text}' is not three numbers x,y,z")
    return value


def size(text: str) -> tuple[int, int]:
    width, _, height = text.lower().partition("x")
    if not (width.isdecimal() and height.isdecimal()):
        raise wrong(f"'{text}' is not of the form 800x600")
    if not SMALLEST <= min(int(width), int(height)) <= max(int(width), int(height)) <= LARGEST:
        raise wrong(f"width and height are {SMALLEST} to {LARGEST}, not {text}")
    return int(width), int(height)


def color(text: str) -> tuple[float, float, float]:
    try:
        return to_rgb(text)
    except ValueError:
        raise wrong(f"'{text}' is no colour; try white, black or #rrggbb") from None


def color_map(text: str) -> str:
    if text not in colormaps:
        raise wrong(f"matplotlib has no colour map '{text}'")
    return text


def picture(text: str) -> Path:
    if not text.lower().endswith(".png"):
        raise wrong(f"{text}: a picture's name ends in .png")
    return Path(text)


def joined(arguments: list[str]) -> list[str]:
    """--from -1,2,3 and --from -1 2 3 as --from=-1,2,3: argparse takes -1,2,3 for an option."""
    made, left = [], list(arguments)
    while left:
        made.append(left.pop(0))
        if made[-1] in POINTS and left:
            made[-1] += "=" + left.pop(0)
            while left and made[-1].count(",") < 2:
                made[-1] += "," + left.pop(0)
    return made


def parser() -> argparse.ArgumentParser:
    made = Parser(
        prog="tools/render",
        description="A picture of a result file as a camera would take it, or a page to turn it.",
        epilog="More: docs/render.md",
        allow_abbrev=False,
    )
    add = made.add_argument
    add("file", metavar="FILE", help="a result of polyrad run")
    add(
        "-o",
        "--output",
        type=picture,
        metavar="PICTURE.png",
        help="default: FILE.png, or none if --html is given",
    )
    add("--html", type=Path, metavar="PAGE.html", help="a page that can be turned in a browser")
    add("--field", default="radiosity", help="radiosity (default), irradiance, error_bound, ...")
    add("--band", help="a colour map of this band (name, or number from 0)")
    add(
        "--exposure",
        type=number(1e-30, 1e30),
        metavar="X",
        help="brightness per unit of the field; default automatic",
    )
    add(
        "--range",
        nargs=2,
        type=number(-1e300, 1e300),
        metavar=("MIN", "MAX"),
        help="of the colour map; default automatic, without lamps",
    )
    add("--log", action="store_true", help="logarithmic colour map")
    add(
        "--colors",
        type=color_map,
        default="ember",
        metavar="MAP",
        help="ember (default) or a map of matplotlib: viridis, ...",
    )
    add("--mesh", choices=("elements", "triangles"), help="draw these lines")
    add("--from", dest="eye", type=point, metavar="X,Y,Z", help="the camera's place [m]")
    add("--to", type=point, metavar="X,Y,Z", help="what it looks at [m]; default: the middle")
    add("--up", type=point, metavar="X,Y,Z", help="default: z, or y where one looks along z")
    add(
        "--angle",
        type=number(0.1, 170),
        metavar="DEGREES",
        help="of view, of the picture's shorter side; default 40, or with --from as needed",
    )
    add("--size", type=size, default=(800, 800), metavar="WxH", help="pixels; default 800x800")
    add(
        "--background",
        type=color,
        default="white",
        metavar="COLOR",
        help="white (default), black, #rrggbb, ...",
    )
    return made


def read_options(arguments: list[str]) -> argparse.Namespace:
    options = parser().parse_args(joined(arguments))
    if not options.output and not options.html:
        options.output = Path(options.file).with_suffix(".png")
    return options
