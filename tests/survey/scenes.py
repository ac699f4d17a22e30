"""Random scenes of the survey: make(kind, seed) gives a Scene, which writes a deck of polyrad and the
plain text that the oracle reads.

A kind and a seed always give the same scene. Faces radiate on the side from which their corners run
counterclockwise; side 'both' is two faces back to back.
"""

import json
import math
import random

SIGMA = 5.670374419184429e-8


def add(a, b):
    return tuple(x + y for x, y in zip(a, b))


def scale(t, a):
    return tuple(t * x for x in a)


def sub(a, b):
    return tuple(x - y for x, y in zip(a, b))


def dot(a, b):
    return sum(x * y for x, y in zip(a, b))


def cross(a, b):
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def unit(a):
    return scale(1 / math.sqrt(dot(a, a)), a)


class Scene:
    """Faces (surface, three corners, both sides?) and the optics of the surfaces."""

    def __init__(self, kind, seed):
        self.kind, self.seed = kind, seed
        self.random = random.Random(f"{kind} {seed}")
        self.bands = 1
        self.closed = False
        self.faces = []
        self.optics = {}

    # -- geometry ---------------------------------------------------------------------------------
    def triangle(self, name, a, b, c, both=False):
        self.faces.append((name, (a, b, c), both))

    def quad(self, name, a, b, c, d, both=False):
        """A plane quadrilateral, counterclockwise, cut along one of its diagonals."""
        if self.random.random() < 0.5:
            a, b, c, d = b, c, d, a
        self.triangle(name, a, b, c, both)
        self.triangle(name, a, c, d, both)

    def box(self, name, corners, inward=False, without=()):
        """Eight corners: bottom counterclockwise seen from above, then top; name may be a list of six:
        bottom, top, sides."""
        p = corners
        sides = [(0, 3, 2, 1), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7)]
        for k, side in enumerate(sides):
            if k in without:
                continue
            q = [p[i] for i in (reversed(side) if inward else side)]
            self.quad(name if isinstance(name, str) else name[k], *q)

    def turn(self):
        """The whole scene, turned at random: nothing is along an axis any more."""
        z = unit([self.random.gauss(0, 1) for _ in range(3)])
        x = unit(cross(z, (0.6, -0.3, 0.74)))
        y = cross(z, x)
        at = [self.random.uniform(-1, 1) for _ in range(3)]
        place = {}
        for name, corners, both in self.faces:
            for p in corners:
                place[p] = tuple(at[d] + p[0] * x[d] + p[1] * y[d] + p[2] * z[d] for d in range(3))
        self.faces = [(n, tuple(place[p] for p in c), b) for n, c, b in self.faces]

    def size(self, low, high):
        return low * (high / low) ** self.random.random()

    # -- optics -----------------------------------------------------------------------------------
    def light(self, name, rho, emission):
        spread = lambda x: list(x) if isinstance(x, (list, tuple)) else [x] * self.bands
        self.optics[name] = {"rho": spread(rho), "emission": spread(emission)}

    def heat(self, name, emissivity, **what):
        self.optics[name] = dict(emissivity=emissivity, **what)

    def reflectivity(self):
        return [self.random.choice([0, self.random.uniform(0, 0.9), self.random.uniform(0, 0.9)]) for _ in range(self.bands)]

    def emission(self):
        return [self.random.choice([0, self.random.uniform(0, 1), self.size(1e-2, 10)]) for _ in range(self.bands)]

    def light_up(self):
        """Random optics for what has none yet; something emits."""
        names = [n for n in self.names() if n not in self.optics]
        black = self.random.random() < 0.4
        for name in names:
            self.light(name, 0 if black else self.reflectivity(), self.emission())
        for band in range(self.bands):
            if names and not any(o["emission"][band] for o in self.optics.values()):
                self.optics[self.random.choice(names)]["emission"][band] = 1.0

    def names(self):
        return list(dict.fromkeys(name for name, _, _ in self.faces))

    def radiation(self, name):
        """rho and E of the equation, lists over the bands."""
        o = self.optics[name]
        if "rho" in o:
            return o["rho"], o["emission"]
        if "flux" in o:
            return [1.0], [o["flux"]]
        return [1 - o["emissivity"]], [o["emissivity"] * SIGMA * o["temperature"] ** 4]

    @property
    def thermal(self):
        return any("emissivity" in o for o in self.optics.values())

    @property
    def black(self):
        return all(not any(self.radiation(n)[0]) for n in self.names())

    # -- files ------------------------------------------------------------------------------------
    def deck(self):
        lines = [f"title: {self.kind} {self.seed}"]
        if self.bands > 1:
            lines.append("bands: [" + ", ".join(f"b{k}" for k in range(self.bands)) + "]")
        lines += ["scene:", "  triangles:"]
        for name, corners, both in self.faces:
            text = ", ".join("[" + ", ".join(repr(float(x)) for x in p) + "]" for p in corners)
            lines.append(f"    - {{name: {name}, vertices: [{text}]{', side: both' if both else ''}}}")
        lines.append("  surfaces:")
        for name, optics in self.optics.items():
            lines.append(f"    {name}: {json.dumps(optics)}")
        lines += ["accuracy: {tolerance: 1e-3}", "output: {view_factors: true, sampling: 1}"]
        return "\n".join(lines) + "\n"

    def plain(self):
        names = self.names()
        single = []
        for name, (a, b, c), both in self.faces:
            single.append((name, (a, b, c)))
            if both:
                single.append((name, (a, c, b)))
        lines = [f"{len(single)} {len(names)} {self.bands}"]
        for name, corners in single:
            rho, emission = self.radiation(name)
            numbers = [x for p in corners for x in p] + list(rho) + list(emission)
            lines.append(f"{names.index(name)} " + " ".join(repr(float(x)) for x in numbers))
        return "\n".join(lines) + "\n"


