"""A part of a log, and a log whose columns are reinterpreted as they should have been read."""

from __future__ import annotations

from dataclasses import replace
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from mjfriction.record.fault import Mend
from mjfriction.record.log import Log
from mjfriction.record.repair import without_rows
from mjfriction.record.runs import Mask
from mjfriction.record.span import Span, within

Value = TypeVar("Value", bound=np.generic)


def part_of(log: Log, span: Span) -> Log:
    """Return the rows of a log within a time span."""
    own = within(span, log.time)
    return log if np.all(own) else without_rows(log, ~own)


def reread(log: Log, mend: Mend) -> Log:
    """Return the log with the mend applied within its span: columns multiplied by their factors, and exchanged columns
    swapped back.  Columns that the log lacks are ignored.
    """
    own = within(mend.span, log.time)
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


def _exchanged(one: NDArray[Value], other: NDArray[Value], own: Mask) -> tuple[NDArray[Value], NDArray[Value]]:
    return np.where(own, other, one), np.where(own, one, other)
