"""Masses on springs whose bases are moved: how far they lag behind."""

from __future__ import annotations

import functools
from collections.abc import Callable
from typing import cast

import numba
import numpy as np
from numba import types

from mjfriction.laws.law import Floats
from mjfriction.sim.lagging import Lagging, between

NEWTON = 2  # steps by which a hardening spring's force is found at the end of each step, from that at its beginning


def ringing(
    link: Lagging,
    spring: Floats,
    damper: Floats,
    step: float,
    finer: int = 1,
    hardening: float | Floats = 0.0,
    begin: Floats | None = None,
) -> Floats:
    """Return how far a link lags that oscillates on its spring, for each of k springs, (n, k).

    inertia·s̈ + (damping + d)·ṡ + (stiffness + k)·s + h·s³ = load, by steps of ``step`` s at constant average
    acceleration (Newmark, J. Eng. Mech. 85, 1959: β = 1/4, γ = 1/2).  The link is given every ``finer`` steps and is
    linear in between.  k is the ``spring``, d the ``damper``, both (k,), and h the ``hardening``, () or (k,).  It
    begins at a lag and a speed of it, (2, k): by default :func:`at_rest`.
    """
    springs, dampers = (np.ascontiguousarray(own, dtype=np.float64) for own in (spring, damper))
    hard = np.array(np.broadcast_to(hardening, springs.shape), dtype=np.float64)
    begun = at_rest(link, springs, hard) if begin is None else begin
    place, speed = (np.ascontiguousarray(own, dtype=np.float64) for own in begun)
    load, inertia, stiffness, damping, _ = link.over(slice(None))
    return _compiled()(load, inertia, stiffness, damping, springs, dampers, hard, place, speed, step, finer)


def at_rest(link: Lagging, spring: Floats, hardening: Floats) -> Floats:
    """Return where the first load of a link holds it on each of k springs, and that it does not move there, (2, k)."""
    held = spring + link.stiffness[0]
    place = deflection(link.load[0] / held, hardening / held)
    return np.array([place, np.zeros_like(place)])


def deflection(aim: Floats, hardening: float | Floats) -> Floats:
    """Return s where s + κ·s³ = ``aim``, with κ ≥ 0 the ``hardening``; the shapes broadcast."""
    hard = np.asarray(hardening) > 0.0
    # The cubic's only real root: with s = (2/√(3κ))·sinh(x), the equation is sinh(3x) = 1.5·√(3κ)·aim.
    root = np.sqrt(3.0 * np.where(hard, hardening, 1.0))
    return np.asarray(np.where(hard, 2.0 / root * np.sinh(np.arcsinh(1.5 * root * aim) / 3.0), aim))


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
    spring: Floats,
    damper: Floats,
    hard: Floats,
    begin: Floats,
    begin_speed: Floats,
    step: float,
    finer: int,
) -> Floats:
    out = np.empty((load.size, spring.size))
    place, speed = begin.copy(), begin_speed.copy()
    before = np.zeros_like(place)
    pull = load[0] - (stiffness[0] + spring + hard * place * place) * place - (damping[0] + damper) * speed
    pull /= inertia[0]
    hardens = np.any(hard > 0.0)
    out[0] = place
    for k in range(1, load.size):
        for part in range(1, finer + 1):
            worth, carried, stiff, drag = between(load, inertia, stiffness, damping, k, part / finer)
            for i in range(place.size):
                back, slow = stiff + worth * spring[i], drag + worth * damper[i]
                # Where and how fast it would be if it were not pulled in this step.
                place[i] += step * speed[i] + 0.25 * step * step * pull[i]
                speed[i] += 0.5 * step * pull[i]
                before[i] = pull[i]
                pull[i] = carried - back * place[i] - slow * speed[i]
                pull[i] /= 1.0 + 0.5 * step * slow + 0.25 * step * step * back
            if hardens:  # apart, so that the loop over straight springs can be vectorised
                for i in range(place.size):
                    back, slow = stiff + worth * spring[i], drag + worth * damper[i]
                    held = 1.0 + 0.5 * step * slow + 0.25 * step * step * back
                    straight, after = held * pull[i], before[i]
                    for _ in range(NEWTON):
                        there = place[i] + 0.25 * step * step * after
                        stiffer = worth * hard[i] * there * there
                        over = held * after + stiffer * there - straight
                        after -= over / (held + 0.75 * step * step * stiffer)
                    pull[i] = after
            for i in range(place.size):
                place[i] += 0.25 * step * step * pull[i]
                speed[i] += 0.5 * step * pull[i]
        out[k] = place
    return out
