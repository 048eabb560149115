"""A mass on a spring whose foot is moved: how far it lags behind."""

from __future__ import annotations

import functools
from collections.abc import Callable
from typing import cast

import numba
import numpy as np
from numba import types

from mjfriction.laws.law import Floats


def ringing(aim: Floats, frequency: Floats, damping: float, step: float, finer: int = 1) -> Floats:
    """Return where it is, (n,), that swings about a place ``aim`` (n,) at a ``frequency`` (n,) rad/s.

    s̈ = ω²·(aim − s) − 2·``damping``·ω·ṡ, by steps of ``step`` s at constant average acceleration (Newmark, J. Eng.
    Mech. 85, 1959: β = 1/4, γ = 1/2), aim and frequency being straight between what is given, every ``finer`` steps; it
    begins at rest at its aim.
    """
    return _compiled()(np.ascontiguousarray(aim), np.ascontiguousarray(frequency), damping, step, finer)


@functools.cache
def _compiled() -> Callable[[Floats, Floats, float, float, int], Floats]:
    array, number = types.float64[::1], types.float64
    signature = array(array, array, number, number, types.int64)
    return cast(Callable[[Floats, Floats, float, float, int], Floats], numba.njit(signature, cache=True)(_along))


def _along(aim: Floats, frequency: Floats, damping: float, step: float, finer: int) -> Floats:
    out = np.empty_like(aim)
    place, speed, pull = aim[0], 0.0, 0.0
    out[0] = place
    for k in range(1, aim.size):
        for part in range(1, finer + 1):
            share = part / finer
            goal = aim[k - 1] + share * (aim[k] - aim[k - 1])
            omega = frequency[k - 1] + share * (frequency[k] - frequency[k - 1])
            coasted = place + step * speed + 0.25 * step * step * pull
            drifted = speed + 0.5 * step * pull
            after = omega * omega * (goal - coasted) - 2.0 * damping * omega * drifted
            after /= 1.0 + damping * omega * step + 0.25 * (omega * step) ** 2
            place = coasted + 0.25 * step * step * after
            speed = drifted + 0.5 * step * after
            pull = after
        out[k] = place
    return out
