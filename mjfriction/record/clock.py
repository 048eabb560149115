"""A log's clock: its ordinary step, and a log with its clock put right."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from mjfriction.record.faults import Fault
from mjfriction.record.log import Floats, Log


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
