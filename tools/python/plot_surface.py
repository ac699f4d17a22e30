"""The surfaces of a scene, coloured by radiosity or irradiance."""

import numpy as np
from matplotlib import colormaps
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize

import view as space
from result import Problem, Result, parser, run, save

SMOOTH = 30_000  # cells from which on one colour a cell looks smooth


def refine(cells: np.ndarray, values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Cut cells [n,4,3] into k x k bilinear pieces, each with the value at its middle."""
    k = int(np.clip(np.ceil(np.sqrt(SMOOTH / len(cells))), 1, 32))
    s = np.arange(k) / k

    def blend(at: np.ndarray, xi: np.ndarray, eta: np.ndarray) -> np.ndarray:
        weight = np.stack([(1 - xi) * (1 - eta), xi * (1 - eta), xi * eta, (1 - xi) * eta])
        return np.einsum("nc...,cm->nm...", at, weight)

    xi, eta = (grid.ravel() for grid in np.meshgrid(s, s))
    around = [(0, 0), (1 / k, 0), (1 / k, 1 / k), (0, 1 / k)]
    pieces = np.stack([blend(cells, xi + a, eta + b) for a, b in around], axis=2)
    middle = blend(values, xi + 0.5 / k, eta + 0.5 / k)
    return pieces.reshape(-1, 4, 3), middle.reshape(-1)


def main() -> None:
    options = parser(__doc__)
    options.add_argument(
        "--field", default="radiosity", help="radiosity (default), irradiance, ..."
    )
    options.add_argument("--band", help="name or number of a band; default: the first")
    options.add_argument(
        "--range", nargs=2, type=float, metavar=("MIN", "MAX"), help="of the colours"
    )
    options.add_argument(
        "--colors", default="ember", help="ember (default) or a map of matplotlib: viridis, ..."
    )
    space.add_options(options)
    options = options.parse_args()
    if options.colors not in colormaps:
        raise Problem(f"matplotlib has no colour map '{options.colors}'", 2)

    result = Result(options.file)
    fields = result.file.get("VTKHDF/PointData")
    if fields is not None and options.field not in fields:
        raise Problem(
            f"{result.path} has no field '{options.field}'; it has {', '.join(fields)}", 2
        )
    values, unit, band = result.field(f"VTKHDF/PointData/{options.field}", options.band)
    points = np.asarray(result.array("VTKHDF/Points"), float)
    number = result.corners()
    vertices = result.array("polyrad/triangles/vertices")
    normals = result.array("polyrad/triangles/normal")
    view = space.View.of(options, vertices, normals)
    of_cell = result.file.get("VTKHDF/CellData/triangle")
    if of_cell is not None and not options.back:  # a cell without a triangle has no radiating side
        number = number[view.sees(normals[result.of_parts(of_cell[()])], points[number].mean(axis=1))]
        seen = view.sees(normals, vertices[:, 0])
        vertices, normals = vertices[seen], normals[seen]
    number = number[np.isfinite(values[number]).all(axis=1)]
    if len(number) == 0:
        raise Problem("every surface is seen from behind; try another --from, or --back", 2)

    pieces, middle = refine(points[number], values[number])
    low, high = options.range or (values[number].min(), values[number].max())
    if high - low <= 1e-9 * abs(high):  # a constant: its rounding errors are no picture
        low, high = low - 0.05 * abs(low) - 1e-30, high + 0.05 * abs(high) + 1e-30
    scale = ScalarMappable(Normalize(low, high), options.colors)

    figure, axes = space.plt.subplots(figsize=(6.8, 5.6), layout="constrained")
    space.paint(axes, view, pieces, scale.to_rgba(middle), space.outlines(vertices, normals))
    space.triad(figure, view)
    axes.set_title(options.title or result.title, pad=12)
    bar = figure.colorbar(scale, ax=axes, shrink=0.76, aspect=26, pad=0.04, anchor=(0, 0.9))
    bar.set_label(f"{options.field}{', ' + band if band else ''}  [{unit}]")
    bar.outline.set_linewidth(0.5)
    save(figure, options.output, options.file)


run(main)
