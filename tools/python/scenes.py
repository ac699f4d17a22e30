"""Make the OBJ scenes of inputs/ and of the benchmarks.

  cornell  the Cornell box as measured [mm], front open           inputs/cornell_box.obj
  street   two rows of gabled houses under a lid, the sky [m]     inputs/street_canyon.obj
  room     a furnished room, closed, about N triangles [m]        inputs/room.obj
  box      a closed cube of 12 n^2 facets, or two, one in the other [m]
  wedge    two triangles that share an edge, at an angle [m]      inputs/studies/stability/
  vertex   n triangles around a vertex, a cone; with a dent [m]   inputs/studies/stability/

Normals point into the air. All scenes conform: triangles share vertices and whole edges.
Surfaces are the usemtl names. Exit codes: 0 done, 2 usage, 3 a file cannot be written.
"""

import argparse
import json
import math
from pathlib import Path

from conform import conform
from polygons import Scene, refine, write_obj
from result import Problem, run

OPTIONS = ("triangles", "n", "inner", "angle", "faces", "dent")
TOLERANCE = 1e-9  # of the scene's size; coordinates are exact here


def block(scene: Scene, name: str, low, high, inwards: bool = False) -> None:
    """A box with normals outwards; names: one, or {side: name} with sides x- x+ y- y+ z- z+."""
    for axis in range(3):
        for far in (0, 1):
            corners = []
            for i, j in ((0, 0), (1, 0), (1, 1), (0, 1)):
                corner = [0.0, 0.0, 0.0]
                corner[axis] = (low, high)[far][axis]
                corner[(axis + 1) % 3] = (low, high)[i][(axis + 1) % 3]
                corner[(axis + 2) % 3] = (low, high)[j][(axis + 2) % 3]
                corners.append(corner)
            side = "xyz"[axis] + "-+"[far]
            called = name[side] if isinstance(name, dict) else name
            scene.add(called, corners if bool(far) != inwards else corners[::-1])


def cornell(options) -> Scene:
    data = json.loads((Path(__file__).parent / "cornell_box.json").read_text())
    scene = Scene()
    for key, quads in data["quads"].items():
        name = key.split("/")[0]
        for quad in quads:
            scene.add(name, quad)
        if name.endswith("block"):  # closed below: its footprint is cut out of the floor
            top = quads[0]
            scene.add(name, [(x, 0, z) for x, _, z in reversed(top)])
    return conform(scene, TOLERANCE)


def house(scene: Scene, x: float, y: float, width: float, depth: float, eaves: float, ridge: float):
    """A gabled house on the ground, its ridge along x; closed below."""
    a, b, c, d, m = x, x + width, y, y + depth, y + depth / 2
    for far, wall in ((0, c), (1, d)):
        face = [(a, wall, 0), (b, wall, 0), (b, wall, eaves), (a, wall, eaves)]
        scene.add("walls", face if not far else face[::-1])
        slope = [(a, wall, eaves), (b, wall, eaves), (b, m, ridge), (a, m, ridge)]
        scene.add("roofs", slope if not far else slope[::-1])
    for far, wall in ((0, a), (1, b)):
        gable = [(wall, c, 0), (wall, c, eaves), (wall, m, ridge), (wall, d, eaves), (wall, d, 0)]
        scene.add("walls", gable if not far else gable[::-1])
    scene.add("walls", [(a, c, 0), (a, d, 0), (b, d, 0), (b, c, 0)])


def street(options) -> Scene:
    scene = Scene()
    block(
        scene,
        {"z-": "ground", "z+": "sky"} | dict.fromkeys(("x-", "x+", "y-", "y+"), "sky"),
        (0, 0, 0),
        (60, 44, 30),
        inwards=True,
    )
    scene.add("street", [(0, 17, 0), (60, 17, 0), (60, 27, 0), (0, 27, 0)])
    for y in (5, 27):
        for k in range(3):
            house(scene, 6 + 17 * k, y, 14, 12, 6 + (k + y) % 3, 10 + (k + y) % 3)
    return conform(scene, TOLERANCE)


def chair(scene: Scene, x: float, y: float, back: int) -> None:
    """A chair of 0.44 m, its back towards +y (1) or -y (-1)."""
    side, leg, seat = 0.44, 0.04, 0.46
    for i in (x, x + side - leg):
        for j in (y, y + side - leg):
            block(scene, "chairs", (i, j, 0), (i + leg, j + leg, seat - 0.03))
    block(scene, "chairs", (x, y, seat - 0.03), (x + side, y + side, seat))
    j = y + side - 0.03 if back > 0 else y
    block(scene, "chairs", (x, j, seat), (x + side, j + 0.03, 0.9))


