"""Masses that move on their own between springy flanks, such as links in the play of a gear that gives."""

from __future__ import annotations

import functools
from collections.abc import Callable
from typing import cast

import numba
import numpy as np
from numba import types

from mjfriction.laws.law import Floats
from mjfriction.sim.lagging import Lagging, between
from mjfriction.sim.ringing import deflection


def between_flanks(
    link: Lagging,
    half: Floats,
    spring: Floats,
    damper: Floats,
    step: float,
    finer: int = 1,
    hardening: float | Floats = 0.0,
) -> Floats:
    """Return how far a link lags that is free within ±``half`` and on a damped spring beyond, for each of k, (n, k).

    inertia·s̈ + damping·ṡ + stiffness·s + c = load, with c = 0 within ±half and c = k·b + h·b³ + d·ṡ at b = s ∓ half
    beyond; flanks only push.  By steps of ``step`` s at constant average acceleration (Newmark, J. Eng. Mech. 85, 1959:
    β = 1/4, γ = 1/2).  The link is given every ``finer`` steps and is linear in between.  k is the ``spring``, d the
    ``damper``, both (k,) like ``half``, and h the ``hardening``, () or (k,).  It begins at rest where its load holds
    it.
    """
    halves, springs, dampers = (np.ascontiguousarray(own, dtype=np.float64) for own in (half, spring, damper))
    hard = np.array(np.broadcast_to(hardening, halves.shape), dtype=np.float64)
    side, held = np.sign(link.load[0]) * halves, springs + link.stiffness[0]
    begin = side + deflection((link.load[0] - link.stiffness[0] * side) / held, hard / held)
    load, inertia, stiffness, damping, _ = link.over(slice(None))
    return _compiled()(load, inertia, stiffness, damping, halves, springs, dampers, hard, begin, step, finer)


@functools.cache
def _compiled() -> Callable[..., Floats]:
    # The error model of numpy divides without a check for zero, so that the loop over masses can be vectorised.
    course, number = types.float64[::1], types.float64
    signature = types.float64[:, ::1](*[course] * 9, number, types.int64)
    return cast(Callable[..., Floats], numba.njit(signature, cache=True, error_model="numpy")(_along))


def _along(
    load: Floats,
    inertia: Floats,
    stiffness: Floats,
    damping: Floats,
    half: Floats,
    spring: Floats,
    damper: Floats,
    hard: Floats,
    begin: Floats,
    step: float,
    finer: int,
) -> Floats:
    out = np.empty((load.size, half.size))
    place = begin.copy()
    speed, pull = np.zeros_like(place), np.zeros_like(place)
    out[0] = place
    for k in range(1, load.size):
        for part in range(1, finer + 1):
            worth, drawn, back, slow = between(load, inertia, stiffness, damping, k, part / finer)
            held = 1.0 + 0.5 * step * slow + 0.25 * step * step * back
            for i in range(half.size):  # without a branch, so that the loop over masses can be vectorised
                # Where and how fast it would be if it were not pulled in this step.
                there = place[i] + (step * speed[i] + 0.25 * step * step * pull[i])
                pace = speed[i] + 0.5 * step * pull[i]
                carried = drawn - back * there - slow * pace
                beyond = there - min(max(there, -half[i]), half[i])
                stiff, stiffer = worth * spring[i], worth * hard[i] * beyond * beyond
                free = carried / held
                pressed = carried - (stiff + stiffer) * beyond - worth * damper[i] * pace
                pressed /= held + 0.5 * step * worth * damper[i] + 0.25 * step * step * (stiff + 3.0 * stiffer)
                now = pressed if (free - pressed) * beyond > 0.0 else free
                place[i] = there + 0.25 * step * step * now
                speed[i] = pace + 0.5 * step * now
                pull[i] = now
        out[k] = place
    return out
