"""Radiosity of scenes of triangles with a stated error bound: libpolyrad with numpy arrays.

    import polyrad
    scene = polyrad.Scene(vertices, triangles, rho=0.5, emission=lambda x, triangle, weight, band: x[0])
    scene.solve(tolerance=1e-4)
    u, h = scene.evaluate_at(triangle, position)

Shapes, units and meanings are those of polyrad.h. The library is looked for at POLYRAD_LIBRARY, then
where the system has its libraries.
"""

import ctypes as c
import ctypes.util
import operator
import os

import numpy as np

__all__ = ["Error", "Scene", "version"]

_double_p, _int_p = c.POINTER(c.c_double), c.POINTER(c.c_int)
_EMISSION = c.CFUNCTYPE(c.c_double, _double_p, c.c_int, _double_p, c.c_int, c.c_void_p)


class _Scene(c.Structure):
    _fields_ = [("n_vertex", c.c_int), ("vertex", _double_p), ("n_triangle", c.c_int), ("triangle", _int_p),
                ("n_surface", c.c_int), ("surface", _int_p), ("surface_name", c.POINTER(c.c_char_p)),
                ("n_band", c.c_int), ("rho", _double_p), ("emission", _double_p),
                ("vertex_emission", _double_p), ("emission_at", _EMISSION), ("user", c.c_void_p),
                ("emissivity", _double_p), ("temperature", _double_p), ("flux", _double_p)]


class _Options(c.Structure):
    _fields_ = [("tolerance", c.c_double), ("memory_limit", c.c_double), ("threads", c.c_int)]


class Summary(c.Structure):
    """What a solution says of itself; see struct polyrad_summary."""
    _fields_ = [("unknowns", c.c_longlong), ("elements", c.c_int), ("levels", c.c_int),
                ("error_bound", c.c_double), ("error_bound_limit", c.c_double),
                ("relative_bound", c.c_double), ("residual", c.c_double), ("converged", c.c_int)]


def _load():
    name = os.environ.get("POLYRAD_LIBRARY") or ctypes.util.find_library("polyrad") or "libpolyrad.so.0"
    try:
        lib = c.CDLL(name)
    except OSError as e:
        raise ImportError(f"libpolyrad cannot be loaded ({e}); install polyrad, or set POLYRAD_LIBRARY "
                          "to the path of libpolyrad.so") from None
    p = c.c_void_p
    for function, arguments in {
            "create": [c.POINTER(_Scene), c.POINTER(p)], "solve": [p, c.POINTER(_Options)],
            "get_summary": [p, c.POINTER(Summary)], "surface_means": [p, _double_p, _double_p],
            "surface_errors": [p, _double_p, _double_p],
            "surface_heat": [p, _double_p, _double_p],
            "evaluate": [p, c.c_int, _int_p, _double_p, _double_p, _double_p],
            "evaluate_at": [p, c.c_int, _int_p, _double_p, _double_p, _double_p],
            "view_factors": [p, c.c_double, _double_p], "free": [p], "error_text": [p],
            "warning": [p, c.c_int], "version": []}.items():
        f = getattr(lib, "polyrad_" + function)
        f.argtypes = arguments
        f.restype = c.c_char_p if function in ("error_text", "warning", "version") else c.c_int
    lib.polyrad_free.restype = None
    return lib


_lib = _load()


def version():
    return _lib.polyrad_version().decode()


class Error(RuntimeError):
    """status: 1 numeric, 2 input, 3 memory; the sentence is that of polyrad_error_text."""

    def __init__(self, status, text):
        super().__init__(text)
        self.status = status
        self.best = None


MAX_BAND, MAX_INT = 16, 2**31 - 1


def _numbers(what, a):
    a = np.asarray(a)
    if a.dtype.kind not in "biuf" and a.size:
        raise TypeError(f"{what} must be real numbers, not of the type {a.dtype}")
    return a


def _fit(what, a, shape):
    """The array as a view of this shape, nothing copied yet."""
    try:
        return np.broadcast_to(a, shape)
    except ValueError:
        raise ValueError(f"{what} has the shape {list(a.shape)}; give one that fits {list(shape)}") from None


def _doubles(what, a, shape):
    return np.ascontiguousarray(_fit(what, _numbers(what, a), shape), dtype=np.float64)


