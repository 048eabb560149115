"""Edges along the stroke, beyond which friction differs: exact along a motion, and as waves that MuJoCo's law can
represent.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.special import ndtr

from mjfriction.laws.law import Floats
from mjfriction.robot.spots import spots_along
from mjfriction.robot.table import Edge, Spot, Wave

# Period of the Fourier series, in widths of the edge: within half of it on both sides the series is the edge.
APART = 480.0
LEAST_WAVE = 1e-4  # relative amplitude below which the series is cut off


def edges_along(edges: Sequence[Edge], position: Floats) -> Floats:
    """Return the sum of edges at positions (n,)."""
    out = np.zeros_like(position)
    for edge in edges:
        out += edge.coulomb * ndtr(_sign(edge) * (position - edge.position) / edge.width)
    return out


def edge_slopes_along(edges: Sequence[Edge], position: Floats) -> Floats:
    """Return the derivative of the sum of edges with respect to position, at positions (n,)."""
    return spots_along([_slope(edge) for edge in edges], position)


def edge_as_waves(edge: Edge) -> tuple[float, tuple[Wave, ...]]:
    """Return an edge as a level and waves: the Fourier series of edges up and down in turn, one every 240 widths."""
    first, waves = 2.0 * np.pi / (APART * edge.width), []
    for k in range(1, int(APART), 2):
        relative = 2.0 / (np.pi * k) * np.exp(-0.5 * np.square(k * first * edge.width))
        if relative < LEAST_WAVE:
            break
        amplitude = _sign(edge) * edge.coulomb * relative
        phase = k * first * edge.position
        cosine, sine = float(-amplitude * np.sin(phase)), float(amplitude * np.cos(phase))
        waves.append(Wave(wavenumber=k * first, cosine=cosine, sine=sine))
    return 0.5 * edge.coulomb, tuple(waves)


def _sign(edge: Edge) -> float:
    return 1.0 if edge.side == "above" else -1.0


def _slope(edge: Edge) -> Spot:
    height = _sign(edge) * edge.coulomb / (np.sqrt(2.0 * np.pi) * edge.width)
    return Spot(position=edge.position, width=edge.width, coulomb=float(height))
