"""Masses on springs whose bases are moved: where they are as they lag behind."""

from __future__ import annotations

import functools
from collections.abc import Callable
from typing import cast

import numba
import numpy as np
from numba import types

from mjfriction.laws.law import Floats


def ringing(aim: Floats, frequency: Floats, damping: float, step: float, finer: int = 1) -> Floats:
    """Return positions of masses that oscillate about ``aim`` at a ``frequency`` in rad/s, all (n,) or (n, k).

    s̈ = ω²·(aim − s) − 2·``damping``·ω·ṡ, by steps of ``step`` s at constant average acceleration (Newmark, J. Eng.
    Mech. 85, 1959: β = 1/4, γ = 1/2).  ``aim`` and ``frequency`` are given every ``finer`` steps and are linear in
    between.  The masses begin at rest at their aims.
    """
    aims, frequencies = (np.ascontiguousarray(own.reshape(own.shape[0], -1)) for own in (aim, frequency))
    return _compiled()(aims, frequencies, damping, step, finer).reshape(aim.shape)


@functools.cache
def _compiled() -> Callable[[Floats, Floats, float, float, int], Floats]:
    # The error model of numpy divides without a check for zero, so that the loop over masses can be vectorised.
    array, number = types.float64[:, ::1], types.float64
    signature = array(array, array, number, number, types.int64)
    compiled = numba.njit(signature, cache=True, error_model="numpy")(_along)
    return cast(Callable[[Floats, Floats, float, float, int], Floats], compiled)


def _along(aim: Floats, frequency: Floats, damping: float, step: float, finer: int) -> Floats:
    out = np.empty_like(aim)
    place = aim[0].copy()
    speed, pull = np.zeros_like(place), np.zeros_like(place)
    out[0] = place
    for k in range(1, aim.shape[0]):
        for part in range(1, finer + 1):
            share = part / finer
            for i in range(place.size):
                goal = aim[k - 1, i] + share * (aim[k, i] - aim[k - 1, i])
                omega = frequency[k - 1, i] + share * (frequency[k, i] - frequency[k - 1, i])
                coasted = place[i] + step * speed[i] + 0.25 * step * step * pull[i]
                drifted = speed[i] + 0.5 * step * pull[i]
                after = omega * omega * (goal - coasted) - 2.0 * damping * omega * drifted
                after /= 1.0 + damping * omega * step + 0.25 * (omega * step) ** 2
                place[i] = coasted + 0.25 * step * step * after
                speed[i] = drifted + 0.5 * step * after
                pull[i] = after
        out[k] = place
    return out