def furnished() -> Scene:
    scene = Scene()
    names = dict.fromkeys(("x-", "x+", "y-", "y+"), "walls") | {"z-": "floor", "z+": "ceiling"}
    block(scene, names, (0, 0, 0), (5, 4, 2.6), inwards=True)
    scene.add("window", [(0, 1.2, 0.9), (0, 2.8, 0.9), (0, 2.8, 2.1), (0, 1.2, 2.1)])
    scene.add("door", [(5, 0.4, 0), (5, 0.4, 2), (5, 1.3, 2), (5, 1.3, 0)])
    block(scene, "lamp", (2.1, 1.7, 2.5), (2.9, 2.3, 2.6))
    for x in (1.7, 3.24):  # table
        for y in (1.5, 2.44):
            block(scene, "table", (x, y, 0), (x + 0.06, y + 0.06, 0.71))
    block(scene, "table", (1.65, 1.45, 0.71), (3.35, 2.55, 0.75))
    for x in (1.9, 2.66):
        chair(scene, x, 0.9, -1)
        chair(scene, x, 2.66, 1)
    for x in (1.2, 2.97):  # shelf at the wall y = 4
        block(scene, "shelf", (x, 3.7, 0), (x + 0.03, 4, 1.9))
    for z in (0.1, 0.7, 1.3, 1.87):
        block(scene, "shelf", (1.23, 3.7, z), (2.97, 4, z + 0.03))
    return scene


def room(options) -> Scene:
    coarse = conform(furnished(), TOLERANCE)
    if options.triangles < len(coarse.faces):
        raise Problem(f"the room has at least {len(coarse.faces)} triangles", 2)
    return refine(coarse, options.triangles)


def box(options) -> Scene:
    """Every square of an n x n grid on each side, in two triangles."""
    n, scene = options.n, Scene()
    if n < 1:
        raise Problem("--n must be 1 or more", 2)
    number: dict[tuple[float, ...], int] = {}

    def corner(x: tuple[float, ...]) -> int:
        if x not in number:
            number[x] = len(scene.vertices)
            scene.vertices.append(x)
        return number[x]

    def cube(names: dict[str, str], low: float, width: float, inwards: bool) -> None:
        for side, name in names.items():
            axis, far = "xyz".index(side[0]), side[1] == "+"
            for k in range(n * n):
                square = []
                for i, j in ((0, 0), (1, 0), (1, 1), (0, 1)):
                    x = [0.0, 0.0, 0.0]
                    x[axis] = low + width * far
                    x[(axis + 1) % 3] = low + width * (k // n + i) / n
                    x[(axis + 2) % 3] = low + width * (k % n + j) / n
                    square.append(corner(tuple(x)))
                a, b, c, d = square if far != inwards else square[::-1]
                scene.faces += [([a, b, c], name), ([a, c, d], name)]

    walls = {
        "z-": "floor",
        "z+": "ceiling",
        "x-": "left",
        "x+": "right",
        "y-": "front",
        "y+": "back",
    }
    cube(walls, 0.0, 1.0, True)
    if options.inner:
        cube(dict.fromkeys(walls, "inner"), 0.375, 0.25, False)
    return scene


def wedge(options) -> Scene:
    if not 0 < options.angle < 360:
        raise Problem("--angle must lie between 0 and 360", 2)
    a, scene = math.radians(options.angle), Scene()
    scene.add("floor", [(0, 0, 0), (1, 0, 0), (0.5, 1, 0)])
    scene.add("wall", [(1, 0, 0), (0, 0, 0), (0.5, math.cos(a), math.sin(a))])
    return scene


def vertex(options) -> Scene:
    """Faces from the origin to a regular polygon at height 2; with a dent its first corner is
    pulled in beyond its neighbours, so that the edge there points inwards."""
    n, scene = options.faces, Scene()
    if n < 3 + options.dent:
        raise Problem(f"--faces must be {3 + options.dent} or more", 2)
    turn = 2 * math.pi / n
    rim = [(math.cos(turn * k), math.sin(turn * k), 2.0) for k in range(n)]
    if options.dent:
        rim[0] = (math.cos(turn) - 0.35, 0.0, 2.0)
    for k in range(n):
        scene.add("lit" if k == 0 else "dark", [(0, 0, 0), rim[k], rim[(k + 1) % n]])
    return scene


def main() -> None:
    parser = argparse.ArgumentParser(
        prog="tools/scene",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    kinds = parser.add_subparsers(dest="kind", required=True, metavar="KIND")
    for make in (cornell, street, room, box, wedge, vertex):
        kind = kinds.add_parser(make.__name__)
        kind.set_defaults(make=make)
        kind.add_argument("-o", "--output", metavar="FILE", required=True, help="OBJ file")
        if make is room:
            kind.add_argument("--triangles", type=int, default=1500, metavar="N", help="about")
        if make is box:
            kind.add_argument("--n", type=int, default=8, help="facets along an edge; default 8")
            kind.add_argument("--inner", action="store_true", help="a second cube inside")
        if make is wedge:
            kind.add_argument("--angle", type=float, default=90.0, help="degrees; default 90")
        if make is vertex:
            kind.add_argument("--faces", type=int, default=3, metavar="N", help="default 3")
            kind.add_argument("--dent", action="store_true", help="not convex: one edge inwards")
    options = parser.parse_args()
    scene = options.make(options)
    words = {key: getattr(options, key) for key in OPTIONS if key in options}
    shown = "".join(f" --{k}" if v is True else f" --{k} {v}" for k, v in words.items() if v)
    write_obj(scene, options.output, f"tools/scene {options.kind}{shown}")
    print(f"{options.output}: {len(scene.faces)} triangles")


run(main)
