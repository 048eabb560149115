"""Motion too slow for a friction law: friction that still falls at the fastest speeds of a log."""

from __future__ import annotations

import numpy as np

from mjfriction.identify.fit import LawFit

UPPER = 0.4  # of the top speed, from which on friction's course is looked at
SURELY = 3.0  # deviations below none, that its slope must be
FEWEST_ROWS = 30
FASTER = "friction still falls at the fastest speed of this log: record faster motion"


def still_falls(fit: LawFit) -> bool:
    """Return whether friction falls with speed at the fastest speeds that a joint's motion has, beyond chance.

    It is the slope of the measured friction over speed, with a deviation clustered over the blocks of motion.  A level
    and a damping that are fitted to such motion are those of the falling part: on this side of the minimum of a
    Stribeck curve, every law finds more Coulomb friction than there is, and no damping.
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
