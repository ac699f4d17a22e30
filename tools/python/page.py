"""A page with a scene that can be turned in a browser (WebGL 2), all in one file."""

import base64
import json
from pathlib import Path

import numpy as np
from matplotlib.cm import ScalarMappable
from matplotlib.colors import LogNorm
from matplotlib.ticker import LogLocator, MaxNLocator

from camera import Camera
from light import KNEE
from raster import INK
from result import Problem
from surfaces import Surfaces

TEMPLATE = Path(__file__).with_name("page.html")


def packed(array: np.ndarray, kind: str = "<f4") -> str:
    return base64.b64encode(np.ascontiguousarray(array, kind).tobytes()).decode()


def ticks(colors: ScalarMappable) -> list[tuple[float, str]]:
    """Places 0..1 along the colour bar, and what is written there."""
    low, high = colors.get_clim()
    is_log = isinstance(colors.norm, LogNorm)
    at = (LogLocator(subs=(1, 2, 5)) if is_log else MaxNLocator(6)).tick_values(low, high)
    at = at[(at >= low) & (at <= high)]
    return [(float(colors.norm(x)), f"{x:.6g}") for x in at]


def scene(surfaces: Surfaces, value: np.ndarray, camera: Camera, lines, look) -> dict:
    """What the page draws: arrays as base64, places relative to the scene's middle."""
    low, high = surfaces.point.min(axis=0), surfaces.point.max(axis=0)
    middle = (low + high) / 2
    colors = look.colors
    table = colors.cmap(np.linspace(0, 1, 256)) if colors else np.zeros((256, 4))
    line, line_normal = lines
    return {
        "point": packed(surfaces.point - middle),
        "normal": packed(surfaces.normal),
        "value": packed(colors.norm(value[:, 0]) if colors else value),
        "face": packed(surfaces.face, "<u4"),
        "nFaces": len(surfaces.face),
        "line": packed(line - middle),
        "lineNormal": packed(line_normal),
        "nLines": len(line),
        "ink": INK,
        "colors": packed(np.rint(255 * table[:, :3]), "u1"),
        "isMap": colors is not None,
        "ticks": ticks(colors) if colors else [],
        "exposure": look.exposure,
        "knee": KNEE,
        "eye": list(camera.eye - middle),
        "to": list(camera.to - middle),
        "up": list(camera.up),
        "angle": camera.angle,
        "size": float(np.linalg.norm(high - low)),
    }


def write(path: Path, content: dict, title: str, label: str, background) -> None:
    """The template with the scene in it; what the browser reads cannot end the script early."""
    text = json.dumps({**content, "title": title, "label": label, "background": background})
    page = TEMPLATE.read_text(encoding="utf-8")
    made = page.replace("/*SCENE*/null", text.replace("<", "\\u003c"))
    try:
        path.write_text(made, encoding="utf-8")
    except OSError as error:
        raise Problem(f"{path} cannot be written: {error.strerror}") from None
