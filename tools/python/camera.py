"""Where a picture is taken from: as asked for, else where the scene is open."""

from dataclasses import dataclass

import numpy as np

from result import Problem, Result
from surfaces import Surfaces
from view import direction as best_corner

ANGLE = 40.0  # [degree], the field of view where nothing else asks for another
MARGIN = 1.02  # of the picture over the scene


@dataclass
class Camera:
    eye: np.ndarray  # [3] [m]
    to: np.ndarray  # [3] [m]
    up: np.ndarray  # [3], unit, perpendicular to the line of sight
    angle: float  # of the picture's shorter side [degree]

    @property
    def axes(self) -> np.ndarray:
        """Right, up and back, the rows of a rotation."""
        back = unit(self.eye - self.to)
        return np.stack([np.cross(self.up, back), self.up, back])

    def sees(self, normal: np.ndarray, at: np.ndarray) -> np.ndarray:
        """Whether each place is seen from the side to which its normal points; a normal of 0 is."""
        return (np.einsum("ij,ij->i", normal, self.eye - at) > 0) | ~normal.any(axis=1)

    def share(self, s: Surfaces) -> np.ndarray:
        """Solid angle of each cell about, 0 if seen from behind or out of the picture."""
        toward = self.eye - s.middle()
        distance = np.maximum(np.linalg.norm(toward, axis=1), 1e-300)
        cosine = np.einsum("ij,ij->i", s.normal, toward) / distance
        cosine[~s.normal.any(axis=1)] = 1
        ahead = toward @ self.axes[2] / distance
        inside = ahead > np.cos(np.radians(min(0.75 * self.angle, 89)))
        return np.where(inside, np.maximum(cosine, 0), 0) * s.area / distance**2


def unit(vector: np.ndarray) -> np.ndarray:
    return vector / np.linalg.norm(vector)


def direction(s: Surfaces) -> np.ndarray:
    """Towards the viewer: out of the open side, else the corner from which much is seen.

    The sum of normal times area is 0 for a closed scene, and points out of an opening.
    """
    opening = s.area @ s.normal
    if np.linalg.norm(opening) < 0.05 * s.area.sum():
        at = s.point.reshape(-1, 5, 3)
        two = np.concatenate([at[:, [0, 1, 2]], at[:, [0, 2, 3]]])
        return best_corner(two, np.concatenate([s.normal, s.normal]))
    opening = unit(opening)
    axis = np.abs(opening).argmax()
    if abs(opening[axis]) > 0.97:  # walls slightly askew
        opening = np.eye(3)[axis] * np.sign(opening[axis])
    return opening


def upright(up: list[float] | None, back: np.ndarray) -> np.ndarray:
    """What was asked for, else z, or y where one looks along z; made perpendicular to back."""
    wanted = np.array(up or ([0, 0, 1] if abs(back[2]) < 0.999 else [0, 1, 0]), float)
    across = wanted - (wanted @ back) * back
    if np.linalg.norm(across) <= 1e-6 * np.linalg.norm(wanted):
        raise Problem("--up is along the line of sight; give another direction", 2)
    return unit(across)


def by_deck(result: Result, options) -> None:
    """What the deck says of the camera (output.camera), where no option does."""
    said = result.file.get("polyrad/camera")
    if said is None or said.shape != (10,):
        return
    said = [float(x) for x in said[()]]
    for name, value in (("eye", said[0:3]), ("to", said[3:6]), ("up", said[6:9])):
        if getattr(options, name) is None and np.isfinite(value).all():
            setattr(options, name, value)
    if options.angle is None and np.isfinite(said[9]):
        options.angle = said[9]


def place(s: Surfaces, options, aspect: float) -> Camera:
    """A camera that shows all that it can of the surfaces; aspect: width over height."""
    low, high = s.point.min(axis=0), s.point.max(axis=0)
    to = np.array(options.to) if options.to else (low + high) / 2
    half = np.array([max(aspect, 1), max(1 / aspect, 1)])  # of the picture; 1 on its shorter side
    if not options.eye:
        back = unit(direction(s))
        camera = Camera(to + back, to, upright(options.up, back), options.angle or ANGLE)
        fit_distance(camera, s, half, not options.to)
        return camera
    eye = np.array(options.eye)
    if np.allclose(eye, to, rtol=1e-12, atol=1e-9 * np.linalg.norm(high - low)):
        raise Problem("--from and --to are the same point", 2)
    camera = Camera(eye, to, upright(options.up, unit(eye - to)), options.angle or ANGLE)
    if not options.angle:
        relative = (s.point - eye) @ camera.axes.T
        reach = np.abs(relative[:, :2]) / half / np.maximum(-relative[:, 2:], 1e-9)
        camera.angle = float(np.clip(2 * MARGIN * np.degrees(np.arctan(reach.max())), 1, 75))
    return camera


def fit_distance(camera: Camera, s: Surfaces, half: np.ndarray, may_shift: bool) -> None:
    """Move the camera so near that what radiates towards it just fills the picture.

    A point at (x, y, z) right, up and back of camera.to is within slopes r at distance D if
    |x - cx| <= rx (D - z), the same for y. The least D over cx has as much room on both sides.
    """
    back = camera.axes[2]
    shown = s.normal @ back > -0.2  # in perspective one sees the sides of a box from within
    point = s.point.reshape(-1, 5, 3)[shown if shown.any() else slice(None)].reshape(-1, 3)
    slope = np.tan(np.radians(camera.angle / 2)) * half / MARGIN
    relative = (point - camera.to) @ camera.axes.T
    flat, depth = relative[:, :2], relative[:, 2:]
    above, below = (flat + slope * depth).max(axis=0), (slope * depth - flat).max(axis=0)
    shift = (above - below) / 2 if may_shift else np.zeros(2)
    camera.to = camera.to + shift @ camera.axes[:2]
    camera.eye = camera.to + (np.maximum(above - shift, below + shift) / slope).max() * back
