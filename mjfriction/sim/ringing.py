"""Masses on springs whose bases are moved: where they are as they lag behind."""

from __future__ import annotations

import functools
from collections.abc import Callable
from typing import cast

import numba
import numpy as np
from numba import types

from mjfriction.laws.law import Floats

NEWTON = 2  # steps by which a hardening spring's force is found at the end of each step, from that at its beginning


def ringing(
    aim: Floats, frequency: Floats, damping: float, step: float, finer: int = 1, hardening: float | Floats = 0.0
) -> Floats:
    """Return positions of masses that oscillate about ``aim`` at a ``frequency`` in rad/s, all (n,) or (n, k).

    s̈ = ω²·(aim − s − κ·s³) − 2·``damping``·ω·ṡ, by steps of ``step`` s at constant average acceleration (Newmark, J.
    Eng. Mech. 85, 1959: β = 1/4, γ = 1/2).  ``aim`` and ``frequency`` are given every ``finer`` steps and are linear in
    between.  κ is the ``hardening`` of the masses' springs, () or (k,).  The masses begin at rest where their aims hold
    them.
    """
    aims, frequencies = (np.ascontiguousarray(own.reshape(own.shape[0], -1)) for own in (aim, frequency))
    hard = np.array(np.broadcast_to(hardening, aims.shape[1:]), dtype=float)
    begin = deflection(aims[0], hard)
    return _compiled()(aims, frequencies, begin, hard, damping, step, finer).reshape(aim.shape)


def deflection(aim: Floats, hardening: float | Floats) -> Floats:
    """Return s where s + κ·s³ = ``aim``, with κ ≥ 0 the ``hardening``; the shapes broadcast."""
    hard = np.asarray(hardening) > 0.0
    # The cubic's only real root: with s = (2/√(3κ))·sinh(x), the equation is sinh(3x) = 1.5·√(3κ)·aim.
    root = np.sqrt(3.0 * np.where(hard, hardening, 1.0))
    return np.asarray(np.where(hard, 2.0 / root * np.sinh(np.arcsinh(1.5 * root * aim) / 3.0), aim))


@functools.cache
def _compiled() -> Callable[[Floats, Floats, Floats, Floats, float, float, int], Floats]:
    # The error model of numpy divides without a check for zero, so that the loop over masses can be vectorised.
    array, row, number = types.float64[:, ::1], types.float64[::1], types.float64
    signature = array(array, array, row, row, number, number, types.int64)
    compiled = numba.njit(signature, cache=True, error_model="numpy")(_along)
    return cast(Callable[[Floats, Floats, Floats, Floats, float, float, int], Floats], compiled)


def _along(
    aim: Floats, frequency: Floats, begin: Floats, hard: Floats, damping: float, step: float, finer: int
) -> Floats:
    out = np.empty_like(aim)
    place = begin.copy()
    speed, pull, before = np.zeros_like(place), np.zeros_like(place), np.zeros_like(place)
    hardens = np.any(hard > 0.0)
    out[0] = place
    for k in range(1, aim.shape[0]):
        for part in range(1, finer + 1):
            share = part / finer
            for i in range(place.size):
                goal = aim[k - 1, i] + share * (aim[k, i] - aim[k - 1, i])
                omega = frequency[k - 1, i] + share * (frequency[k, i] - frequency[k - 1, i])
                # Where and how fast it would be if it were not pulled in this step.
                place[i] += step * speed[i] + 0.25 * step * step * pull[i]
                speed[i] += 0.5 * step * pull[i]
                before[i] = pull[i]
                pull[i] = omega * omega * (goal - place[i]) - 2.0 * damping * omega * speed[i]
                pull[i] /= 1.0 + damping * omega * step + 0.25 * (omega * step) ** 2
            if hardens:  # apart, so that the loop over straight springs can be vectorised
                for i in range(place.size):
                    omega = frequency[k - 1, i] + share * (frequency[k, i] - frequency[k - 1, i])
                    held = 1.0 + damping * omega * step + 0.25 * (omega * step) ** 2
                    straight, after = held * pull[i], before[i]
                    for _ in range(NEWTON):
                        there = place[i] + 0.25 * step * step * after
                        stiffer = omega * omega * hard[i] * there * there
                        over = held * after + stiffer * there - straight
                        after -= over / (held + 0.75 * step * step * stiffer)
                    pull[i] = after
            for i in range(place.size):
                place[i] += 0.25 * step * step * pull[i]
                speed[i] += 0.5 * step * pull[i]
        out[k] = place
    return out
