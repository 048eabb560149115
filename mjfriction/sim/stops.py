"""A mass that moves on its own between two stops."""

from __future__ import annotations

import functools
from collections.abc import Callable
from typing import cast

import numba
import numpy as np
from numba import types

from mjfriction.laws.law import Floats


def between_stops(
    pull: Floats, back: Floats, step: float, caught: int, finer: int = 1, drag: Floats | None = None
) -> Floats:
    """Return the position of the mass, from −1 to 1, (n,).

    It obeys s̈ = pull − back·s − drag·ṡ, with ``pull`` and ``back`` (n,) in 1/s² and ``drag`` (n,) in 1/s (none by
    default), between stops at ±1 without rebound.  It is integrated by semi-implicit Euler steps of ``step`` s.  All
    three are given every ``finer`` steps; the first two are linear in between, and ``drag`` is constant.  The mass
    begins on the stop that the first pull points to.  Once the other stop has caught the mass, it holds it for
    ``caught`` steps, over which a filter has smeared the impact.
    """
    slow = np.zeros_like(pull) if drag is None else np.ascontiguousarray(drag)
    return _compiled()(np.ascontiguousarray(pull), np.ascontiguousarray(back), slow, step, caught, finer)


@functools.cache
def _compiled() -> Callable[[Floats, Floats, Floats, float, int, int], Floats]:
    course = types.float64[::1]
    signature = course(course, course, course, types.float64, types.int64, types.int64)
    return cast(Callable[[Floats, Floats, Floats, float, int, int], Floats], numba.njit(signature, cache=True)(_along))


def _along(pull: Floats, back: Floats, drag: Floats, step: float, caught: int, finer: int) -> Floats:
    out = np.empty_like(pull)
    place, speed, held = np.sign(pull[0]), 0.0, 0
    stop = place
    before, back_before = pull[0], back[0]
    for k in range(pull.size):
        slope, back_slope = (pull[k] - before) / finer, (back[k] - back_before) / finer
        first = 1 if k > 0 else finer
        pressed = min(before * place - back_before, pull[k] * place - back[k])
        if speed == 0.0 and abs(place) == 1.0 and pressed >= 0.0:
            held -= finer + 1 - first
            first = finer + 1  # it stays on its stop throughout the interval
        for part in range(first, finer + 1):
            held -= 1
            if held <= 0:
                speed += (before + slope * part - (back_before + back_slope * part) * place - drag[k] * speed) * step
                place += speed * step
            if abs(place) >= 1.0:
                place, speed = np.sign(place), 0.0
                if place != stop:
                    stop, held = place, caught
        before, back_before = pull[k], back[k]
        out[k] = place
    return out
