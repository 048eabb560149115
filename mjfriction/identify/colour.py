"""How much of a residual is no noise, whatever it follows: what stands above the noise in its spectrum."""

from __future__ import annotations

import numpy as np

from mjfriction.identify.gap import Gap
from mjfriction.record.log import Floats

NOTHING = "nothing that is known"  # what a course follows that is no noise, nor any covariate's
COLOURED = 0.5  # share of what is left that may stand above the noise in its spectrum before it counts
BINS = 60  # of the spectrum, even in frequency
EVEN_BELOW = 6.0  # Hz, below which no drive's filter shapes its noise
AROUND = 2.0  # times a frequency and as many parts of it, over which noise is taken to be even
FASTEST = 1.0 / 3.0  # of the spectrum, whose level no slow course raises
STANDS_OUT = 4.0  # deviations of a bin above the noise's level
SLOWEST = 2  # lines of the spectrum that hold the mean, and the window's own leakage of it
WINDOW_LOSS = 1.5  # how many lines of a Hann window's spectrum count for one


def coloured_share(gap: Gap, joint: int, residual: Floats) -> float:
    """Return the share of a joint's residual (rows,) that stands above the noise in its spectrum, 0 to 1.

    The rows are so thin that white noise stays white.  Its level is that of the effort sensor, of the spectrum's
    fastest third, or of an octave to either side, whichever is highest: a drive's own filter takes the fastest of its
    noise away, from some ten Hz on, and leaves it even below.  What stands clear of that is a course: a wander, a hum,
    a swing.  White noise gives 0, and so does what was low-passed, and noise that grows with frequency, as that of
    differentiated positions does.
    """
    clear = gap.clear[:, joint]
    if not np.any(clear):
        return 0.0
    window = np.where(clear, np.hanning(clear.size), 0.0)
    power = np.square(np.abs(np.fft.rfft(window * np.where(clear, residual, 0.0))))[SLOWEST:]
    width = max(1, power.size // BINS)
    bins, frequency = (_binned(values, width) for values in (power, _frequencies(gap, clear.size)))
    fastest = float(np.mean(power[-int(FASTEST * power.size) :]))
    sensor = float(gap.noise_floor[joint] ** 2 * np.sum(np.square(window)))
    level = np.maximum(max(fastest, sensor), _around(bins, frequency))
    above = np.where(bins > level * (1.0 + STANDS_OUT * np.sqrt(WINDOW_LOSS / width)), bins - level, 0.0)
    return float(np.sum(above) / max(float(np.sum(bins)), 1e-300))


def _frequencies(gap: Gap, rows: int) -> Floats:
    return np.asarray(np.fft.rfftfreq(rows, gap.chain.step)[SLOWEST:])


def _binned(values: Floats, width: int) -> Floats:
    return np.asarray(values[: values.size // width * width].reshape(-1, width).mean(axis=1))


def _around(bins: Floats, frequency: Floats) -> Floats:
    # The middle of the bins within an octave of each, from where noise is even on.
    middle = np.maximum(frequency, min(EVEN_BELOW, float(frequency[-1])))
    near = np.abs(np.log(frequency[None, :] / middle[:, None])) <= np.log(AROUND)
    return np.array([np.median(bins[own]) for own in near])
