"""A viewer in space: perspective projection, painter's order, outlines of the scene."""

import argparse
from dataclasses import dataclass

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.collections import PolyCollection
from matplotlib.colors import LinearSegmentedColormap

from result import Problem

plt.rcParams.update({"font.size": 10, "axes.titlesize": 12, "svg.fonttype": "none"})

INK = (0.2, 0.2, 0.2, 1.0)

# The map inferno without its black end, in which outlines and faces would be lost.
ember = plt.colormaps["inferno"](np.linspace(0.12, 1, 256))
plt.colormaps.register(LinearSegmentedColormap.from_list("ember", ember, 256))


def save_svg(figure, path) -> None:
    """The same bytes for the same numbers; the figure is closed."""
    with plt.rc_context({"svg.hashsalt": "polyrad"}):
        figure.savefig(path, dpi=150, facecolor="white", metadata={"Date": None})
    plt.close(figure)


def add_options(parser: argparse.ArgumentParser) -> None:
    point = {"nargs": 3, "type": float, "metavar": ("X", "Y", "Z")}
    parser.add_argument(
        "--from",
        dest="eye",
        **point,
        help="the viewer's place [m]; default: a corner that shows much",
    )
    parser.add_argument("--to", **point, help="what is looked at; default: the scene's middle")
    parser.add_argument("--back", action="store_true", help="show surfaces from behind as well")


def direction(vertices: np.ndarray, normals: np.ndarray) -> np.ndarray:
    """From (1,1,1), unless another corner shows clearly more of the radiating sides."""
    corners = [(x, y, z) for x in (1, -1) for y in (1, -1) for z in (1, -1)]
    tried = np.array([(x, y, z * h) for h in (1, 0.4) for x, y, z in corners])
    tried /= np.linalg.norm(tried, axis=1)[:, None]
    side = vertices[:, 1:] - vertices[:, :1]
    area = np.linalg.norm(np.cross(side[:, 0], side[:, 1]), axis=1)
    # A small power likes three faces at a slant better than two at their full size.
    shown = np.maximum(tried @ normals.T, 0) ** 0.25 @ area
    return tried[0] if shown[0] > 0.9 * shown.max() else tried[shown.argmax()]


