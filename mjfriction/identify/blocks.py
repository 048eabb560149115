"""Stretches of motion that can stand for one another: the units of cross-validation and of intervals."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mjfriction.errors import LogError
from mjfriction.identify.rows import Chain
from mjfriction.record.log import Floats, Integers

BLOCK_SECONDS = 1.0  # s, longer than the memory of any noise that the filters cause
SHORTEST_BLOCK = 0.5  # s, in logs too short for eight blocks of a second
MOST_BLOCKS = 60
MOST_GROUPS = 30  # of repetitions: of more, several that follow one another are one group
FEWEST_BLOCKS = 8
FEWEST_REPEATS = 4
FOLDS, FEWEST_FOLDS = 6, 3
SAME = 0.01  # two courses of the motion are the same when they differ by less than this, relative to its spread


@dataclass(frozen=True)
class Blocks:
    """The blocks, groups and folds of a gap's rows.

    ``row`` (rows,) numbers the block of each row.  ``group`` (blocks,) numbers the independent unit of each block: the
    block itself, or, where the motion repeats at least four times, its repetition.  Of many repetitions, several that
    follow one another are one group, and the same stretches of these are one block.  ``fold`` (blocks,) numbers the
    part with which each block is left out.  ``period`` is that of a motion that repeats, s.
    """

    row: Integers
    group: Integers
    fold: Integers
    period: float | None = None

    @property
    def count(self) -> int:
        """How many blocks."""
        return self.group.size

    @property
    def groups(self) -> int:
        """How many groups."""
        return int(self.group[-1]) + 1

    @property
    def folds(self) -> list[NDArray[np.bool_]]:
        """Masks (blocks,) of the parts that are left out in turn.

        They are interleaved, so that each covers the whole course of the log.  Where the motion repeats, each holds the
        same stretch of every repetition, so that no fit has seen it.
        """
        return [self.fold == number for number in range(int(self.fold.max()) + 1)]


def cut_blocks(chain: Chain, position: Floats, source: str) -> Blocks:
    """Cut the rows into blocks of a second or more, at most sixty; in short logs into eight of half a second or more.

    ``position`` (rows, joints) shows repetitions.  A short one is cut into six where they are half a second or longer:
    a third of it may be all that goes one way, without which nothing tells friction from weight.

    Raises :class:`LogError` when the motion is too short to fit on one part and prove on another.
    """
    step = np.diff(chain.time)
    elapsed = np.append(0.0, np.cumsum(np.clip(step, 0.0, 10.0 / chain.band)))
    total = float(elapsed[-1])
    count = max(FEWEST_BLOCKS, int(total / max(BLOCK_SECONDS, total / MOST_BLOCKS)))
    if total / count < SHORTEST_BLOCK:
        raise LogError(
            f"{source}: {total:.1f} s of usable motion are too short; at least "
            f"{FEWEST_BLOCKS * SHORTEST_BLOCK:.0f} s are needed to fit on one part and prove on another"
        )
    period = _period(chain, position) if np.all(chain.piece == chain.piece[0]) else None
    if period is None:
        row = np.minimum((elapsed / total * count).astype(np.int64), count - 1)
        return Blocks(row, np.arange(count), np.arange(count) % FOLDS)
    within = max(FEWEST_FOLDS, min(FOLDS, int(period / SHORTEST_BLOCK)), round(count * period / total))
    stretch = (elapsed / period * within).astype(np.int64)
    repeats = round(total / period)
    groups = min(repeats, MOST_GROUPS)
    # What goes on beyond the last repetition makes further blocks of the last group.
    row = np.minimum(stretch // within, repeats) * groups // repeats * within + stretch % within
    number = np.arange(int(np.max(row)) + 1)
    return Blocks(row, np.minimum(number // within, groups - 1), number % within % FOLDS, period)


def _period(chain: Chain, position: Floats) -> float | None:
    # The mean squared difference between the course and itself one lag later, from the autocorrelation.
    spread = np.std(position, axis=0)
    moving = spread > 1e-9
    course = (position[:, moving] - np.mean(position[:, moving], axis=0)) / spread[moving]
    rows = course.shape[0]
    padded = np.fft.rfft(course, 2 * rows, axis=0)
    correlation = np.fft.irfft(np.square(np.abs(padded)), axis=0)[:rows].sum(axis=1)
    power = np.cumsum(np.square(course).sum(axis=1))
    lag = np.arange(1, rows - 1)
    head, tail = power[rows - 1 - lag], power[-1] - power[lag - 1]
    difference = (head + tail - 2.0 * correlation[lag]) / (head + tail)
    first = np.argmax(difference > 10.0 * SAME)  # skip the trivial likeness of neighbouring rows
    alike = np.flatnonzero(difference[first:] < SAME)
    alike = alike[lag[first + alike] < rows / 2]
    if (first == 0 and difference[0] <= 10.0 * SAME) or alike.size == 0:
        return None
    start = first + int(alike[0])
    stop = start + int(np.argmax(np.append(difference[start:] >= SAME, True)))
    rows_each = lag[start + int(np.argmin(difference[start:stop]))]
    return float(rows_each * np.median(np.diff(chain.time))) if round(rows / rows_each) >= FEWEST_REPEATS else None