def _ints(what, a, shape):
    a = np.asarray(a)
    if a.size and a.dtype.kind not in "iu":
        raise TypeError(f"{what} must be whole numbers: indices, not of the type {a.dtype}")
    if a.size and not -MAX_INT <= int(a.min()) <= int(a.max()) <= MAX_INT:
        raise ValueError(f"{what} has indices from {a.min()} to {a.max()}; indices are at most 2^31 - 1")
    return np.ascontiguousarray(_fit(what, a, shape), dtype=np.intc)


def _rows_of_three(what, a):
    """Nothing is copied before it is known to fit."""
    a = _numbers(what, a)
    if a.ndim != 2 or a.shape[1] != 3 or a.shape[0] > MAX_INT:
        raise ValueError(f"{what} must have the shape [n, 3], but has {list(a.shape)}")
    return a


def _whole(what, n, least, most):
    n = operator.index(n)
    if not least <= n <= most:
        raise ValueError(f"{what} is {n}; give a whole number from {least} to {most}")
    return n


def _count_bands(bands, **optics):
    """Bands as given, or as the last axis of rho or emission has them."""
    if bands is not None:
        return _whole("bands", bands, 1, MAX_BAND)
    n = 1
    for what, a in optics.items():
        shape = () if a is None or callable(a) else np.shape(a)
        if len(shape) > 1:
            n = max(n, _whole(f"the length of the last axis of {what}, the bands,", shape[-1], 1, MAX_BAND))
    return n


def _encode(names):
    if isinstance(names, (str, bytes)):
        raise TypeError("names must be a list of texts, one a surface")
    names = [n.encode() if isinstance(n, str) else n for n in names]
    for n in names:
        if not isinstance(n, bytes) or b"\0" in n:
            raise TypeError(f"{n!r} is no name of a surface: names are texts without zero characters")
    return names


def _pointer(a):
    return a.ctypes.data_as(_int_p if a.dtype == np.intc else _double_p)


