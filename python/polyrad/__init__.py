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


def _doubles(a, shape):
    return np.ascontiguousarray(np.broadcast_to(np.asarray(a, dtype=np.float64), shape))


def _ints(a, shape):
    a = np.asarray(a)
    if a.size and (not np.issubdtype(a.dtype, np.integer) or np.abs(a).max() >= 2**31):
        raise TypeError("indices must be whole numbers below 2^31")
    return np.ascontiguousarray(np.broadcast_to(a, shape), dtype=np.intc)


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
        self._handle, self._raised = c.c_void_p(), None
        vertices = _doubles(vertices, np.shape(vertices))
        triangles = _ints(triangles, np.shape(triangles))
        for what, a in (("vertices", vertices), ("triangles", triangles)):
            if a.ndim != 2 or a.shape[1] != 3:
                raise ValueError(f"{what} must have the shape [n, 3]")
        m = len(triangles)
        shapes = [np.shape(a) for a in (rho, emission) if a is not None and not callable(a)]
        self.bands = bands or max([s[-1] for s in shapes if len(s) > 1], default=1)
        s = _Scene(n_vertex=len(vertices), vertex=_pointer(vertices), n_triangle=m, triangle=_pointer(triangles),
                   n_band=self.bands)
        if rho is not None:
            rho = self._optics(rho, m)
            s.rho = _pointer(rho)
        heat = {"emissivity": emissivity, "temperature": temperature, "flux": flux}
        heat = {name: _doubles(a, (m,)) for name, a in heat.items() if a is not None}
        for name, a in heat.items():
            setattr(s, name, _pointer(a))
        if emission is None:
            pass
        elif callable(emission):
            s.emission_at = self._callback = self._wrap(emission)
        elif np.ndim(emission) == 3:
            at_vertices = _doubles(emission, (m, 3, self.bands))
            s.vertex_emission = _pointer(at_vertices)
        else:
            constant = self._optics(emission, m)
            s.emission = _pointer(constant)
        self.n_surface, self.n_triangle = 1, m
        if surface is not None:
            surface = _ints(surface, (m,))
            self.n_surface = len(names) if names is not None else int(surface.max(initial=0)) + 1
            s.n_surface, s.surface = self.n_surface, _pointer(surface)
            if names is not None:
                s.surface_name = (c.c_char_p * len(names))(*(n.encode() for n in names))
        self._check(_lib.polyrad_create(c.byref(s), c.byref(self._handle)))

    def _optics(self, a, m):
        a = np.asarray(a, dtype=np.float64)
        return _doubles(a[:, None] if a.ndim == 1 else a, (m, self.bands))

    def _wrap(self, function):
        def call(x, triangle, weight, band, _):
            try:
                return float(function(np.array(x[:3]), triangle, np.array(weight[:3]), band))
            except BaseException as e:  # may not leave through C: raised by _check
                self._raised = self._raised or e
                return float("nan")
        return _EMISSION(call)

    def _check(self, status):
        raised, self._raised = self._raised, None
        if raised:
            raise raised
        if status:
            raise Error(status, _lib.polyrad_error_text(self._handle).decode(errors="replace"))

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
        self._check(_lib.polyrad_solve(self._handle, _Options(tolerance, memory_limit, threads)))
        return self.summary

    @property
    def summary(self):
        s = Summary()
        self._check(_lib.polyrad_get_summary(self._handle, s))
        return s

    def _values(self, function, triangle, at):
        at = np.asarray(at, dtype=np.float64).reshape(-1, 3)
        at, triangle = np.ascontiguousarray(at), _ints(triangle, (len(at),))
        u, h = np.empty((2, len(at), self.bands))
        self._check(function(self._handle, len(at), _pointer(triangle), _pointer(at), _pointer(u), _pointer(h)))
        return u, h

    def evaluate(self, triangle, weight):
        """Radiosity and irradiance, each [n, bands], at barycentric coordinates weight [n, 3]."""
        return self._values(_lib.polyrad_evaluate, triangle, weight)

    def evaluate_at(self, triangle, position):
        """The same at positions [n, 3] on their triangles."""
        return self._values(_lib.polyrad_evaluate_at, triangle, position)

    def surface_means(self):
        """Mean radiosity and irradiance, each [surfaces, bands]."""
        u, h = np.empty((2, self.n_surface, self.bands))
        self._check(_lib.polyrad_surface_means(self._handle, _pointer(u), _pointer(h)))
        return u, h

    def surface_heat(self):
        """Mean net flux [W/m2] and temperature [K], each [surfaces], of a scene with emissivities."""
        q, t = np.empty((2, self.n_surface))
        self._check(_lib.polyrad_surface_heat(self._handle, _pointer(q), _pointer(t)))
        return q, t

    def view_factors(self, tolerance=0):
        """[surfaces, surfaces]: the share of what leaves row s that arrives at column t.

        If the tolerance is not met, Error.best is the best matrix there is."""
        f = np.empty((self.n_surface, self.n_surface))
        try:
            self._check(_lib.polyrad_view_factors(self._handle, tolerance, _pointer(f)))
        except Error as e:
            e.best = f if e.status == 1 else None
            raise
        return f
