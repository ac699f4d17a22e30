"""Cut faces where others touch them, so that they share vertices and whole edges.

Every face is cut along the lines on which other faces meet it. Where faces of one plane overlap,
faces with opposite normals lose both overlapped parts (they see nothing: a block's bottom and the
floor below it), and of faces with equal normals the smaller one stays (of equal ones the later): a
lamp in the ceiling's plane. What lies closer together than the tolerance is one.
"""

import itertools
import math

import numpy as np
import shapely

from polygons import Scene, normal_of
from result import Problem

GRID = 1 / 16  # of the tolerance: rounding of lines where they are crossed in a plane


class Points:
    """Distinct points; one that is closer than the tolerance to another is that other."""

    def __init__(self, tolerance: float):
        self.tolerance = tolerance
        self.x: list[np.ndarray] = []
        self.cells: dict[tuple[int, ...], list[int]] = {}

    def add(self, x: np.ndarray) -> int:
        width = 4 * self.tolerance
        low = np.floor((x - self.tolerance) / width).astype(int)
        high = np.floor((x + self.tolerance) / width).astype(int)
        best, least = -1, self.tolerance
        for cell in itertools.product(*({a, b} for a, b in zip(low.tolist(), high.tolist()))):
            for k in self.cells.get(cell, ()):
                distance = math.dist(self.x[k], x)
                if distance <= least:
                    best, least = k, distance
        if best < 0:
            best = len(self.x)
            self.x.append(np.array(x, float))
            self.cells.setdefault(tuple(np.floor(x / width).astype(int).tolist()), []).append(best)
        return best


class Face:
    """A plane polygon, with what cuts it."""

    def __init__(self, corners: list[int], name: str, points: Points):
        self.corners, self.name = corners, name
        x = np.array([points.x[k] for k in corners])
        normal = normal_of(x)
        self.area = float(np.linalg.norm(normal)) / 2
        self.normal = normal / (2 * self.area) if self.area else normal
        self.origin = x.mean(axis=0)
        self.dropped = int(np.argmax(np.abs(normal)))  # the plane is seen along this axis
        self.kept = [(self.dropped + 1) % 3, (self.dropped + 2) % 3]
        self.bend = float(np.abs(self.height(x)).max())
        self.low, self.high = x.min(axis=0), x.max(axis=0)
        self.polygon = shapely.Polygon(x[:, self.kept])
        self.edges = {frozenset(e) for e in zip(corners, corners[1:] + corners[:1])}
        self.cuts: set[frozenset[int]] = set()
        self.dots: set[int] = set()
        self.overlapped: list[Face] = []  # faces in the same plane

    def height(self, x: np.ndarray) -> np.ndarray:
        return (x - self.origin) @ self.normal

    def flat(self, x: np.ndarray) -> np.ndarray:
        return x[..., self.kept]

    def lift(self, q: np.ndarray) -> np.ndarray:
        x = np.empty(3)
        x[self.kept] = q
        slope = self.normal[self.kept] @ (q - self.origin[self.kept])
        x[self.dropped] = self.origin[self.dropped] - slope / self.normal[self.dropped]
        return x


def triangulate(points: Points, corners: list[int]) -> list[list[int]]:
    """Triangles of a polygon that need not be plane: of a quadrilateral the better two."""
    if len(corners) == 3:
        return [corners]
    a, b, c, d = (points.x[k] for k in corners[:4])

    def fatness(*triangle) -> float:
        sides = [math.dist(p, q) ** 2 for p, q in itertools.combinations(triangle, 2)]
        return float(np.linalg.norm(normal_of(np.array(triangle)))) / sum(sides)

    if len(corners) == 4 and shapely.Polygon(Face(corners, "", points).polygon).is_valid:
        i, j, k, m = corners
        across = normal_of(np.array([a, b, c, d]))
        turned = [
            min(float(normal_of(np.array(t)) @ across) for t in pair) > 0
            for pair in ([(a, b, c), (a, c, d)], [(a, b, d), (b, c, d)])
        ]
        first = min(fatness(a, b, c), fatness(a, c, d)) * turned[0]
        second = min(fatness(a, b, d), fatness(b, c, d)) * turned[1]
        return [[i, j, k], [i, k, m]] if first >= second * (1 - 1e-9) else [[i, j, m], [j, k, m]]
    face = Face(corners, "", points)
    number = {tuple(face.flat(points.x[k])): k for k in corners}
    return cut_cell(face, face.polygon, number)


