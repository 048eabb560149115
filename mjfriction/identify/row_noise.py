"""The noise of a joint's rows, estimated from a fit's residual where friction's direction is not in doubt."""

from __future__ import annotations

import numpy as np

from mjfriction.identify.gap import Gap
from mjfriction.record.log import Floats

# Share of the noise that the doubt about friction's direction may reach in a row for the noise to be measured on it.
SURE = 0.1
FEWEST_SURE = 50  # rows; with no more of them, all rows are taken, and the median discounts the doubtful ones
LEAST_NOISE = 1e-3  # of the joint's RMS effort; no model of a machine is better than that
DEVIATIONS = 1.4826  # standard deviation of a normal distribution whose median absolute value is one


def least_noise(gap: Gap) -> Floats:
    """Return the least noise that each joint's rows may be given, (joints,): the sensor's, or a share of the effort."""
    effort = np.sqrt(np.mean(np.square(np.nan_to_num(gap.measured)), axis=0))
    return np.asarray(np.maximum(np.nan_to_num(gap.noise_floor), LEAST_NOISE * effort))


def row_noise(gap: Gap, joint: int, left: Floats, noise: float) -> float:
    """Return the noise (N·m, N) of a joint's residual ``left`` (rows,); ``noise`` is its estimate so far."""
    sure = gap.doubt[:, joint] < SURE * noise
    values = left[sure] if np.count_nonzero(sure) > FEWEST_SURE else left
    return max(float(least_noise(gap)[joint]), DEVIATIONS * float(np.median(np.abs(values))))
