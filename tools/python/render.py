"""A picture of a result file as a camera would take it, or a page that can be turned."""

import sys
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from matplotlib.cm import ScalarMappable
from matplotlib.colors import LogNorm, Normalize

import camera as space
import light
import page
import raster
import surfaces as geometry
from render_options import SMALLEST, read_options
from result import Problem, Result, run
from surfaces import Surfaces
from view import plt

RGB = ("red", "green", "blue")
BAR = 120  # pixels to the right of the scene


@dataclass
class Field:
    value: np.ndarray  # [5 n, 3] red, green, blue, or [5 n, 1]
    label: str  # with band and unit
    is_source: np.ndarray  # [n]: cells that emit more than they reflect, such as lamps


def read(result: Result, options) -> tuple[Surfaces, Field]:
    """The field that was asked for, and the surfaces on which it has values."""
    places = [f"VTKHDF/{kind}/{options.field}" for kind in ("PointData", "CellData")]
    found = [place for place in places if place in result.file]
    if not found:
        kinds = (result.file.get(f"VTKHDF/{kind}", ()) for kind in ("PointData", "CellData"))
        text = ", ".join(sorted({name for kind in kinds for name in kind}))
        if not text:
            raise Problem(f"{result.path} holds no picture; was it written by polyrad run?")
        raise Problem(f"{result.path} has no field '{options.field}'; it has {text}", 2)
    value, label = band_values(result, found[0], options.band)
    on_cells = found[0].startswith("VTKHDF/CellData")
    good = np.isfinite(value).all(axis=1)
    surfaces = Surfaces.of(result, good if on_cells else good[result.corners()].all(axis=1))
    value = geometry.values(result, surfaces, value, on_cells)
    is_source = np.zeros(len(surfaces.cell), bool)
    if options.field == "radiosity" and "VTKHDF/PointData/emission" in result.file:
        emission, _ = band_values(result, "VTKHDF/PointData/emission", options.band)
        emission = geometry.values(result, surfaces, emission, False)
        is_source = (emission > 0.5 * value).any(axis=1)[4::5]
    return surfaces, Field(value, options.field + label, is_source)


def band_values(result: Result, dataset: str, band: str | None) -> tuple[np.ndarray, str]:
    """Red, green and blue [n, 3] of three bands, else one band [n, 1] and its name and unit."""
    data = result.dataset(dataset)
    if data.ndim == 2 and data.shape[1] == 3 and band is None:
        return np.asarray(data[()], float)[:, color_order(result.bands)], ""
    value, unit, name = result.field(dataset, band)
    return value[:, None], (f", {name}" if name else "") + (f"  [{unit}]" if unit != "1" else "")


def important(field: Field, share: np.ndarray) -> np.ndarray:
    """Share [n] of each cell in the picture; lamps have none, unless little else is seen."""
    lit = np.where(field.is_source, 0, share)
    return lit if lit.sum() > 0.2 * share.sum() else share


def color_order(bands: list[str]) -> list[int]:
    """Which bands are red, green and blue: by name, else as they come."""
    names = [band.lower() for band in bands]
    return [names.index(color) for color in RGB] if sorted(names) == sorted(RGB) else [0, 1, 2]


def scale(field: Field, share: np.ndarray, options) -> ScalarMappable:
    """From values to colours; share [n]: of each cell that counts for the range."""
    value = field.value[:, 0].reshape(-1, 5)[share > 0]
    if options.range:
        low, high = options.range
        if not (np.isfinite([low, high]).all() and low < high and (low > 0 or not options.log)):
            raise Problem("--range needs two numbers MIN < MAX, with --log above 0", 2)
    elif options.log:
        if not (value > 0).any():
            raise Problem("--log needs values above 0", 2)
        low, high = max(value[value > 0].min(), 1e-6 * value.max()), value.max()
    else:
        low, high = value.min(), value.max()
    if high - low <= 1e-9 * abs(high):  # a constant: its rounding errors are no picture
        low, high = low - 0.05 * abs(low) - 1e-30, high + 0.05 * abs(high) + 1e-30
    norm = (LogNorm if options.log else Normalize)(low, high, clip=True)
    return ScalarMappable(norm, options.colors)


