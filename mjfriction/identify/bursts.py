"""How much of a residual is in bursts: few rows far above the rest, which no noise has."""

from __future__ import annotations

import numpy as np
from scipy.ndimage import binary_erosion

from mjfriction.identify.gap import Gap
from mjfriction.record.log import Floats

BURSTS = "bursts"  # named where a residual is in these
BURST_SHARE = 0.5  # share of a residual's mean square that may be in bursts before it counts
FAR_OUT = 5.0  # deviations from which on a row belongs to a burst
AS_DEVIATION = 1.4826  # deviation of a normal distribution, over the median of its absolute values
FEWEST_BURSTS = 5  # of a joint; fewer are accidents
APART = 4  # rows between two bursts
EDGE = 2  # rows next to one that is not clear: what a reversal leaves in the filter is no burst


def burst_share(gap: Gap, joint: int, residuals: Floats) -> float:
    """Return the share of a joint's mean square residual that is in bursts, 0 to 1; 0 where there are only few bursts.

    ``residuals`` are (rows, joints).  A burst stands out of both the sensor's noise and the residual's own usual size,
    by its median, and lies amid clear rows.
    """
    clear, size = gap.clear[:, joint], np.abs(residuals[:, joint])
    if not np.any(clear):
        return 0.0
    usual = max(float(gap.noise_floor[joint]), AS_DEVIATION * float(np.median(size[clear])))
    amid = binary_erosion(clear, iterations=EDGE, border_value=1)
    out = np.flatnonzero(amid & (size > FAR_OUT * usual))
    if np.count_nonzero(np.diff(out, prepend=-APART - 1) > APART) < FEWEST_BURSTS:
        return 0.0
    return float(np.sum(np.square(size[out])) / np.sum(np.square(size[clear])))
