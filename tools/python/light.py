"""From radiosity to what a screen shows: exposure, highlights, sRGB."""

import numpy as np

KNEE = 0.7  # up to here brightness is true; page.html has the same curve


def quantile(values: np.ndarray, weight: np.ndarray, part: float) -> float:
    """Below it lies this part of the weight."""
    order = np.argsort(values)
    total = np.cumsum(weight[order])
    return float(values[order][np.searchsorted(total, part * total[-1])])


def exposure(color: np.ndarray, weight: np.ndarray) -> float:
    """Brings the brightest tenth of what is seen to the knee; weight [n]: share of the picture."""
    bright = quantile(color.max(axis=1), weight, 0.9)
    bright = bright if bright > 0 else color.max(initial=0)
    return KNEE / bright if bright > 0 else 1.0


def rolled(light: np.ndarray) -> np.ndarray:
    """Linear light to 0..1, each channel alone, so that bright light goes over to white.

    x up to KNEE k, then k + (1 - k) (1 - exp(-(x - k) / (1 - k))).
    """
    over = np.maximum(light - KNEE, 0) / (1 - KNEE)
    return np.clip(light, 0, KNEE) - (1 - KNEE) * np.expm1(-over)


def srgb(light: np.ndarray) -> np.ndarray:
    """Linear light 0..1 to screen values 0..1 (IEC 61966-2-1)."""
    return np.where(light <= 0.0031308, 12.92 * light, 1.055 * light ** (1 / 2.4) - 0.055)


def linear(value: np.ndarray) -> np.ndarray:
    """The inverse of srgb."""
    return np.where(value <= 0.04045, value / 12.92, ((value + 0.055) / 1.055) ** 2.4)
