"""The collocation points of a solution, on the triangles of the scene."""

import numpy as np

import view as space
from result import Problem, Result, parser, run, save


def main() -> None:
    options = parser(__doc__)
    options.add_argument("--size", type=float, help="of a dot [points]; default: by their number")
    space.add_options(options)
    options = options.parse_args()

    result = Result(options.file)
    points = np.asarray(result.array("polyrad/solution/point"), float)
    triangle = result.array("polyrad/solution/triangle")
    vertices = result.array("polyrad/triangles/vertices")
    normals = result.array("polyrad/triangles/normal")
    view = space.View.of(options, vertices, normals)
    seen = np.full(len(vertices), True) if options.back else view.sees(normals, vertices[:, 0])
    if not seen.any():
        raise Problem("every surface is seen from behind; try another --from, or --back", 2)

    figure, axes = space.plt.subplots(figsize=(6.8, 5.6), layout="constrained")
    figure.get_layout_engine().set(rect=(0, 0, 0.87, 1))
    faces = vertices[seen][:, [0, 1, 2, 2]]
    pale = np.tile((0.95, 0.95, 0.93, 1.0), (len(faces), 1))
    space.paint(axes, view, faces, pale, space.outlines(vertices[seen], normals[seen]))
    flat, depth = view.project(points[seen[triangle] & (triangle >= 0)])
    size = options.size or np.clip(60 / np.sqrt(max(len(points), 1)), 0.25, 2.5)
    axes.plot(*flat[depth > 0].T, "o", color="#1f4e79", ms=size, mew=0, zorder=3)
    space.triad(figure, view)
    axes.set_title(f"{options.title or result.title}\n{len(points)} collocation points", pad=12)
    save(figure, options.output, options.file)


run(main)
