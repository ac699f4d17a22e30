"""Convert STL, PLY, Gmsh, VTK and VTU surfaces, or OBJ, to OBJ scenes of polyrad.

Names of surfaces: Gmsh's physical groups; else the integer cell data that --surfaces names, or the
first of surface, material, gmsh:geometrical, medit:ref; else the file's name. Each becomes a usemtl
name. Volume cells, lines and points are left out; of curved cells the corners are kept.

--conform cuts faces where others touch them, so that all triangles share vertices and whole edges;
of faces that overlap in one plane, opposite ones lose both overlapped parts (a block on the floor,
if it is closed below), and of equal ones the smaller, or later, stays (a lamp in the ceiling).
"""

import argparse
import contextlib
import io
from pathlib import Path

import meshio
import numpy as np

from conform import conform
from polygons import Scene, check, read_obj, write_obj
from result import Problem, run

CORNERS = {"triangle": 3, "triangle6": 3, "triangle7": 3, "quad": 4, "quad8": 4, "quad9": 4}
NAMING = ("gmsh:physical", "surface", "material", "gmsh:geometrical", "medit:ref")


def read_mesh(path: str) -> meshio.Mesh:
    heard = io.StringIO()
    try:
        with contextlib.redirect_stdout(heard), contextlib.redirect_stderr(heard):
            return meshio.read(path)
    except FileNotFoundError:
        raise Problem(f"there is no file {path}") from None
    except OSError as error:
        raise Problem(f"{path} cannot be read: {error.strerror or error}") from None
    except (Exception, SystemExit) as error:  # meshio fails in many ways on files that are damaged
        reason = " ".join(f"{error} {heard.getvalue()}".split())[:160]
        formats = "STL, PLY, MSH, VTK, VTU or OBJ"
        raise Problem(f"{path} is no {formats} file that meshio can read ({reason})") from None


def tags_of(
    mesh: meshio.Mesh, wanted: str | None, path: str
) -> tuple[str, list[np.ndarray] | None]:
    """The integer cell data that names surfaces, one array for each block of cells."""
    if wanted and wanted not in mesh.cell_data:
        there = ", ".join(mesh.cell_data) or "none"
        raise Problem(f"{path} has no cell data '{wanted}'; there are: {there}", 2)
    key = wanted or next((key for key in NAMING if key in mesh.cell_data), None)
    if key is None:
        return "", None
    arrays = [np.asarray(block) for block in mesh.cell_data[key]]
    if any(a.ndim != 1 or (a.size and not np.equal(np.mod(a, 1), 0).all()) for a in arrays):
        raise Problem(f"{path}: cell data '{key}' is not one whole number per cell", 2)
    return key, [a.astype(int) for a in arrays]


def clean(name: str) -> str:
    """A name that an OBJ line can hold."""
    printable = "".join(c if c.isprintable() else "_" for c in name).strip()
    return printable.replace("#", "_").rstrip("\\") or "unnamed"


def scene_of(mesh: meshio.Mesh, path: str, wanted: str | None) -> Scene:
    key, tags = tags_of(mesh, wanted, path)
    known = {int(tag): name for name, (tag, dim) in mesh.field_data.items() if dim == 2}
    points = np.asarray(mesh.points, float)
    if points.ndim != 2 or points.shape[1] not in (2, 3):
        raise Problem(f"{path} has points without three coordinates")
    points = np.pad(points, ((0, 0), (0, 3 - points.shape[1])))
    scene = Scene([tuple(x) for x in points.tolist()])
    other = set()
    for k, block in enumerate(mesh.cells):
        n = CORNERS.get(block.type, None if block.type != "polygon" else np.shape(block.data)[1])
        if n is None:
            other.add(block.type)
            continue
        for i, corners in enumerate(np.asarray(block.data)[:, :n].tolist()):
            name = Path(path).stem
            if tags is not None:
                tag = int(tags[k][i])
                name = known.get(tag, f"{key.removeprefix('gmsh:')}_{tag}")
            scene.faces.append((corners, clean(name)))
    if not scene.faces and other:
        raise Problem(
            f"{path} holds no surface, only {', '.join(sorted(other))}; export its surface"
        )
    check(scene, path)
    return scene


def main() -> None:
    parser = argparse.ArgumentParser(
        prog="tools/convert",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("file", metavar="FILE", help=".stl, .ply, .msh, .vtk, .vtu or .obj")
    parser.add_argument("-o", "--output", metavar="OBJ", help="default: FILE with .obj")
    parser.add_argument("--surfaces", metavar="DATA", help="cell data that names the surfaces")
    parser.add_argument("--conform", action="store_true", help="cut faces where others touch them")
    parser.add_argument(
        "--tolerance",
        type=float,
        default=1e-7,
        metavar="X",
        help="of --conform: closer is touching; of the scene's diameter, default 1e-7",
    )
    options = parser.parse_args()
    output = options.output or str(Path(options.file).with_suffix(".obj"))
    if Path(output).resolve() == Path(options.file).resolve():
        raise Problem(f"{output} would be overwritten; give another name with -o", 2)
    if not 1e-12 <= options.tolerance <= 1e-2:
        raise Problem("--tolerance must be from 1e-12 to 1e-2", 2)
    is_obj = Path(options.file).suffix.lower() == ".obj"
    if is_obj and options.surfaces:
        raise Problem("--surfaces is for cell data; an OBJ file has usemtl, g and o", 2)
    if is_obj:
        scene = read_obj(options.file)
    else:
        scene = scene_of(read_mesh(options.file), options.file, options.surfaces)
    if options.conform:
        scene = conform(scene, options.tolerance)
    names = list(dict.fromkeys(name for _, name in scene.faces))
    write_obj(scene, output, f"tools/convert {Path(options.file).name}")
    print(f"{output}: {len(scene.faces)} faces; surfaces {', '.join(names)}")


run(main)
