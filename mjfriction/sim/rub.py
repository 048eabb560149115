"""All friction of a model at trial velocities: the terms of every joint, added up.

Compiled once on its own and reached as a C function: the laws would otherwise be compiled again into each caller.
"""

from __future__ import annotations

import functools
from typing import Any, cast

import numba
from numba import types

from mjfriction.laws.ambient import AMBIENT_SIZE
from mjfriction.laws.window import window_at
from mjfriction.laws.wrapped import advance_wrapped
from mjfriction.sim.block import T_RUBBING, T_SIZE, T_STATE, T_STATES, T_VALUES, TERM_ROW

SYMBOL = "mjfriction_rub"
_ADDRESS, _COUNT = types.intp, types.int64
SIGNATURE = types.void(
    _ADDRESS, _ADDRESS, _COUNT, _COUNT, _COUNT, _ADDRESS, _ADDRESS, _ADDRESS, types.float64, *[_ADDRESS] * 4
)
rub = cast(Any, types).ExternalFunction(SYMBOL, SIGNATURE)


def _rub(
    block: int, terms: int, count: int, first: int, last: int, v_at: int, around: int, z: int, h: float,
    z_next: int, near: int, torque_at: int, slope_at: int,
) -> None:  # fmt: skip
    """Write torque, slope and next states of joints with friction, ``first`` to ``last`` − 1, at their velocities.

    All arrays are passed as addresses.  ``block``: the model's block; ``terms`` (count, 6): its term table in the order
    of joints; ``v``, ``torque``, ``slope`` (k,); ``around`` (k, 7): the joints' surroundings; ``z``, ``z_next``: all
    states; ``near`` (7,): work space.
    """
    v, torque, slope = window_at(v_at, last), window_at(torque_at, last), window_at(slope_at, last)
    for i in range(first, last):
        torque[i] = 0.0
        slope[i] = 0.0
    for t in range(count):
        row = window_at(terms + 8 * TERM_ROW * t, TERM_ROW)
        i = int(row[T_RUBBING])
        if i < first or i >= last:
            continue
        state, states = int(row[T_STATE]), int(row[T_STATES])
        own, steepness = advance_wrapped(
            v[i],
            window_at(around + 8 * AMBIENT_SIZE * i, AMBIENT_SIZE),
            window_at(z + 8 * state, states),
            h,
            window_at(block + 8 * int(row[T_VALUES]), int(row[T_SIZE])),
            window_at(z_next + 8 * state, states),
            window_at(near, AMBIENT_SIZE),
        )
        torque[i] += own
        slope[i] += steepness


@functools.cache
def compiled_rub() -> Any:
    """Return the function in machine code; it must live as long as any code that calls it."""
    return numba.cfunc(SIGNATURE, cache=True, error_model="numpy")(_rub)
