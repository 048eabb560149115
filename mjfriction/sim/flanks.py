"""Masses that move on their own between springy flanks, such as links in the play of a gear that gives."""

from __future__ import annotations

import functools
from collections.abc import Callable
from typing import cast

import numba
import numpy as np
from numba import types

from mjfriction.laws.law import Floats
from mjfriction.sim.ringing import deflection


def between_flanks(
    aim: Floats,
    frequency: Floats,
    half: Floats,
    damping: float,
    step: float,
    finer: int = 1,
    hardening: float | Floats = 0.0,
) -> Floats:
    """Return positions of masses that are free within ±``half`` and on a damped spring beyond, (n, k).

    s̈ = ω²·aim − c, with c = 0 within ±h and c = ω²·(b + κ·b³) + 2·``damping``·ω·ṡ at b = s ∓ h beyond; flanks only
    push.  By steps of ``step`` s at constant average acceleration (Newmark, J. Eng. Mech. 85, 1959: β = 1/4, γ = 1/2).
    ``aim``, by which a straight spring would give, and ``frequency``, rad/s, are (n, k), given every ``finer`` steps
    and linear in between.  ``half`` is (k,), and κ the ``hardening`` of the springs, () or (k,).  The masses begin at
    rest where their aims hold them.
    """
    aims, frequencies, halves = (np.ascontiguousarray(own) for own in (aim, frequency, half))
    hard = np.array(np.broadcast_to(hardening, halves.shape), dtype=np.float64)
    begin = deflection(aims[0], hard) + np.sign(aims[0]) * halves
    return _compiled()(aims, frequencies, halves, begin, hard, damping, step, finer)


@functools.cache
def _compiled() -> Callable[[Floats, Floats, Floats, Floats, Floats, float, float, int], Floats]:
    array, row, number = types.float64[:, ::1], types.float64[::1], types.float64
    signature = array(array, array, row, row, row, number, number, types.int64)
    compiled = numba.njit(signature, cache=True)(_along)
    return cast(Callable[[Floats, Floats, Floats, Floats, Floats, float, float, int], Floats], compiled)


def _along(
    aim: Floats,
    frequency: Floats,
    half: Floats,
    begin: Floats,
    hard: Floats,
    damping: float,
    step: float,
    finer: int,
) -> Floats:
    out = np.empty_like(aim)
    for i in range(half.size):
        place = begin[i]
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
                    stiffer = hard[i] * beyond * beyond
                    held = 1.0 + damping * omega * step + 0.25 * (omega * step) ** 2 * (1.0 + 3.0 * stiffer)
                    pressed = free - omega * omega * (1.0 + stiffer) * beyond - 2.0 * damping * omega * speed
                    pressed /= held
                    if (free - pressed) * beyond > 0.0:
                        pull = pressed
                place += 0.25 * step * step * pull
                speed += 0.5 * step * pull
            out[k, i] = place
    return out
