"""The noise of a joint's rows, measured on what a fit leaves of them where friction's direction is not in doubt."""

from __future__ import annotations

import numpy as np

from mjfriction.identify.gap import Gap
from mjfriction.record.log import Floats

SURE = 0.1  # share of the noise that doubt about friction's direction may add to a row the noise is measured on
FEWEST_SURE = 50  # rows; with fewer all are taken, of which the median leaves the doubtful ones out
LEAST_NOISE = 1e-3  # of the joint's RMS effort; no model of a machine is better than that
DEVIATIONS = 1.4826  # of a normal distribution, for a median absolute value of one


def least_noise(gap: Gap) -> Floats:
    """Return the noise below which no joint's rows are believed, (joints,): the sensor's, or a share of the effort."""
    effort = np.sqrt(np.mean(np.square(np.nan_to_num(gap.measured)), axis=0))
    return np.asarray(np.maximum(np.nan_to_num(gap.noise_floor), LEAST_NOISE * effort))


def row_noise(gap: Gap, joint: int, left: Floats, noise: float) -> float:
    """Return the noise (N·m, N) of what is left (rows,) at a joint; ``noise`` is what it was taken for so far."""
    sure = gap.doubt[:, joint] < SURE * noise
    values = left[sure] if np.count_nonzero(sure) > FEWEST_SURE else left
    return max(float(least_noise(gap)[joint]), DEVIATIONS * float(np.median(np.abs(values))))
