"""Runs of equal samples, and of samples where a mask is true."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]
Mask = NDArray[np.bool_]


def bounds_of(values: NDArray[np.generic], piece: Integers | None = None) -> Integers:
    """Return where runs of equal values (n,) begin, and the end; none extends into another ``piece`` (n,)."""
    cuts = np.flatnonzero((values[1:] != values[:-1]) | (np.diff(numbered(piece, values.size)) != 0)) + 1
    return np.concatenate([[0], cuts, [values.size]])


def runs_of(values: NDArray[np.generic], piece: Integers | None = None, least: float = 1.0) -> list[tuple[int, int]]:
    """Return the runs (first, past) of at least ``least`` equal values (n,), each within one ``piece`` (n,)."""
    bounds = bounds_of(values, piece)
    long = np.flatnonzero(np.diff(bounds) >= least)
    return list(zip(bounds[long].tolist(), bounds[long + 1].tolist(), strict=True))


def spans(mask: Mask) -> list[tuple[int, int]]:
    """Return the runs (first, past) in which a mask is true."""
    return [(a, b) for a, b in runs_of(mask.astype(np.int64)) if mask[a]]


def numbered(piece: Integers | None, count: int) -> Integers:
    """Return the number of each sample's piece, (count,): all 0 where ``piece`` is None."""
    return np.zeros(count, dtype=np.int64) if piece is None else piece
