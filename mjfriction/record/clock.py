"""A log's clock: its ordinary step, and a log with its clock put right."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from mjfriction.record.fault import Fault
from mjfriction.record.log import POSITION, Floats, Log

DEGREE = 5  # of the curves that the joints' courses are smooth by
SURE = 10.0  # by which one clock is likelier than another, in logarithm
CHUNK, FEWEST_HELD = 48, 3  # rows on which the joints' courses are held against two clocks, and of the last of them


@dataclass(frozen=True)
class Steps:
    """The ``length`` (n − 1,) of every step of a log (s), whether it is ``joined`` within a segment, and the
    ``ordinary`` one.
    """

    length: Floats
    joined: NDArray[np.bool_]
    ordinary: float


def steps_of(log: Log) -> Steps | None:
    """Return a log's steps; None where time never goes on within a segment."""
    length, joined = np.diff(log.time), np.diff(log.segment) == 0
    ahead = length[joined & (length > 0.0)]
    return Steps(length, joined, float(np.median(ahead))) if ahead.size else None


def put_right(log: Log, time: Floats, faults: Sequence[Fault]) -> Log:
    """Return the log by another ``time`` (n,), what was wrong said; by what time its rows were recorded stays known."""
    recorded, kept = (log.time, np.ones(time.size, dtype=bool)) if log.recorded is None else (log.recorded, log.kept)
    return replace(log, time=time, faults=(*log.faults, *faults), recorded=recorded, kept=kept)


def roughness(course: Floats, along: Floats) -> float:
    """Return what a course (n,) leaves of the smoothest curve through it ``along`` a clock (n,) that begins at 0, as
    minus the logarithm of a likelihood.
    """
    basis = np.vander(along / max(along[-1], np.finfo(float).tiny), DEGREE + 1)
    left = course - basis @ np.linalg.lstsq(basis, course, rcond=None)[0]
    least = np.finfo(float).eps * float(np.max(np.abs(course)))
    return 0.5 * course.size * float(np.log(np.mean(np.square(left)) + least**2))


def evenness(log: Log, first: int, end: int) -> float:
    """Return by how much likelier it is that rows ``first`` to ``end`` came evenly than that they came by their clock,
    in logarithm: the joints' courses are smooth along the clock that is right.
    """
    for_rows = 0.0
    for begin in range(first, end, CHUNK):
        rows = slice(begin, min(begin + CHUNK, end) + 1)
        if rows.stop - rows.start < FEWEST_HELD:
            continue
        by_clock: Floats = log.time[rows] - log.time[begin]
        for joint in log.joints:
            course = log.columns[f"{POSITION}.{joint}"][rows]
            if np.ptp(course) > 0.0:
                for_rows += roughness(course, by_clock) - roughness(course, np.arange(float(course.size)))
    return for_rows