def cut_cell(face: Face, cell: shapely.Polygon, number: dict) -> list[list[int]]:
    """Constrained Delaunay triangles of a polygon whose corners have numbers."""
    triangles = []
    for piece in shapely.constrained_delaunay_triangles(cell).geoms:
        corners = [number[q] for q in shapely.normalize(piece).exterior.coords[:3]]
        xy = np.array(shapely.normalize(piece).exterior.coords[:3])
        turn = np.linalg.det(np.diff(xy, axis=0))
        keep = (turn > 0) == (face.normal[face.dropped] > 0)
        triangles.append(corners if keep else corners[::-1])
    return triangles


def faces_of(scene: Scene, points: Points) -> list[Face]:
    welded = [points.add(x) for x in scene.points]
    faces = []
    for corners, name in scene.faces:
        ring = [welded[k] for k in corners]
        ring = [k for k, before in zip(ring, ring[-1:] + ring[:-1]) if k != before]
        if len(ring) < 3:
            continue  # shrunk to nothing
        face = Face(ring, name, points)
        if face.area <= points.tolerance * max(math.dist(face.low, face.high), points.tolerance):
            continue
        if not face.polygon.is_valid:
            raise Problem(f"a face of '{name}' crosses or touches itself; divide it")
        if face.bend > points.tolerance:
            faces += [Face(triangle, name, points) for triangle in triangulate(points, ring)]
        else:
            faces.append(face)
    return faces


def near_pairs(faces: list[Face], tolerance: float):
    low = np.array([face.low for face in faces]) - tolerance
    high = np.array([face.high for face in faces]) + tolerance
    boxes = shapely.box(low[:, 0], low[:, 1], high[:, 0], high[:, 1])
    first, second = shapely.STRtree(boxes).query(boxes)
    keep = first < second
    keep &= (low[first, 2] <= high[second, 2]) & (low[second, 2] <= high[first, 2])
    order = np.lexsort((second[keep], first[keep]))
    return zip(first[keep][order].tolist(), second[keep][order].tolist())


def section(points: Points, body: Face, heights: np.ndarray, plane: Face):
    """Where a face meets another's plane: segments and single points, by number."""
    tolerance, ids, marks = points.tolerance, body.corners, []
    for k, (a, b) in enumerate(zip(ids, ids[1:] + ids[:1])):
        h, g = heights[k], heights[(k + 1) % len(ids)]
        if abs(h) <= tolerance:
            marks.append(a)
        elif abs(g) > tolerance and h * g < 0:
            marks.append(points.add(points.x[a] + h / (h - g) * (points.x[b] - points.x[a])))
    marks = list(dict.fromkeys(marks))
    if len(marks) < 2:
        return [], marks
    direction = np.cross(body.normal, plane.normal)
    marks.sort(key=lambda k: float(points.x[k] @ direction))
    segments = []
    for a, b in zip(marks, marks[1:]):
        middle = shapely.Point(body.flat((points.x[a] + points.x[b]) / 2))
        if body.polygon.distance(middle) <= tolerance:
            segments.append(frozenset((a, b)))
    return segments, [k for k in marks if not any(k in s for s in segments)]