# -- faces that cross -------------------------------------------------------------------------------
def pierces(a, b, t):
    """Does the segment a b pass through triangle t, or near its rim?"""
    n = cross(sub(t[1], t[0]), sub(t[2], t[0]))
    x, y = dot(n, sub(a, t[0])), dot(n, sub(b, t[0]))
    if x * y > 0 or x == y:
        return False
    p = add(a, scale(x / (x - y), sub(b, a)))
    return all(dot(n, cross(sub(t[(k + 1) % 3], t[k]), sub(p, t[k]))) > -0.02 * dot(n, n) for k in range(3))


def crossing(s, t):
    return any(pierces(s[k], s[(k + 1) % 3], t) or pierces(t[k], t[(k + 1) % 3], s) for k in range(3))


# -- pieces -----------------------------------------------------------------------------------------
def upright(center, width, depth, angle, low, high):
    """Corners of a box that is turned about the vertical."""
    c, s = math.cos(angle), math.sin(angle)
    flat = [(center[0] + x * width * c - y * depth * s, center[1] + x * width * s + y * depth * c)
            for x, y in ((-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5))]
    return [(x, y, low) for x, y in flat] + [(x, y, high) for x, y in flat]


def room_corners(x, y, z):
    return [(0, 0, 0), (x, 0, 0), (x, y, 0), (0, y, 0), (0, 0, z), (x, 0, z), (x, y, z), (0, y, z)]


ROOM = ["floor", "ceiling", "south", "east", "north", "west"]


def plate(s, name, x0, x1, y0, y1, z, up, both=False):
    p = [(x0, y0, z), (x1, y0, z), (x1, y1, z), (x0, y1, z)]
    s.quad(name, *(p if up else p[::-1]), both=both)


def grid_sheet(s, name, xs, ys, z, missing=()):
    """A two-sided sheet of conforming rectangles, but for the missing ones (i, j)."""
    for i in range(len(xs) - 1):
        for j in range(len(ys) - 1):
            if (i, j) not in missing:
                plate(s, name, xs[i], xs[i + 1], ys[j], ys[j + 1], z, True, both=True)


def spots(s, n):
    """n cells of the unit square, 3 x 3."""
    return s.random.sample([(i, j) for i in range(3) for j in range(3)], n)


# -- kinds ------------------------------------------------------------------------------------------
def soup(s):
    for k in range(s.random.randint(4, 12)):
        for _ in range(200):
            size = s.size(1e-2, 1)
            center = [s.random.random() for _ in range(3)]
            t = [add(center, scale(size, [s.random.gauss(0, 0.5) for _ in range(3)])) for _ in range(3)]
            n = cross(sub(t[1], t[0]), sub(t[2], t[0]))
            if math.sqrt(dot(n, n)) > 0.05 * max(dot(sub(t[i], t[i - 1]), sub(t[i], t[i - 1])) for i in range(3)) and not any(
                    crossing(t, c) for _, c, _ in s.faces):
                s.triangle(f"s{k}", *t, both=s.random.random() < 0.4)
                break


def crossed(s):
    """Triangles that cross each other, with no common edges."""
    for k in range(s.random.randint(3, 7)):
        size = s.size(0.2, 1)
        center = [s.random.random() for _ in range(3)]
        t = [add(center, scale(size, [s.random.gauss(0, 0.5) for _ in range(3)])) for _ in range(3)]
        s.triangle(f"s{k}", *t, both=s.random.random() < 0.4)


