"""Scenes of named polygons: what tools/convert and tools/scene read, change and write."""

import math
from collections.abc import Iterable
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from result import Problem


@dataclass
class Scene:
    """Faces with their corners in order; the right-hand rule gives the side that radiates."""

    vertices: list[tuple[float, float, float]] = field(default_factory=list)
    faces: list[tuple[list[int], str]] = field(default_factory=list)  # corners, surface

    def add(self, name: str, corners: Iterable[Iterable[float]]) -> None:
        """One face by the coordinates of its corners."""
        first = len(self.vertices)
        self.vertices += [tuple(float(x) for x in corner) for corner in corners]
        self.faces.append((list(range(first, len(self.vertices))), name))

    @property
    def points(self) -> np.ndarray:
        return np.array(self.vertices, float).reshape(-1, 3)

    @property
    def size(self) -> float:
        """Diameter of the bounding box."""
        points = self.points
        return float(np.linalg.norm(np.ptp(points, axis=0))) if len(points) else 0.0


def write_obj(scene: Scene, path: str, comment: str) -> None:
    """Vertices that are used, then faces by surface."""
    number: dict[int, int] = {}
    rows = []
    by_name: dict[str, list[list[int]]] = {}
    for corners, name in scene.faces:
        by_name.setdefault(name, []).append(corners)
    for name, faces in by_name.items():
        rows.append(f"usemtl {name}")
        for corners in faces:
            rows.append(
                "f " + " ".join(str(number.setdefault(v, len(number) + 1)) for v in corners)
            )
    text = "".join(f"# {line}\n" for line in comment.splitlines())
    text += "".join("v {!r} {!r} {!r}\n".format(*map(float, scene.vertices[v])) for v in number)
    try:
        Path(path).write_text(text + "\n".join(rows) + "\n", encoding="utf-8")
    except OSError as error:
        raise Problem(f"{path} cannot be written: {error.strerror}") from None


def statements(text: str) -> Iterable[tuple[int, str]]:
    """Lines of an OBJ file with their numbers, without comments, continued lines joined."""
    held, first = "", 0
    for number, line in enumerate(text.splitlines(), 1):
        first = first if held else number
        line = held + line.split("#")[0] if line.lstrip().startswith("#") else held + line
        if line.endswith("\\"):
            held = line[:-1] + " "
            continue
        held = ""
        yield first, line.split(" #")[0].strip()


def read_obj(path: str) -> Scene:
    """v and f with the names of usemtl, else g, else o; by the rule of docs/format.md."""
    try:
        text = Path(path).read_text(encoding="utf-8-sig")
    except OSError as error:
        raise Problem(f"{path} cannot be read: {error.strerror}") from None
    except UnicodeDecodeError:
        raise Problem(f"{path} is no text; is it a Wavefront OBJ file?") from None
    scene, named = Scene(), []
    now = {"usemtl": "", "g": "", "o": ""}
    given = set()
    for number, line in statements(text):
        word, _, rest = line.partition(" ")
        try:
            if word == "v":
                x, y, z = map(float, rest.split()[:3])
                scene.vertices.append((x, y, z))
            elif word == "f":
                corners = [int(corner.split("/")[0]) for corner in rest.split()]
                corners = [k - 1 if k > 0 else len(scene.vertices) + k for k in corners]
                if len(corners) < 3 or not all(0 <= k < len(scene.vertices) for k in corners):
                    raise ValueError
                scene.faces.append((corners, ""))
                named.append(dict(now))
            elif word in now:
                now[word] = rest.strip()
                given.add(word)
        except ValueError:
            raise Problem(f"{path}:{number}: this is no good '{word}' line: {line[:60]}") from None
    rule = next((word for word in now if word in given), "o")
    scene.faces = [
        (corners, names[rule] or Path(path).stem)
        for (corners, _), names in zip(scene.faces, named, strict=True)
    ]
    check(scene, path)
    return scene


def check(scene: Scene, path: str) -> None:
    if not scene.faces:
        raise Problem(f"{path} holds no faces")
    if not np.isfinite(scene.points).all():
        raise Problem(f"{path} has vertices that are not finite")


def normal_of(points: np.ndarray) -> np.ndarray:
    """Newell's normal of a polygon, of length 2 area."""
    p = points - points[0]
    return np.cross(p[1:-1], p[2:]).sum(axis=0)


def refine(scene: Scene, n: int) -> Scene:
    """Bisect longest edges of triangles, in all triangles at the edge, until there are n."""
    import heapq

    points = [tuple(p) for p in scene.vertices]
    triangles = {k: (tuple(corners), name) for k, (corners, name) in enumerate(scene.faces)}
    at: dict[tuple[int, int], set[int]] = {}

    def edges(corners):
        return [tuple(sorted((corners[m], corners[(m + 1) % 3]))) for m in range(3)]

    heap: list[tuple[float, tuple[int, int]]] = []

    def enter(k):
        for edge in edges(triangles[k][0]):
            at.setdefault(edge, set()).add(k)
            length = math.dist(points[edge[0]], points[edge[1]])
            heapq.heappush(heap, (-round(length, 12), edge))

    for k in triangles:
        enter(k)
    fresh = len(triangles)
    while len(triangles) < n and heap:
        _, edge = heapq.heappop(heap)
        sharing = at.pop(edge, None)
        if not sharing:
            continue
        middle = len(points)
        points.append(tuple((a + b) / 2 for a, b in zip(points[edge[0]], points[edge[1]])))
        for k in sorted(sharing):
            corners, name = triangles.pop(k)
            for other in edges(corners):
                if other != edge:
                    at[other].discard(k)
            for end in edge:
                triangles[fresh] = (tuple(middle if v == end else v for v in corners), name)
                enter(fresh)
                fresh += 1
    return Scene(points, [(list(corners), name) for corners, name in triangles.values()])