def cross_edges(points: Points, a: Face, b: Face) -> None:
    """Number the points where edges of two faces of one plane cross, exactly on a's edges."""
    for e in a.edges:
        p, q = (points.x[k] for k in sorted(e))
        for f in b.edges:
            r, s = (points.x[k] for k in sorted(f))
            u, v, w = a.flat(q - p), a.flat(s - r), a.flat(r - p)
            across = u[0] * v[1] - u[1] * v[0]
            if abs(across) <= 1e-9 * np.linalg.norm(u) * np.linalg.norm(v):
                continue
            t = (w[0] * v[1] - w[1] * v[0]) / across
            o = (w[0] * u[1] - w[1] * u[0]) / across
            if 0 <= t <= 1 and 0 <= o <= 1:
                points.add(p + t * (q - p))


def touch(points: Points, face: Face, segments, dots) -> None:
    """Keep what lies on the face and is not its own edge or corner."""
    for segment in set(segments) - face.edges:
        line = shapely.LineString([face.flat(points.x[k]) for k in sorted(segment)])
        if face.polygon.distance(line) <= points.tolerance:
            face.cuts.add(segment)
    for k in set(dots) - set(face.corners):
        if face.polygon.distance(shapely.Point(face.flat(points.x[k]))) <= points.tolerance:
            face.dots.add(k)


def meet(points: Points, a: Face, b: Face) -> None:
    x, y = (np.array([points.x[k] for k in face.corners]) for face in (a, b))
    above_a, above_b = a.height(y), b.height(x)
    tolerance = points.tolerance
    if min(above_a) > tolerance or max(above_a) < -tolerance:
        return
    if min(above_b) > tolerance or max(above_b) < -tolerance:
        return
    if max(np.abs(above_a)) <= tolerance and max(np.abs(above_b)) <= tolerance:
        cross_edges(points, a, b)
        touch(points, a, b.edges, ())
        touch(points, b, a.edges, ())
        a.overlapped.append(b)
        b.overlapped.append(a)
        return
    touch(points, a, *section(points, b, above_a, a))
    touch(points, b, *section(points, a, above_b, b))


class Graph:
    """The lines in one face, crossed with each other: numbered nodes and edges."""

    def __init__(self, points: Points, face: Face):
        self.points, self.face = points, face
        segments = face.edges | face.cuts
        lines = [self.line(segment) for segment in sorted(segments, key=sorted)]
        noded = shapely.unary_union(lines, grid_size=GRID * points.tolerance)
        self.edges: set[frozenset[int]] = set()
        for part in shapely.get_parts(noded):
            ids = [points.add(face.lift(np.array(q))) for q in part.coords]
            self.edges |= {frozenset(e) for e in zip(ids, ids[1:]) if e[0] != e[1]}
        self.edges = {e for e in self.edges if self.inside(self.line(e).centroid)}
        for k in sorted(face.dots):
            self.split_at(k)
        self.connect()

    def at(self, k: int) -> np.ndarray:
        return self.face.flat(self.points.x[k])

    def line(self, edge) -> shapely.LineString:
        return shapely.LineString([self.at(k) for k in sorted(edge)])

    def inside(self, point: shapely.Point) -> bool:
        return self.face.polygon.distance(point) <= self.points.tolerance

    def split_at(self, k: int) -> None:
        for edge in [e for e in self.edges if k not in e]:
            if self.line(edge).distance(shapely.Point(self.at(k))) <= self.points.tolerance:
                self.edges -= {edge}
                self.edges |= {frozenset((k, end)) for end in edge}

    def connect(self) -> None:
        """Tie loose ends and single points to nodes they see, so that all lines bound cells."""
        while True:
            degree = dict.fromkeys(self.face.dots, 0)
            for edge in sorted(self.edges, key=sorted):
                for k in edge:
                    degree[k] = degree.get(k, 0) + 1
            loose = sorted(k for k, n in degree.items() if n < 2)
            if not loose:
                return
            end = loose[0]
            others = sorted(degree, key=lambda k: (math.dist(self.at(k), self.at(end)), k))
            tie = next((k for k in others if self.sees(end, k)), None)
            if tie is None:
                raise Problem(
                    f"a face of '{self.face.name}' cannot be cut; try another --tolerance"
                )
            self.edges.add(frozenset((end, tie)))

    def sees(self, a: int, b: int) -> bool:
        tie, tolerance = frozenset((a, b)), self.points.tolerance
        if a == b or tie in self.edges:
            return False
        line = self.line(tie)
        if not self.inside(line.centroid):
            return False
        for edge in self.edges:
            shared = edge & tie
            if not shared and line.distance(self.line(edge)) <= tolerance:
                return False
            if shared:
                (free,), (far,) = edge - shared, tie - shared
                if line.distance(shapely.Point(self.at(free))) <= tolerance:
                    return False
                if self.line(edge).distance(shapely.Point(self.at(far))) <= tolerance:
                    return False
        return True

    def cells(self) -> list[shapely.Polygon]:
        lines = [self.line(edge) for edge in sorted(self.edges, key=sorted)]
        return list(shapely.polygonize(lines).geoms)


