"""The highest frequency in a joint's motion."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from mjfriction.record.log import Floats

MOTION_POWER = 0.9999  # share of the position's power that counts as the motion
HARDLY = 0.04  # of the farthest travel of joints of its kind; a joint that travels less is left out
ABOVE_NOISE = 30.0  # times the noise's median power in a bin; a bin with more is taken as motion


def motion_frequency(position: Floats, rate: float) -> float:
    """Return the highest frequency (Hz) of the motion in positions (n,) sampled at a ``rate`` (Hz), 0 where they rest.

    99.99 % of the positions' power lies below it, noise excluded.
    """
    count = position.size
    if count < 16 or np.ptp(position) == 0.0:
        return 0.0
    spectrum = np.fft.rfft((position - np.linspace(position[0], position[-1], count)) * np.hanning(count))
    frequency = np.fft.rfftfreq(count, 1.0 / rate)
    power = np.square(np.abs(spectrum))
    floor = float(np.median(power[3 * power.size // 4 :]))
    # The power of noise in one bin is exponentially distributed, so hardly any bin reaches so far above the median.
    # The power of position is counted rather than that of velocity, where the spectral lines of a coarse encoder would
    # weigh too much.
    motion = np.cumsum(np.where(power > ABOVE_NOISE * floor, power, 0.0))
    if motion[-1] <= 0.0:
        return 0.0
    return float(frequency[np.searchsorted(motion, MOTION_POWER * motion[-1])])


def quickest_motion(position: Floats, pieces: Sequence[slice], rate: float, sliding: Sequence[bool]) -> float:
    """Return the highest frequency (Hz) of the motion of several joints (n, joints), ``sliding`` or not (joints,).

    Each joint is examined in the one of the ``pieces`` in which it travels farthest.  A joint that hardly moves
    compared to others of its kind is left out: at rest and over short travel, a joint vibrates with its drive.
    """
    travels = np.array([np.ptp(position[piece], axis=0) for piece in pieces])  # (pieces, joints)
    travel, slides = np.max(travels, axis=0), np.array(sliding)
    farthest = np.where(slides, np.max(travel[slides], initial=0.0), np.max(travel[~slides], initial=0.0))
    return max(
        (
            motion_frequency(position[pieces[where], joint], rate)
            for joint, where in enumerate(np.argmax(travels, axis=0).tolist())
            if travel[joint] > HARDLY * farthest[joint]
        ),
        default=0.0,
    )
