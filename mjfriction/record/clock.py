"""A log's clock: its ordinary step, and the log with a corrected clock."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from mjfriction.record.fault import Fault
from mjfriction.record.log import POSITION, Floats, Integers, Log

DEGREE = 5  # of the polynomial that stands for smooth motion
SURE = 10.0  # log-likelihood ratio beyond which one clock is preferred to another
CHUNK, FEWEST_HELD = 48, 3  # rows of a chunk on which two clocks are compared, and fewest rows of the last chunk


@dataclass(frozen=True)
class Steps:
    """The steps of a log's clock: the ``length`` (n − 1,) of each (s), whether it is ``joined`` (n − 1,), that is
    within a segment, and the ``ordinary`` length (s), the median of the positive joined ones.
    """

    length: Floats
    joined: NDArray[np.bool_]
    ordinary: float


def steps_of(log: Log) -> Steps | None:
    """Return a log's steps; None where time never advances within a segment."""
    length, joined = np.diff(log.time), np.diff(log.segment) == 0
    ahead = length[joined & (length > 0.0)]
    return Steps(length, joined, float(np.median(ahead))) if ahead.size else None


def put_right(log: Log, time: Floats, faults: Sequence[Fault]) -> Log:
    """Return the log with another ``time`` (n,) and the ``faults`` added; the recorded times are kept as well."""
    recorded, kept = (log.time, np.ones(time.size, dtype=bool)) if log.recorded is None else (log.recorded, log.kept)
    return replace(log, time=time, faults=(*log.faults, *faults), recorded=recorded, kept=kept)


def roughness(course: Floats, along: Floats) -> float:
    """Return how rough a course (n,) is ``along`` a clock (n,) that is 0 at one of its rows, as a negative
    log-likelihood of the residual of a polynomial fit.
    """
    basis = np.vander(along / max(along[-1], np.finfo(float).tiny), DEGREE + 1)
    left = course - basis @ np.linalg.lstsq(basis, course, rcond=None)[0]
    least = np.finfo(float).eps * float(np.max(np.abs(course)))
    return 0.5 * course.size * float(np.log(np.mean(np.square(left)) + least**2))


def roughness_of(log: Log, rows: Integers, along: Floats) -> float:
    """Return how rough the joints' positions are over ``rows`` (k,), in this order, ``along`` a clock (k,), as
    :func:`roughness` is.
    """
    total = 0.0
    for begin in range(0, rows.size, CHUNK):
        own = slice(begin, begin + CHUNK + 1)
        for joint in log.joints if rows[own].size >= FEWEST_HELD else ():
            course = log.columns[f"{POSITION}.{joint}"][rows[own]]
            total += roughness(course, along[own] - along[begin]) if np.ptp(course) > 0.0 else 0.0
    return total


def evenness(log: Log, first: int, end: int, order: Integers | None = None) -> float:
    """Return the log-likelihood ratio of rows ``first`` to ``end`` being evenly spaced over their clock being right:
    the joints' positions are smooth along the right clock.  With an ``order`` (end − first + 1,) it is the clock of the
    rows put in that order.
    """
    rows = np.arange(first, end + 1)
    order = rows if order is None else order
    return roughness_of(log, order, log.time[order]) - roughness_of(log, rows, rows.astype(np.float64))