def hover(s):
    x, y, z = (s.random.uniform(0.6, 1.4) for _ in range(3))
    s.box(ROOM, room_corners(x, y, z), inward=True)
    for k, (i, j) in enumerate(spots(s, s.random.randint(1, 3))):
        width, depth = (s.random.uniform(0.1, 0.6) * min(x, y) / 3 for _ in range(2))
        low = s.size(1e-3, 0.5) * z
        center = ((i + 0.5) * x / 3, (j + 0.5) * y / 3)
        s.box(f"box{k}", upright(center, width, depth, s.random.uniform(0, 6), low, low + s.random.uniform(0.02, 0.4) * z))
    if s.random.random() < 0.5:
        a, b, w = s.random.uniform(0.1, 0.8) * x, s.random.uniform(0.1, 0.8) * y, s.size(1e-2, 0.2)
        plate(s, "lamp", a, a + w, b, b + w, 0.97 * z, False)
        s.light("lamp", 0, s.size(1, 100))
    s.closed = True


def stand(s):
    """A box on the floor, which is cut round it."""
    x, y, z = (s.random.uniform(0.6, 1.4) for _ in range(3))
    s.box(ROOM, room_corners(x, y, z), inward=True, without=(0,))
    width, depth = s.size(0.02, 0.3), s.size(0.02, 0.3)
    center = (x * s.random.uniform(0.35, 0.65), y * s.random.uniform(0.35, 0.65))
    angle = s.random.uniform(-0.6, 0.6)
    corners = upright(center, width, depth, angle, 0, s.size(0.02, 0.9) * z)
    s.box("box", corners, without=(0,))
    outer = room_corners(x, y, z)[:4]
    for k in range(4):
        s.quad("floor", outer[k], outer[(k + 1) % 4], corners[(k + 1) % 4], corners[k])
    s.closed = True


def stand_uncut(s):
    """Boxes on a floor that goes on below them."""
    x, y, z = (s.random.uniform(0.6, 1.4) for _ in range(3))
    s.box(ROOM, room_corners(x, y, z), inward=True)
    for k, (i, j) in enumerate(spots(s, s.random.randint(1, 2))):
        center = ((i + 0.5) * x / 3, (j + 0.5) * y / 3)
        width, depth = (s.random.uniform(0.1, 0.6) * min(x, y) / 3 for _ in range(2))
        corners = upright(center, width, depth, s.random.uniform(0, 6), 0, s.size(0.02, 0.9) * z)
        s.box(f"box{k}", corners, without=(0,))


def sheets(s):
    gap = s.size(0.05, 1)
    plate(s, "low", 0, 1, 0, 1, 0, True)
    plate(s, "high", 0, 1, 0, 1, gap, False)
    for k in range(s.random.randint(1, 4)):
        for _ in range(200):
            center = (s.random.random(), s.random.random(), gap * s.random.uniform(0.1, 0.9))
            size = s.size(0.05, 0.5)
            t = [add(center, (size * s.random.gauss(0, 1), size * s.random.gauss(0, 1), 0)) for _ in range(3)]
            t = [(p[0], p[1], min(max(p[2] + gap * s.random.uniform(-0.3, 0.3), 0.02 * gap), 0.98 * gap)) for p in t]
            n = cross(sub(t[1], t[0]), sub(t[2], t[0]))
            if math.sqrt(dot(n, n)) > 0.1 * size * size and not any(crossing(t, c) for _, c, _ in s.faces):
                s.triangle(f"sheet{k}", *t, both=True)
                break


def needles(s):
    plate(s, "low", 0, 1, 0, 1, 0, True)
    gap = s.size(0.1, 1)
    plate(s, "high", 0, 1, 0, 1, gap, False)
    for k in range(s.random.randint(2, 6)):
        for _ in range(200):
            center = (s.random.random(), s.random.random(), gap * s.random.uniform(0.1, 0.9))
            along = unit((s.random.gauss(0, 1), s.random.gauss(0, 1), s.random.gauss(0, 0.1)))
            across = unit(cross(along, [s.random.gauss(0, 1) for _ in range(3)]))
            length, width = s.size(0.1, 0.8), s.size(1e-3, 1e-2)
            t = [add(center, scale(-length / 2, along)), add(center, scale(length / 2, along)), add(center, scale(width, across))]
            if all(0.01 * gap < p[2] < 0.99 * gap for p in t) and not any(crossing(t, c) for _, c, _ in s.faces):
                s.triangle(f"needle{k}", *t, both=True)
                break


