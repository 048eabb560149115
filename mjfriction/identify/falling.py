"""Motion too slow for a friction law: friction that still falls at the fastest speeds of a log."""

from __future__ import annotations

import numpy as np

from mjfriction.identify.fit import LawFit

UPPER = 0.4  # share of the top speed above which friction's slope is examined
SURELY = 3.0  # deviations by which the slope must be below zero
FEWEST_ROWS = 30
FASTER = "friction still falls at the fastest speed of this log: record faster motion"


def still_falls(fit: LawFit) -> bool:
    """Return whether friction falls with speed at the fastest speeds of a joint's motion, beyond chance.

    The test takes the slope of the measured friction over speed, with a deviation clustered over the blocks of motion.
    A level and a damping fitted to such motion describe the falling part.  Below the minimum of a Stribeck curve, every
    law finds more Coulomb friction than there is, and no damping.
    """
    problem = fit.problem
    gap, joint = problem.gap, problem.joint
    velocity = gap.at_rows("velocity")[:, joint]
    speed = np.abs(velocity)
    clear = gap.clear[:, joint] & (speed > UPPER * gap.motion.top_speed[joint])
    if np.sum(clear) < FEWEST_ROWS:
        return False
    rubbing = problem.target[clear] * np.sign(velocity[clear])
    fast, block = speed[clear] - np.mean(speed[clear]), gap.blocks.row[clear]
    spread = float(np.sum(np.square(fast)))
    slope = float(fast @ rubbing) / spread
    left = fast * (rubbing - np.mean(rubbing) - slope * fast)
    deviation = float(np.sqrt(np.sum(np.square(np.bincount(block, left))))) / spread
    return slope < -SURELY * deviation
