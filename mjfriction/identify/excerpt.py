"""A part of a long log that stands for the whole of it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from mjfriction.identify.blocks import Blocks
from mjfriction.identify.gap import Gap
from mjfriction.identify.measure import gap_on
from mjfriction.identify.rows import Chain
from mjfriction.record.log import Integers

ENOUGH = 300.0  # s of motion that a search needs
GOLDEN = 0.6180339887498949  # multiples of it, less their whole parts, fill the range from 0 to 1 evenly


def excerpt(gap: Gap) -> Gap:
    """Return a long gap on as much of its motion as a search needs, the same share of every block.

    The blocks stay what they are: what goes on over hours shows, and what one fit leaves out no other part of a block
    gives away. A gap that is no longer is returned as it is.
    """
    chain, blocks = gap.chain, gap.blocks
    share = ENOUGH / (chain.time.size * chain.step)
    if share >= 1.0:
        return gap
    between = 0.5 * (chain.time[1:] + chain.time[:-1])

    def as_before(part: Chain) -> Blocks:
        return replace(blocks, row=blocks.row[np.searchsorted(between, part.time)])

    return gap_on(gap, gap.motion.stretches(_samples(gap, _spread(blocks.row, share))), as_before)


def _spread(block: Integers, share: float) -> NDArray[np.bool_]:
    # The same share of the rows of each block, one after another. Where it begins differs from block to block: a motion
    # that repeats as blocks do would always show the same.
    taken = np.zeros(block.size, dtype=bool)
    for number in np.unique(block):
        rows = np.flatnonzero(block == number)
        count = int(np.ceil(share * rows.size))
        begin = int(GOLDEN * number % 1.0 * (rows.size - count))
        taken[rows[begin : begin + count]] = True
    return taken


def _samples(gap: Gap, taken: NDArray[np.bool_]) -> Integers:
    # The samples of which some rows are made, each within the piece of its row.
    chain, motion = gap.chain, gap.motion
    centre = np.searchsorted(motion.time, chain.time[taken])
    reach = chain.taps.size // 2
    wanted = np.zeros(motion.time.size, dtype=bool)
    for at, piece in zip(centre.tolist(), motion.piece[centre].tolist(), strict=True):
        near = slice(max(at - reach, 0), at + reach + 1)
        wanted[near] |= motion.piece[near] == piece
    return np.flatnonzero(wanted)