def hole(s):
    """A sheet with a hole of random place and size between two plates, as ../cases/hole.yml."""
    gap = s.size(0.02, 0.5)
    if s.random.random() < 0.5:
        s.triangle("floor", (0, 0, 0), (1, 0, 0), (0, 1, 0))
        s.triangle("ceil", (0, 0, gap), (0, 1, gap), (1, 0, gap))
    else:
        plate(s, "floor", 0, 1, 0, 1, 0, True)
        plate(s, "ceil", 0, 1, 0, 1, gap, False)
    width = s.size(1e-3, 0.3)
    depth = width * s.random.uniform(0.3, 3)
    x, y = s.random.uniform(0.05, 0.6), s.random.uniform(0.05, 0.6)
    grid_sheet(s, "sheet", [-0.5, x, x + width, 1.5], [-0.5, y, y + depth, 1.5], gap * s.random.uniform(0.2, 0.8), {(1, 1)})
    s.light("floor", 0, 1)
    s.light("ceil", 0, 0)
    s.light("sheet", 0, 0)


def slit(s):
    gap = s.size(0.05, 1)
    plate(s, "floor", 0, 1, 0, 1, 0, True)
    plate(s, "ceil", 0, 1, 0, 1, gap, False)
    width, z = s.size(1e-3, 0.1), gap * s.random.uniform(0.2, 0.8)
    x = s.random.uniform(0.1, 0.8)
    plate(s, "left", -0.3, x, -0.3, 1.3, z, True, both=True)
    plate(s, "right", x + width, 1.3, -0.3, 1.3, z, True, both=True)


def lamp_near_floor(s):
    plate(s, "floor", 0, 1, 0, 1, 0, True)
    size, distance = s.size(1e-3, 1), s.size(1e-3, 1)
    tilt = s.random.uniform(0, 0.9) * min(1, distance / size) if s.random.random() < 0.5 else 0
    x, y = s.random.uniform(0, 1), s.random.uniform(0, 1)
    a = (x, y, distance)
    b = (x, y + size, distance)
    c = (x + size, y, distance + tilt * size)
    s.triangle("lamp", a, b, c)
    if s.random.random() < 0.3:
        s.quad("lamp", c, b, (x + size, y + size, distance + tilt * size), (x + 1.5 * size, y + size / 2, distance + 1.5 * tilt * size))
    s.light("lamp", 0, s.size(1, 1000))
    s.light("floor", s.random.choice([0, 0.5]), 0)


def thermal_room(s, grey):
    s.box(ROOM, room_corners(1, 1, 1), inward=True)
    size, distance = s.size(0.01, 0.2), s.size(0.01, 0.5)
    x, y = s.random.uniform(0.2, 0.7), s.random.uniform(0.2, 0.7)
    turned = s.random.uniform(0, 6) if s.random.random() < 0.5 else 0
    s.box("body", upright((x, y), size, size, turned, distance, distance + size))
    emissivity = (lambda: s.random.uniform(0.2, 0.95)) if grey else (lambda: 1.0)
    for name in ROOM:
        if grey and s.random.random() < 0.15:
            s.heat(name, emissivity(), flux=0)
        else:
            s.heat(name, emissivity(), temperature=s.random.choice([300, 300, s.random.uniform(250, 500)]))
    if grey and s.random.random() < 0.3:
        s.heat("body", emissivity(), flux=s.size(100, 1e5))
    else:
        s.heat("body", emissivity(), temperature=s.random.uniform(500, 1500))
    s.closed = True


def body_black(s):
    thermal_room(s, False)


def body_grey(s):
    thermal_room(s, True)


def enclosure(s):
    """A closed room, several bands, unlit and black faces, a sheet in it."""
    s.bands = s.random.randint(1, 3)
    s.box(ROOM, room_corners(*(s.random.uniform(0.5, 1.5) for _ in range(3))), inward=True)
    if s.random.random() < 0.7:
        z, w = s.random.uniform(0.1, 0.4), s.random.uniform(0.05, 0.3)
        a, b = s.random.uniform(0.05, 0.15), s.random.uniform(0.05, 0.15)
        s.triangle("sheet", (a, b, z), (a + w, b, z), (a, b + w, z + s.random.uniform(-0.05, 0.05)), both=True)
    s.closed = True


KINDS = [soup, crossed, hover, stand, stand_uncut, sheets, needles, hole, slit, lamp_near_floor, body_black, body_grey, enclosure]
KINDS = {f.__name__: f for f in KINDS}


def make(kind, seed):
    s = Scene(kind, seed)
    KINDS[kind](s)
    s.light_up() if not s.thermal else None
    if s.random.random() < 0.5:
        s.turn()
    return s
