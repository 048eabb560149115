"""A log on an evenly spaced clock: split where samples are missing, resampled where the clock only jitters."""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import numpy as np
from scipy.interpolate import CubicSpline

from mjfriction.errors import LogError
from mjfriction.record.log import Floats, Integers, Log

GAP_STEPS = 4.0  # a step longer than this many ordinary ones is a gap, not jitter
WORST_JITTER = 0.5  # standard deviation of the steps, relative to the ordinary one, beyond which a log is refused
SLOWEST = 0.1  # s, longest ordinary step
SHORTEST_PIECE = 60  # samples; in shorter pieces, the filter's ends affect every sample
EVEN = 1e-3  # of a step; samples that deviate less from an even grid are taken as even


@dataclass(frozen=True)
class Clock:
    """When a log was sampled: contiguous pieces, the ordinary step (s), and the jitter around it, relative to the step.

    ``pieces`` are (first row, row past the last); ``gaps`` are (row before, row after) of missing stretches.
    """

    step: float
    jitter: float
    pieces: tuple[tuple[int, int], ...]
    gaps: tuple[tuple[int, int], ...]


@dataclass(frozen=True)
class Grid:
    """One contiguous piece of a log on an even grid: its ``rows`` of the log, the evenly spaced ``time``, and whether
    that was ``moved`` from the log's own instants.
    """

    rows: slice
    time: Floats
    moved: bool


def read_clock(log: Log) -> Clock:
    """Find the log's ordinary step, its gaps and its jitter.

    Raises :class:`LogError` when the steps are so uneven that velocity and acceleration cannot be estimated.
    """
    step = np.diff(log.time)
    joined = np.diff(log.segment) == 0
    ordinary = float(np.median(step[joined])) if np.any(joined) else float("nan")
    if not np.isfinite(ordinary):
        raise LogError(f"{log.source}: every row is a segment of its own; a segment needs many rows of one motion")
    if ordinary > SLOWEST:
        raise LogError(
            f"{log.source}: time steps of {ordinary:.4g} s are too long to differentiate (at most {SLOWEST:g} s); "
            "time must be in seconds: a clock in milli-, micro- or nanoseconds is divided by 1e3, 1e6 or 1e9"
        )
    gap = joined & (step > GAP_STEPS * ordinary)
    steady = step[joined & ~gap]
    jitter = float(np.std(steady)) / ordinary if steady.size else 0.0
    if jitter > WORST_JITTER:
        raise LogError(
            f"{log.source}: sampling is too irregular to differentiate: steps spread by {100 * jitter:.0f} % around "
            f"{ordinary:.4g} s (at most {100 * WORST_JITTER:.0f} % is allowed); record on a steady clock"
        )
    cuts = np.flatnonzero(~joined | gap) + 1
    bounds = [0, *cuts.tolist(), log.time.size]
    pieces = tuple(itertools.pairwise(bounds))
    gaps = tuple((int(row), int(row) + 1) for row in np.flatnonzero(gap))
    return Clock(step=ordinary, jitter=jitter, pieces=pieces, gaps=gaps)


def even_grid(log: Log, clock: Clock, piece: tuple[int, int]) -> Grid:
    """Return the even grid of one piece: the log's own instants where they are even, else a grid at its mean rate."""
    first, past = piece
    time = log.time[first:past]
    if time.size < 2:
        return Grid(slice(first, past), time, moved=False)
    count = max(2, round((time[-1] - time[0]) / clock.step) + 1)
    even: Floats = np.linspace(time[0], time[-1], count)
    moved = count != time.size or bool(np.max(np.abs(even - time)) > EVEN * clock.step)
    return Grid(slice(first, past), even if moved else time, moved)


def onto_grid(values: Floats, log_time: Floats, grid: Grid, *, smooth: bool, late: float = 0.0) -> Floats:
    """Return a column of the log on the grid: by cubic spline where it is smooth (positions), otherwise linearly.

    A column that was recorded ``late`` (s) is shifted back by that time.
    """
    piece = values[grid.rows]
    if not grid.moved and late == 0.0:
        return piece
    time = log_time[grid.rows] - late
    if smooth and time.size >= 4:
        return np.asarray(CubicSpline(time, piece)(grid.time), dtype=np.float64)
    return np.interp(grid.time, time, piece)


def grid_segments(grids: list[Grid]) -> Integers:
    """Return the number of the grid that each of the concatenated grid samples belongs to."""
    return np.concatenate([np.full(grid.time.size, i, dtype=np.int64) for i, grid in enumerate(grids)])


def long_grids(log: Log, clock: Clock) -> list[Grid]:
    """Return the pieces of a log that are long enough to be filtered, each on its even grid."""
    return [even_grid(log, clock, piece) for piece in clock.pieces if piece[1] - piece[0] >= SHORTEST_PIECE]