def is_hidden(points: Points, faces: dict[int, int], face: Face, cell: shapely.Polygon) -> bool:
    """Whether a cell of a face goes, because of another face of its plane."""
    inner = cell.representative_point()
    x = face.lift(np.array(inner.coords[0]))
    for other in face.overlapped:
        if not other.polygon.covers(shapely.Point(other.flat(x))):
            continue
        if face.normal @ other.normal < 0:
            return True
        smaller = other.area < face.area * (1 - 1e-9)
        larger = other.area > face.area * (1 + 1e-9)
        if smaller or (not larger and faces[id(other)] > faces[id(face)]):
            return True
    return False


def pieces(points: Points, faces: dict[int, int], face: Face) -> list[list[int]]:
    if not face.cuts and not face.dots and not face.overlapped:
        return triangulate(points, face.corners)
    graph = Graph(points, face)
    number = {tuple(graph.at(k)): k for edge in graph.edges for k in edge}
    found = []
    for cell in graph.cells():
        inner = cell.representative_point()
        if face.polygon.covers(inner) and not is_hidden(points, faces, face, cell):
            found += cut_cell(face, cell, number)
    return found


def split_edges(points: Points, triangles: list[tuple[list[int], str]]):
    """Divide triangles at vertices of others that lie on their edges."""
    used = sorted({k for corners, _ in triangles for k in corners})
    x = np.array([points.x[k] for k in used])
    tree = shapely.STRtree(shapely.points(x[:, :2]))
    done, todo = [], list(reversed(triangles))
    while todo:
        corners, name = todo.pop()
        for m in range(3):
            a, b, c = (corners[(m + o) % 3] for o in range(3))
            p, q = points.x[a], points.x[b]
            low, high = np.minimum(p, q) - points.tolerance, np.maximum(p, q) + points.tolerance
            hits = [used[i] for i in tree.query(shapely.box(*low[:2], *high[:2]))]
            hits = [k for k in hits if k not in (a, b) and low[2] <= points.x[k][2] <= high[2]]
            d = q - p
            share = [(float((points.x[k] - p) @ d / (d @ d)), k) for k in hits]
            on = [
                (t, k)
                for t, k in share
                if 0 < t < 1 and math.dist(p + t * d, points.x[k]) <= points.tolerance
            ]
            if on:
                k = min(on)[1]
                todo += [([k, b, c], name), ([a, k, c], name)] if k != c else []
                break
        else:
            done.append((corners, name))
    return done


def conform(scene: Scene, tolerance: float) -> Scene:
    """Triangles that meet in vertices and whole edges only.

    tolerance: of the diameter of the scene's bounding box.
    """
    points = Points(tolerance * scene.size)
    faces = faces_of(scene, points)
    if not faces:
        raise Problem("nothing is left of the scene within the tolerance")
    for a, b in near_pairs(faces, points.tolerance):
        meet(points, faces[a], faces[b])
    order = {id(face): k for k, face in enumerate(faces)}
    triangles = [(t, face.name) for face in faces for t in pieces(points, order, face)]
    if not triangles:
        raise Problem("all faces overlap faces of opposite normal; nothing is left")
    triangles = split_edges(points, triangles)
    return Scene([tuple(x.tolist()) for x in points.x], triangles)
