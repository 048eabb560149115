"""A part of a log, and a log with columns read as they should have been."""

from __future__ import annotations

from dataclasses import replace
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from mjfriction.record.faults import Mask, Mend, Span
from mjfriction.record.log import Log

Value = TypeVar("Value", bound=np.generic)


def part_of(log: Log, span: Span) -> Log:
    """Return the rows of a log within a span of time."""
    own = _within(log, span)
    if np.all(own):
        return log
    return replace(
        log,
        time=log.time[own],
        segment=log.segment[own],
        columns={name: values[own] for name, values in log.columns.items()},
        unusable={name: mask[own] for name, mask in log.unusable.items()},
        recorded=None,
        kept=None,
    )


def reread(log: Log, mend: Mend) -> Log:
    """Return the log with columns times their factors, and those that were exchanged in their places, within the span
    of the mend; columns that the log has not are left aside.
    """
    own = _within(log, mend.span)
    columns, unusable = dict(log.columns), dict(log.unusable)
    for name, factor in mend.factors:
        if name in columns:
            columns[name] = np.where(own, factor * columns[name], columns[name])
    usable = np.zeros(log.time.size, dtype=bool)
    for one, other in mend.exchanged:
        if one in columns and other in columns:
            columns[one], columns[other] = _exchanged(columns[one], columns[other], own)
            masks = unusable.get(one, usable), unusable.get(other, usable)
            unusable[one], unusable[other] = _exchanged(*masks, own)
    return replace(log, columns=columns, unusable=unusable)


def _within(log: Log, span: Span) -> Mask:
    return (log.time >= span[0]) & (log.time < span[1])


def _exchanged(one: NDArray[Value], other: NDArray[Value], own: Mask) -> tuple[NDArray[Value], NDArray[Value]]:
    return np.where(own, other, one), np.where(own, one, other)
