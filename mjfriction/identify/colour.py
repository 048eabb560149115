"""How much of a residual is no noise, whatever it follows: what stands above the noise in its spectrum."""

from __future__ import annotations

import numpy as np

from mjfriction.identify.gap import Gap
from mjfriction.record.log import Floats

NOTHING = "nothing that is known"  # what a course follows that is no noise, nor any covariate's
COLOURED = 0.5  # share of what is left that may stand above the noise in its spectrum before it counts
BINS = 60  # of the spectrum, even in frequency
FASTEST = 1.0 / 3.0  # of the spectrum, whose level no slow course raises
STANDS_OUT = 4.0  # deviations of a bin above the noise's level
SLOWEST = 2  # lines of the spectrum that hold the mean, and the window's own leakage of it
WINDOW_LOSS = 1.5  # how many lines of a Hann window's spectrum count for one


def coloured_share(gap: Gap, joint: int, residual: Floats) -> float:
    """Return the share of a joint's residual (rows,) that stands above the noise in its spectrum, 0 to 1.

    The rows are so thin that white noise stays white.  Its level is that of the effort sensor, or of the spectrum's
    fastest third where that is higher; what is slower and stands clear of it is a course: a wander, a hum, a swing.
    White noise gives 0, and so does noise that grows with frequency, as that of differentiated positions does.
    """
    clear = gap.clear[:, joint]
    if not np.any(clear):
        return 0.0
    window = np.where(clear, np.hanning(clear.size), 0.0)
    power = np.square(np.abs(np.fft.rfft(window * np.where(clear, residual, 0.0))))[SLOWEST:]
    width = max(1, power.size // BINS)
    bins = power[: power.size // width * width].reshape(-1, width).mean(axis=1)
    fastest = float(np.mean(power[-int(FASTEST * power.size) :]))
    level = max(fastest, float(gap.noise_floor[joint] ** 2 * np.sum(np.square(window))))
    above = np.where(bins > level * (1.0 + STANDS_OUT * np.sqrt(WINDOW_LOSS / width)), bins - level, 0.0)
    return float(np.sum(above) / max(float(np.sum(bins)), 1e-300))
