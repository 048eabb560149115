"""Masses that move on their own between springy flanks, such as links in the play of a gear that gives."""

from __future__ import annotations

import functools
from collections.abc import Callable
from typing import cast

import numba
import numpy as np
from numba import types

from mjfriction.laws.law import Floats


def between_flanks(aim: Floats, frequency: Floats, half: Floats, damping: float, step: float, finer: int = 1) -> Floats:
    """Return positions of masses that are free within ±``half`` and on a damped spring beyond, (n, k).

    s̈ = ω²·aim − c, with c = 0 within ±h and ω²·(s ∓ h) + 2·``damping``·ω·ṡ beyond; flanks only push.  By steps of
    ``step`` s at constant average acceleration (Newmark, J. Eng. Mech. 85, 1959: β = 1/4, γ = 1/2).  ``aim``, by which
    a spring would give, and ``frequency``, rad/s, are (n, k), given every ``finer`` steps and linear in between;
    ``half`` is (k,).  The masses begin at rest where their aims hold them.
    """
    aims, frequencies, halves = (np.ascontiguousarray(own) for own in (aim, frequency, half))
    return _compiled()(aims, frequencies, halves, damping, step, finer)


@functools.cache
def _compiled() -> Callable[[Floats, Floats, Floats, float, float, int], Floats]:
    array, row, number = types.float64[:, ::1], types.float64[::1], types.float64
    compiled = numba.njit(array(array, array, row, number, number, types.int64), cache=True)(_along)
    return cast(Callable[[Floats, Floats, Floats, float, float, int], Floats], compiled)


def _along(aim: Floats, frequency: Floats, half: Floats, damping: float, step: float, finer: int) -> Floats:
    out = np.empty_like(aim)
    for i in range(half.size):
        place = aim[0, i] + np.sign(aim[0, i]) * half[i]
        speed = pull = 0.0
        out[0, i] = place
        for k in range(1, aim.shape[0]):
            for part in range(1, finer + 1):
                share = part / finer
                omega = frequency[k - 1, i] + share * (frequency[k, i] - frequency[k - 1, i])
                free = omega * omega * (aim[k - 1, i] + share * (aim[k, i] - aim[k - 1, i]))
                # Where and how fast it would be if it were not pulled in this step.
                place += step * speed + 0.25 * step * step * pull
                speed += 0.5 * step * pull
                beyond = place - min(max(place, -half[i]), half[i])
                pull = free
                if beyond != 0.0:
                    held = 1.0 + damping * omega * step + 0.25 * (omega * step) ** 2
                    pressed = (free - omega * omega * beyond - 2.0 * damping * omega * speed) / held
                    if (free - pressed) * beyond > 0.0:
                        pull = pressed
                place += 0.25 * step * step * pull
                speed += 0.5 * step * pull
            out[k, i] = place
    return out
