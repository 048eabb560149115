"""How quickly a joint moves."""

from __future__ import annotations

import numpy as np

from mjfriction.record.log import Floats

MOTION_POWER = 0.9999  # share of the position's power that counts as the motion
ABOVE_NOISE = 30.0  # times the noise's power in a bin from which on the bin is taken as motion


def motion_frequency(position: Floats, rate: float) -> float:
    """Return the highest frequency (Hz) of the motion in positions (n,) sampled at a ``rate`` (Hz), 0 where they rest.

    Up to it are 99.99 % of their power, what is noise left out.
    """
    count = position.size
    if count < 16 or np.ptp(position) == 0.0:
        return 0.0
    spectrum = np.fft.rfft((position - np.linspace(position[0], position[-1], count)) * np.hanning(count))
    frequency = np.fft.rfftfreq(count, 1.0 / rate)
    power = np.square(np.abs(spectrum))
    floor = float(np.median(power[3 * power.size // 4 :]))
    # The power of noise in one bin is exponentially distributed: next to none of it reaches so far above its median.
    # Position's power is counted, not velocity's, in which the lines of a coarse encoder would weigh too much.
    motion = np.cumsum(np.where(power > ABOVE_NOISE * floor, power, 0.0))
    if motion[-1] <= 0.0:
        return 0.0
    return float(frequency[np.searchsorted(motion, MOTION_POWER * motion[-1])])