@dataclass
class View:
    eye: np.ndarray
    to: np.ndarray

    @classmethod
    def of(cls, options: argparse.Namespace, vertices: np.ndarray, normals: np.ndarray) -> "View":
        """The view that was asked for, else a good one of triangles [n,3,3]."""
        low, high = vertices.min(axis=(0, 1)), vertices.max(axis=(0, 1))
        to = np.array(options.to) if options.to else (low + high) / 2
        far = 5 * np.linalg.norm(high - low)
        eye = np.array(options.eye) if options.eye else to + far * direction(vertices, normals)
        if np.allclose(eye, to):
            raise Problem("--from and --to are the same point", 2)
        return cls(eye, to)

    def project(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Points [..., 3] to the picture [..., 2], and their distance along the line of sight."""
        forward = (self.to - self.eye) / np.linalg.norm(self.to - self.eye)
        up = np.array([0.0, 0.0, 1.0]) if abs(forward[2]) < 0.999 else np.array([0.0, 1.0, 0.0])
        right = np.cross(forward, up)
        right /= np.linalg.norm(right)
        relative = points - self.eye
        depth = relative @ forward
        # What is level with the viewer or behind has no place in the picture.
        scale = np.linalg.norm(self.to - self.eye) / np.where(depth > 1e-9, depth, np.nan)
        flat = np.stack([relative @ right, relative @ np.cross(right, forward)], axis=-1)
        return flat * scale[..., None], depth

    def sees(self, normal: np.ndarray, at: np.ndarray) -> np.ndarray:
        """Whether the viewer is on the side of each plane to which its normal points."""
        return np.einsum("ij,ij->i", normal, self.eye - at) > 0


def outlines(vertices: np.ndarray, normals: np.ndarray, pieces: int = 64) -> np.ndarray:
    """Edges of triangles [n,3,3], cut in pieces [m,2,3]; not those inside a plane surface."""
    seen: dict[tuple, list] = {}
    digits = 8 - int(np.floor(np.log10(np.abs(vertices).max() + 1e-300)))
    for triangle, normal in zip(vertices, normals, strict=True):
        for a, b in zip(triangle, np.roll(triangle, -1, axis=0), strict=True):
            key = tuple(sorted((tuple(a.round(digits) + 0.0), tuple(b.round(digits) + 0.0))))
            seen.setdefault(key, []).append((a, b, normal))
    kept = [
        uses[0][:2]
        for uses in seen.values()
        if len(uses) != 2 or np.dot(uses[0][2], uses[1][2]) < 1 - 1e-9
    ]
    ends = np.array(kept).reshape(-1, 2, 3)
    t = np.linspace(0, 1, pieces + 1)[:, None, None]
    along = ends[:, 0] + t * (ends[:, 1] - ends[:, 0])
    return np.stack([along[:-1], along[1:]], axis=2).reshape(-1, 2, 3)


def paint(axes, view: View, polygons: np.ndarray, colors: np.ndarray, edges: np.ndarray) -> None:
    """Draw quadrilaterals [n,4,3] and line pieces [m,2,3], the farthest first."""
    shape, depth = view.project(polygons)
    line, line_depth = view.project(edges[:, [0, 1, 1, 0]])
    # A line lies on the surfaces it bounds: pull it in front of the cells that touch it.
    size = np.linalg.norm(polygons.max(axis=1) - polygons.min(axis=1), axis=1).max(initial=0)
    order = np.concatenate([depth.mean(axis=1), line_depth.mean(axis=1) - size])
    shape = np.concatenate([shape, line])
    face = np.concatenate([colors, np.zeros((len(line), 4))])
    # Cells are stroked in their own colour, which hides the light seams between them.
    stroke = np.concatenate([colors, np.tile(INK, (len(line), 1))])
    width = np.concatenate([np.full(len(colors), 0.3), np.full(len(line), 0.8)])
    keep = np.isfinite(shape).all(axis=(1, 2))
    if not keep.any():
        raise Problem("nothing is in front of the viewer; try another --from or --to", 2)
    chosen = np.flatnonzero(keep)[np.argsort(-order[keep], kind="stable")]
    axes.add_collection(
        PolyCollection(
            shape[chosen],
            facecolors=face[chosen],
            edgecolors=stroke[chosen],
            linewidths=width[chosen],
            capstyle="round",
            joinstyle="round",
            rasterized=True,
        )
    )
    frame(axes, shape[chosen].reshape(-1, 2))


def frame(axes, points: np.ndarray) -> None:
    """Equal aspect, no box, a small margin around the points [n,2]."""
    low, high = np.nanmin(points, axis=0), np.nanmax(points, axis=0)
    margin = 0.03 * (high - low).max()
    axes.set(xlim=(low[0] - margin, high[0] + margin), ylim=(low[1] - margin, high[1] + margin))
    axes.set_aspect("equal")
    axes.axis("off")


def triad(figure, view: View) -> None:
    """The directions x, y, z in the lower right corner, below the colour bar."""
    size = 0.02 * np.linalg.norm(view.eye - view.to)
    tips, _ = view.project(np.concatenate([[view.to], view.to + size * np.eye(3)]))
    arms = (tips[1:] - tips[0]) / np.linalg.norm(tips[1:] - tips[0], axis=1).max()
    inset = figure.add_axes([0.86, 0.03, 0.12, 0.15])
    for arm, name in zip(arms, "xyz", strict=True):
        if np.linalg.norm(arm) < 0.2:  # it points at the viewer or away
            continue
        inset.annotate("", arm, (0, 0), arrowprops={"arrowstyle": "->", "color": INK, "lw": 0.8})
        inset.text(
            *(1.25 * arm), name, ha="center", va="center", fontsize=9, style="italic", color=INK
        )
    inset.set(xlim=(-1.3, 1.3), ylim=(-1.3, 1.3))
    inset.set_aspect("equal")
    inset.axis("off")
