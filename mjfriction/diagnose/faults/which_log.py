"""Find the joined logs that alone show what remains unexplained: what differed then is not in the robot file."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from mjfriction.identify.gap import Gap
from mjfriction.identify.structure import Structure

LOUDER = 4.0  # multiple of the quietest log's mean square residual above which a log is one of these


def logs_with(gap: Gap, remaining: Sequence[Structure]) -> tuple[str, ...]:
    """Return the names of the logs in which the stated robot is far more off than in the quietest one, at every joint
    where something remains unexplained.

    There are none if it is about as far off in all logs, or if such a joint moves in only one of them.
    """
    joined = gap.log.joined
    if len(joined) < 2 or not remaining:
        return ()
    log_of = np.searchsorted([begin for _, begin in joined], gap.chain.time, side="right") - 1
    loud = np.ones(len(joined), dtype=bool)
    for entry in remaining:
        joint = gap.robot.joints.index(entry.joint)
        told = gap.clear[:, joint]
        power = {k: np.mean(np.square(gap.residual[told & (log_of == k), joint])) for k in np.unique(log_of[told])}
        if len(power) < 2:
            return ()  # the joint moved in one of them only
        quietest = min(power.values())
        loud &= [power.get(k, 0.0) > LOUDER * quietest for k in range(len(joined))]
    return tuple(name for (name, _), own in zip(joined, loud.tolist(), strict=True) if own)