class Scene:
    """A scene and, once solved, its solution.

    vertices [n, 3], triangles [m, 3]; surface [m] or None; names of the surfaces or None;
    rho a number, [m, 1] or [m, bands]; emission the same, or vertex values [m, 3, bands], or a function
    E(x [3], triangle, weight [3], band); bands if it is not to be seen from rho or emission.
    Heat radiation: instead of rho and emission, emissivity and temperature [K] or flux [W/m2], numbers
    or [m]; NaN in temperature where flux is given, and the other way round.
    """

    def __init__(self, vertices, triangles, rho=None, emission=None, surface=None, names=None, bands=None,
                 emissivity=None, temperature=None, flux=None):
        self._handle, self._raised, self._busy = c.c_void_p(), None, False
        vertices, triangles = _rows_of_three("vertices", vertices), _rows_of_three("triangles", triangles)
        vertices = _doubles("vertices", vertices, vertices.shape)
        triangles = _ints("triangles", triangles, triangles.shape)
        m = len(triangles)
        self.bands = _count_bands(bands, rho=rho, emission=emission)
        s = _Scene(n_vertex=len(vertices), vertex=_pointer(vertices), n_triangle=m, triangle=_pointer(triangles),
                   n_band=self.bands)
        if rho is not None:
            rho = self._optics("rho", rho, m)
            s.rho = _pointer(rho)
        heat = {"emissivity": emissivity, "temperature": temperature, "flux": flux}
        heat = {name: _doubles(name, a, (m,)) for name, a in heat.items() if a is not None}
        for name, a in heat.items():
            setattr(s, name, _pointer(a))
        if emission is None:
            pass
        elif callable(emission):
            s.emission_at = self._callback = self._wrap(emission)
        elif np.ndim(emission) == 3:
            at_vertices = _doubles("emission", emission, (m, 3, self.bands))
            s.vertex_emission = _pointer(at_vertices)
        else:
            constant = self._optics("emission", emission, m)
            s.emission = _pointer(constant)
        self.n_surface, self.n_triangle = 1, m
        if surface is None and names is not None:
            raise ValueError("names are given, but not which surface each triangle belongs to; give surface too")
        if surface is not None:
            surface = _ints("surface", surface, (m,))
            names = None if names is None else _encode(names)
            self.n_surface = int(surface.max(initial=0)) + 1 if names is None else len(names)
            if self.n_surface > m:
                raise ValueError(f"there are {self.n_surface} surfaces, but only {m} triangles; give every surface one, "
                                 "and indices from 0 on")
            s.n_surface, s.surface = self.n_surface, _pointer(surface)
            if names is not None:
                s.surface_name = (c.c_char_p * len(names))(*names)
        self._call(_lib.polyrad_create, c.byref(s), c.byref(self._handle), first=())

    def _optics(self, what, a, m):
        a = _numbers(what, a)
        return _doubles(what, a[:, None] if a.ndim == 1 else a, (m, self.bands))

    def _wrap(self, function):
        def call(x, triangle, weight, band, _):
            try:
                return float(function(np.array(x[:3]), triangle, np.array(weight[:3]), band))
            except BaseException as e:  # may not leave through C: raised by _call
                self._raised = self._raised or e
                return float("nan")
        return _EMISSION(call)

    def _call(self, function, *arguments, first=None):
        """One call of the library; a second one before it ends would find the handle at work."""
        if self._busy:
            raise RuntimeError("this scene is at work: emission may not call it, nor may two threads at a time")
        self._busy = True
        try:
            status = function(*((self._handle,) if first is None else first), *arguments)
        finally:
            self._busy = False
        raised, self._raised = self._raised, None
        if raised:
            raise raised
        if status:
            raise Error(status, _lib.polyrad_error_text(self._handle).decode(errors="replace"))

    def __reduce_ex__(self, _):
        raise TypeError("a Scene cannot be copied or pickled; make another one")

    def __del__(self):
        if getattr(self, "_handle", None):
            _lib.polyrad_free(self._handle)
            self._handle = None

    @property
    def warnings(self):
        texts = (_lib.polyrad_warning(self._handle, i) for i in range(2**31 - 1))
        return [t.decode(errors="replace") for t in iter(lambda: next(texts), None)]

    def solve(self, tolerance=0, memory_limit=0, threads=0):
        """Solve; returns the summary. Error with status 1 if the tolerance was not reached."""
        threads = _whole("threads", threads, 0, 4096)
        self._call(_lib.polyrad_solve, _Options(float(tolerance), float(memory_limit), threads))
        return self.summary

    @property
    def summary(self):
        s = Summary()
        self._call(_lib.polyrad_get_summary, s)
        return s

    def _values(self, what, function, triangle, at):
        at = _numbers(what, at)
        at = _rows_of_three(what, at.reshape(-1, 3) if at.ndim == 1 and at.size in (0, 3) else at)
        at, triangle = _doubles(what, at, at.shape), _ints("triangle", triangle, (len(at),))
        u, h = np.empty((2, len(at), self.bands))
        self._call(function, len(at), _pointer(triangle), _pointer(at), _pointer(u), _pointer(h))
        return u, h

    def evaluate(self, triangle, weight):
        """Radiosity and irradiance, each [n, bands], at barycentric coordinates weight [n, 3]."""
        return self._values("weight", _lib.polyrad_evaluate, triangle, weight)

    def evaluate_at(self, triangle, position):
        """The same at positions [n, 3] on their triangles."""
        return self._values("position", _lib.polyrad_evaluate_at, triangle, position)

    def surface_means(self):
        """Mean radiosity and irradiance, each [surfaces, bands]."""
        u, h = np.empty((2, self.n_surface, self.bands))
        self._call(_lib.polyrad_surface_means, _pointer(u), _pointer(h))
        return u, h

    def surface_errors(self):
        """Bounds of the errors of surface_means(), each [surfaces, bands]; NaN without a tolerance."""
        u, h = np.empty((2, self.n_surface, self.bands))
        self._call(_lib.polyrad_surface_errors, _pointer(u), _pointer(h))
        return u, h

    def surface_heat(self):
        """Mean net flux [W/m2] and temperature [K], each [surfaces], of a scene with emissivities."""
        q, t = np.empty((2, self.n_surface))
        self._call(_lib.polyrad_surface_heat, _pointer(q), _pointer(t))
        return q, t

    def view_factors(self, tolerance=0):
        """[surfaces, surfaces]: the share of what leaves row s that arrives at column t.

        If the tolerance is not met, Error.best is the best matrix there is."""
        f = np.empty((self.n_surface, self.n_surface))
        try:
            self._call(_lib.polyrad_view_factors, float(tolerance), _pointer(f))
        except Error as e:
            e.best = f if e.status == 1 else None
            raise
        return f
