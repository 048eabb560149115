"""Waves along a joint's stroke: which wavenumbers a log can show, and the columns of these waves at its rows."""

from __future__ import annotations

import numpy as np

from mjfriction.identify.gap import Gap
from mjfriction.record.log import Floats

FEWEST_WAVES = 1.2  # over the stroke; longer waves look like springs or gravity
FEWEST_TURNING = 0.5  # the same for waves that turn with the direction of motion: longer ones look like a level
# Steps of the grid of wavenumbers per difference that the stroke resolves: two waves differ when they drift apart by
# one period over it.
STEPS_PER_LOBE = 2.0
MOST_WAVENUMBERS = 400
IN_BAND = 0.8  # share of the band that a wave's frequency may reach while the joint is slow
FREQUENCIES = 16384  # per sampling rate: the chain's gain is tabulated at those up to half the rate
SLOW = 0.25  # share of the time in motion in which a joint counts as slow


def wavenumber_bounds(gap: Gap, joint: int, *, turns: bool) -> tuple[float, float]:
    """Return the lowest and the highest wavenumber (1/rad or 1/m) that a joint's motion shows.

    The lowest is a little more than one wave over the stroke, or half a wave where waves turn with the direction of
    motion.  The highest is what the band lets through for a quarter of the time that the joint moves: a gear's teeth
    pass too fast while the joint is quick.
    """
    stroke = float(np.ptp(gap.motion.position[:, joint]))
    speed = np.abs(gap.motion.velocity[:, joint])
    slow = float(np.quantile(speed[speed > gap.doubt_speed[joint]], SLOW))
    low = (FEWEST_TURNING if turns else FEWEST_WAVES) * 2.0 * np.pi / stroke
    return low, max(low, IN_BAND * 2.0 * np.pi * gap.chain.band / slow)


def wavenumber_step(gap: Gap, joint: int) -> float:
    """Return half the difference of two wavenumbers that the stroke can resolve."""
    return 2.0 * np.pi / float(np.ptp(gap.motion.position[:, joint])) / STEPS_PER_LOBE


def wavenumbers(gap: Gap, joint: int, *, turns: bool) -> Floats:
    """Return a grid of wavenumbers (k,) twice as fine as the stroke can resolve."""
    low, high = wavenumber_bounds(gap, joint, turns=turns)
    step = wavenumber_step(gap, joint)
    return np.asarray(low + step * np.arange(min(int((high - low) / step), MOST_WAVENUMBERS)), dtype=np.float64)


def waves_at_rows(gap: Gap, joint: int, wavenumber: Floats, every: int, *, turns: bool) -> Floats:
    """Return cosine and sine of each wavenumber (k,) at each ``every``-th row, (rows/every, k, 2).

    They are accurate enough to rank by: attenuated as the chain attenuates the frequency they have there, without
    filtering.  With ``turns`` they turn with the direction of motion.
    """
    # Single precision is enough for ranking, and about six times as fast.  So is the gain at the nearest of many
    # frequencies.
    phase = np.outer(gap.at_rows("position")[::every, joint], wavenumber).astype(np.float32)
    speed = np.abs(gap.at_rows("velocity")[::every, joint])
    apart = gap.chain.rate / FREQUENCIES
    nearest = (np.outer(speed, wavenumber / (2.0 * np.pi * apart)) + 0.5).astype(np.int32)
    passed = gap.chain.response(np.arange(0.0, FREQUENCIES // 2) * apart).take(nearest, mode="clip")
    if turns:
        passed = passed * gap.at_rows("forward")[::every, [joint]]
    out = np.empty((*phase.shape, 2))
    np.multiply(np.cos(phase), passed, out=out[:, :, 0])
    np.multiply(np.sin(phase), passed, out=out[:, :, 1])
    return out
