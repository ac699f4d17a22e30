"""Triangles and lines to pixels: VTK, on EGL, so that no display is needed."""

import os

import numpy as np
import vtkmodules.vtkRenderingOpenGL2  # noqa: F401 - brings what the classes below are made of
from vtkmodules.util import numpy_support as arrays
from vtkmodules.vtkCommonCore import (
    VTK_UNSIGNED_CHAR,
    vtkFloatArray,
    vtkLogger,
    vtkPoints,
    vtkUnsignedCharArray,
)
from vtkmodules.vtkCommonDataModel import vtkCellArray, vtkPolyData
from vtkmodules.vtkRenderingCore import vtkActor, vtkPolyDataMapper, vtkRenderer, vtkRenderWindow

from camera import Camera
from light import linear, srgb
from result import Problem

LARGEST = 8192  # pixels in one direction that a window of Mesa can have
INK = (0.38, 0.38, 0.38)  # shows on dark and on bright


def cell_array(cells: np.ndarray) -> vtkCellArray:
    made = vtkCellArray()
    offsets = np.arange(0, cells.size + 1, cells.shape[1])
    made.SetData(
        arrays.numpy_to_vtkIdTypeArray(offsets, deep=True),
        arrays.numpy_to_vtkIdTypeArray(np.ascontiguousarray(cells).ravel(), deep=True),
    )
    return made


def poly_data(point: np.ndarray, middle: np.ndarray) -> vtkPolyData:
    """Points relative to the scene's middle, since graphics count in single precision."""
    points = vtkPoints()
    points.SetData(arrays.numpy_to_vtk(np.ascontiguousarray(point - middle, np.float32), deep=True))
    made = vtkPolyData()
    made.SetPoints(points)
    return made


def actor_of(data: vtkPolyData) -> vtkActor:
    """As it is, without shading; lines that lie on surfaces are in front of them."""
    mapper = vtkPolyDataMapper()
    mapper.SetInputData(data)
    mapper.SetResolveCoincidentTopologyToPolygonOffset()
    made = vtkActor()
    made.SetMapper(mapper)
    made.GetProperty().LightingOff()
    return made


def surface_actor(point, face, color, middle) -> vtkActor:
    """Triangles with a colour [., 3] of 0..1 at each point."""
    data = poly_data(point, middle)
    data.SetPolys(cell_array(face))
    bytes_ = np.ascontiguousarray(np.rint(255 * np.clip(color, 0, 1)), np.uint8)
    scalars = arrays.numpy_to_vtk(bytes_, deep=True, array_type=VTK_UNSIGNED_CHAR)
    data.GetPointData().SetScalars(scalars)
    return actor_of(data)


def line_actor(lines: np.ndarray, width: float, middle) -> vtkActor:
    data = poly_data(lines.reshape(-1, 3), middle)
    data.SetLines(cell_array(np.arange(2 * len(lines)).reshape(-1, 2)))
    made = actor_of(data)
    made.GetProperty().SetColor(*INK)
    made.GetProperty().SetLineWidth(width)
    return made


def aim(renderer: vtkRenderer, camera: Camera, middle: np.ndarray, size: tuple[int, int]) -> None:
    eye = renderer.GetActiveCamera()
    eye.SetPosition(*(camera.eye - middle))
    eye.SetFocalPoint(*(camera.to - middle))
    eye.SetViewUp(*camera.up)
    eye.SetUseHorizontalViewAngle(size[0] < size[1])
    eye.SetViewAngle(camera.angle)
    renderer.ResetCameraClippingRange()


def pixels(renderer: vtkRenderer, width: int, height: int) -> np.ndarray:
    """What the renderer shows, [height, width, 3] bytes, the upper row first."""
    # A DISPLAY that is set need not work: always EGL. Mesa's warnings are no news to the user.
    os.environ["VTK_DEFAULT_OPENGL_WINDOW"] = "vtkEGLRenderWindow"
    os.environ.setdefault("EGL_LOG_LEVEL", "fatal")
    window = vtkRenderWindow()
    window.SetOffScreenRendering(1)
    window.SetMultiSamples(0)
    window.SetSize(width, height)
    window.AddRenderer(renderer)
    window.Render()
    if not window.SupportsOpenGL() or tuple(window.GetActualSize()) != (width, height):
        raise Problem("VTK cannot draw here: OpenGL by EGL is missing (libegl1, libgl1-mesa-dri)")
    data = vtkUnsignedCharArray()
    window.GetPixelData(0, 0, width - 1, height - 1, 0, data, 0)
    depth = vtkFloatArray()
    window.GetZbufferData(0, 0, width - 1, height - 1, depth)
    shown = arrays.vtk_to_numpy(data).reshape(height, width, 3).copy()
    close_gaps(shown, arrays.vtk_to_numpy(depth).reshape(height, width) < 1)
    window.Finalize()
    return shown[::-1]


def close_gaps(shown: np.ndarray, covered: np.ndarray) -> None:
    """Pixels [h, w, 3] without a surface, between two that have one, get the colour of the first.

    Where a long side of a cell meets several short ones, single pixels may fall between them.
    """
    for image, full in ((shown, covered), (shown.swapaxes(0, 1), covered.T)):
        row, column = np.nonzero(~full[1:-1] & full[:-2] & full[2:])
        image[row + 1, column] = image[row, column]


def draw(point, face, color, lines, camera: Camera, size, background) -> np.ndarray:
    """A picture [height, width, 3] of 0..1, each pixel the mean light of up to 3 x 3."""
    vtkLogger.SetStderrVerbosity(vtkLogger.VERBOSITY_OFF)
    fine = max(1, min(3, LARGEST // max(size)))
    middle = point.mean(axis=0)
    renderer = vtkRenderer()
    renderer.SetBackground(*background)
    renderer.AddActor(surface_actor(point, face, color, middle))
    if len(lines):
        renderer.AddActor(line_actor(lines, 0.8 * fine, middle))
    aim(renderer, camera, middle, size)
    width, height = size
    shown = pixels(renderer, fine * width, fine * height)
    light = linear(np.arange(256) / 255)[shown].reshape(height, fine, width, fine, 3)
    return srgb(light.mean(axis=(1, 3)))