def beyond(colors: ScalarMappable, value: np.ndarray) -> str:
    """Which ends of the colour bar have values beyond them."""
    low, high = value.min() < colors.norm.vmin, value.max() > colors.norm.vmax
    return {(0, 0): "neither", (0, 1): "max", (1, 0): "min", (1, 1): "both"}[int(low), int(high)]


def with_bar(picture: np.ndarray, colors: ScalarMappable, label: str, extend: str, background):
    """The picture [h, w, 3] with a colour bar in BAR more columns."""
    height, width, _ = picture.shape
    full, dpi = width + BAR, 100
    figure = plt.figure(figsize=(full / dpi, height / dpi), dpi=dpi, facecolor=background)
    ink = "black" if np.dot(background, (0.3, 0.59, 0.11)) > 0.5 else "white"
    axes = figure.add_axes([(width + 0.12 * BAR) / full, 0.12, 0.15 * BAR / full, 0.76])
    bar = figure.colorbar(colors, cax=axes, extend=extend)
    bar.set_label(label, color=ink)
    bar.ax.tick_params(which="both", colors=ink, labelsize=8)
    bar.outline.set(linewidth=0.5, edgecolor=ink)
    figure.canvas.draw()
    made = np.asarray(figure.canvas.buffer_rgba())[:, :, :3] / 255
    made[:, :width] = picture
    return made


def lines(result: Result, surfaces: Surfaces, kind: str | None) -> tuple[np.ndarray, np.ndarray]:
    """What --mesh asks for: lines [m, 2, 3] and their normals [m, 3]."""
    if kind == "elements":
        return geometry.element_lines(result, surfaces)
    if kind == "triangles":
        return geometry.triangle_lines(result)
    return np.zeros((0, 2, 3)), np.zeros((0, 3))


@dataclass
class Look:
    """How values become colours."""

    colors: ScalarMappable | None  # of a colour map; None: red, green and blue as they are
    exposure: float

    def screen(self, value: np.ndarray) -> np.ndarray:
        if self.colors:
            return self.colors.to_rgba(value[:, 0])[:, :3]
        return light.srgb(light.rolled(self.exposure * value))


def save(picture: np.ndarray, path: Path) -> None:
    try:
        plt.imsave(path, np.clip(picture, 0, 1), metadata={"Software": "polyrad tools/render"})
    except OSError as error:
        raise Problem(f"{path} cannot be written: {error.strerror}") from None


def main() -> None:
    options = read_options(sys.argv[1:])
    result = Result(options.file)
    surfaces, field = read(result, options)
    is_map = field.value.shape[1] == 1
    width, height = options.size[0] - (BAR if is_map else 0), options.size[1]
    if width < SMALLEST:
        raise Problem(f"--size: with a colour bar the width is at least {BAR + SMALLEST}", 2)
    space.by_deck(result, options)
    camera = space.place(surfaces, options, width / height)
    share = camera.share(surfaces)
    if not (share > 0).any():
        raise Problem("nothing is seen from its radiating side; try another --from or --to", 2)
    counts = important(field, share)
    exposure = options.exposure or light.exposure(field.value, counts.repeat(5))
    look = Look(scale(field, counts, options) if is_map else None, exposure)
    line, normal = lines(result, surfaces, options.mesh)

    if options.html:
        drawn = page.scene(surfaces, field.value, camera, (line, normal), look)
        page.write(options.html, drawn, result.title, field.label, options.background)
    if not options.output:
        return
    seen = camera.sees(surfaces.normal, surfaces.middle())
    face = surfaces.face[seen[surfaces.face[:, 0] // 5]]
    line = line[camera.sees(normal, line[:, 0])]
    picture = raster.draw(
        surfaces.point,
        face,
        look.screen(field.value),
        line,
        camera,
        (width, height),
        options.background,
    )
    if is_map:
        extend = beyond(look.colors, field.value[(share > 0).repeat(5)])
        picture = with_bar(picture, look.colors, field.label, extend, options.background)
    save(picture, options.output)


if __name__ == "__main__":
    run(main)
