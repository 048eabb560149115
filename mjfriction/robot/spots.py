"""Spots of the stroke where friction differs: exact along a motion, and as waves that MuJoCo's law can represent."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from mjfriction.laws.law import Floats
from mjfriction.robot.table import Spot, Wave

# Period of the Fourier series, in widths of the spot: its periodic images lie beyond the stroke except for the
# narrowest spots.
APART = 120.0
LEAST_WAVE = 1e-4  # relative amplitude below which the series is cut off


def spots_along(spots: Sequence[Spot], position: Floats) -> Floats:
    """Return the sum of spots at positions (n,)."""
    out = np.zeros_like(position)
    for spot in spots:
        out += spot.coulomb * np.exp(-0.5 * np.square((position - spot.position) / spot.width))
    return out


def spot_slopes_along(spots: Sequence[Spot], position: Floats) -> Floats:
    """Return the derivative of the sum of spots with respect to position, at positions (n,)."""
    out = np.zeros_like(position)
    for spot in spots:
        out -= spots_along([spot], position) * (position - spot.position) / spot.width**2
    return out


def as_waves(spot: Spot) -> tuple[float, tuple[Wave, ...]]:
    """Return a spot as a level and waves: the Fourier series of spots repeated every 120 widths."""
    level = spot.coulomb * np.sqrt(2.0 * np.pi) / APART
    first = 2.0 * np.pi / (APART * spot.width)
    count = int(np.ceil(np.sqrt(-2.0 * np.log(LEAST_WAVE)) / (first * spot.width)))
    waves = []
    for k in range(1, count + 1):
        amplitude = 2.0 * level * np.exp(-0.5 * np.square(k * first * spot.width))
        phase = k * first * spot.position
        cosine, sine = float(amplitude * np.cos(phase)), float(amplitude * np.sin(phase))
        waves.append(Wave(wavenumber=k * first, cosine=cosine, sine=sine))
    return float(level), tuple(waves)
