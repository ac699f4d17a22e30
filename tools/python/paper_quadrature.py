"""The paper's Table 3.1: points of the trapezoidal rule for int_0^1 eps / ((x-a)^2 + eps^2)^2 dx, plain
and after its transformation (3.33)."""

import numpy as np

MOST = 20  # 2^20 intervals; the paper prints ">20" beyond


def odd(z: float) -> int:
    """The smallest odd natural number that is >= z."""
    n = max(1, int(np.ceil(z)))
    return n if n % 2 else n + 1


def power_printed(a: float, eps: float) -> int:
    """q of (3.34) as it is printed."""
    off = np.hypot(eps, a) if a < 0 else np.hypot(eps, 1 - a) if a > 1 else eps
    return odd(np.log(off) / np.log(0.3))


def power_used(a: float, eps: float) -> int:
    """q that gives the table: 3 for a outside (0, 1)."""
    return power_printed(a, eps) if 0 < a < 1 else 3


def transform(a: float, q: int, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """x = t(y) of (3.33) with (3.35), and t'(y)."""
    low, high = (a, 1 - a) if 0 < a < 1 else (0, 1) if a <= 0 else (1, 0)
    alpha_2 = low ** (1 / q)
    z = (high ** (1 / q) + alpha_2) * y - alpha_2
    start = a if 0 < a < 1 else 0 if a <= 0 else 1
    return z**q + start, q * z ** (q - 1) * (high ** (1 / q) + alpha_2)


def sums(a: float, eps: float, q: int | None):
    """T_0, T_1, ..: trapezoidal sums with 2^K intervals, each from the one before; q None: plain."""

    def total(y: np.ndarray) -> float:
        x, slope = (y, np.ones_like(y)) if q is None else transform(a, q, y)
        return float((slope * eps / ((x - a) ** 2 + eps**2) ** 2).sum())

    value = 0.5 * (total(np.zeros(1)) + total(np.ones(1)))
    yield value
    for k in range(1, MOST + 1):
        n = 2 ** (k - 1)
        value = 0.5 * (value + total((np.arange(n) + 0.5) / n) / n)
        yield value


def exact(a: float, eps: float) -> float:
    """The integral: closed form with a inside, outside (where it cancels) 200 Gauss points."""
    if 0 <= a <= 1:
        return float(
            sum(s / (2 * eps * (s * s + eps**2)) + np.arctan(s / eps) / (2 * eps**2) for s in (a, 1 - a))
        )
    x, w = np.polynomial.legendre.leggauss(200)
    x = (x + 1) / 2
    return float((w / 2 * eps / ((x - a) ** 2 + eps**2) ** 2).sum())


def by_doubling(a: float, eps: float, q: int | None) -> int:
    """One more than the least K with |T_K - T_(K-1)| < 1e-8 T_K: what the printed numbers are. A program
    that doubles its points stops there without knowing the integral."""
    before = None
    for k, value in enumerate(sums(a, eps, q)):
        if before is not None and abs(value - before) < 1e-8 * value:
            return k + 1
        before = value
    return MOST + 1


def by_definition(a: float, eps: float, q: int | None) -> int:
    """(3.36), (3.37): the least natural K with |I - T_K| < 1e-8 I."""
    true = exact(a, eps)
    for k, value in enumerate(sums(a, eps, q)):
        if k > 0 and abs(value - true) < 1e-8 * true:
            return k
    return MOST + 1
