"""Rows that were written more than once, or again and again while a recorder stalled."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from mjfriction.record.counts import least_jump
from mjfriction.record.runs import Floats, Integers, Mask, numbered, runs_of

FEWEST_REPEATED = 8  # consecutive rows, equal in every column, that do not repeat by chance


def written_again(time: Floats, segment: Integers, columns: Mapping[str, Floats]) -> Mask:
    """Return which rows are a copy of an earlier row, time included, (n,)."""
    if np.all(np.diff(time) > 0.0):
        return np.zeros(time.size, dtype=bool)
    rows = _as_one(np.column_stack([time, segment.astype(np.float64), *columns.values()]))
    _, first = np.unique(rows, return_index=True)
    again = np.ones(rows.size, dtype=bool)
    again[first] = False
    return again


def _as_one(table: Floats) -> NDArray[np.void]:
    # The rows of a table (n, columns) as single values that can be compared, (n,).
    table = np.ascontiguousarray(table)
    return table.view(np.dtype((np.void, table.dtype.itemsize * table.shape[1])))[:, 0]


def repeated_rows(columns: Mapping[str, Floats]) -> Mask:
    """Return which rows repeat earlier ones, many in a row and equal in every column but time, (n,)."""
    rows = _as_one(np.column_stack([columns[name] for name in sorted(columns)]))
    _, number = np.unique(rows, return_inverse=True)
    out = np.zeros(rows.size, dtype=bool)
    last: dict[int, int] = {}
    lag = np.zeros(rows.size, dtype=np.int64)
    for i, own in enumerate(number.tolist()):
        lag[i] = i - last.get(own, i)
        last[own] = i
    for start, stop in runs_of(lag):
        # A machine at rest repeats the row before, and coarse sensors alternate between a few rows.  Only a stretch of
        # many distinct rows was copied.
        if lag[start] > 1 and np.unique(number[start:stop]).size >= FEWEST_REPEATED:
            out[start:stop] = True
    return out


def held_rows(columns: Mapping[str, Floats], piece: Integers | None = None) -> Mask:
    """Return which rows a stalled recorder wrote, (n,): many in a row equal the row before in every column but time,
    while the machine moves on.

    ``piece`` (n,) numbers the stretches recorded without a break.
    """
    joined = np.diff(numbered(piece, len(next(iter(columns.values()))))) == 0
    again = np.append(False, np.logical_and.reduce([joined, *(own[1:] == own[:-1] for own in columns.values())]))
    out = np.zeros(again.size, dtype=bool)
    held = [(a, b) for a, b in runs_of(again.astype(np.int64)) if again[a] and b - a >= FEWEST_REPEATED - 1]
    if not held:
        return out
    elsewhere = np.zeros(again.size + 1, dtype=bool)
    for values in columns.values():
        if np.ptp(values) > 0.0:
            elsewhere[1:-1] |= joined & (np.abs(np.diff(values)) > least_jump(values, piece))
    for start, stop in held:
        # A machine at rest stays where it was; one that moved on has jumped elsewhere by the next row.
        out[start:stop] = elsewhere[stop]
    return out
