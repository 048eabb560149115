"""Products of columns, summed within blocks of rows."""

from __future__ import annotations

import functools
from collections.abc import Callable
from typing import cast

import numba
import numpy as np
from numba import types

from mjfriction.record.log import Floats, Integers


def block_products(left: Floats, right: Floats, starts: Integers) -> Floats:
    """Return leftᵀ·right of each block of rows: (rows, a), (rows, b) → (blocks, a, b).

    ``starts`` (blocks + 1,) are the first rows of the blocks, and the number of rows.
    """
    out = np.empty((starts.size - 1, left.shape[1], right.shape[1]))
    _compiled()(np.ascontiguousarray(left), np.ascontiguousarray(right), starts, out)
    return out


@functools.cache
def _compiled() -> Callable[[Floats, Floats, Integers, Floats], None]:
    # Blocks are short, so that each product takes less time than asking for it from Python does.
    array = types.float64[:, ::1]
    signature = types.void(array, array, types.int64[::1], types.float64[:, :, ::1])
    return cast(Callable[[Floats, Floats, Integers, Floats], None], numba.njit(signature, cache=True)(_of_blocks))


def _of_blocks(left: Floats, right: Floats, starts: Integers, out: Floats) -> None:
    for block in range(starts.size - 1):
        first, past = starts[block], starts[block + 1]
        np.dot(left[first:past].T, right[first:past], out[block])
