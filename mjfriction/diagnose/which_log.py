"""Of several logs, those in which alone there is what remains: what was different then is not in the robot file."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from mjfriction.identify.gap import Gap
from mjfriction.identify.structure import Structure
from mjfriction.record.log import JOINED

LOUDER = 4.0  # times the mean square that is left of the quietest log, that one of these leaves


def logs_with(gap: Gap, remaining: Sequence[Structure]) -> tuple[str, ...]:
    """Return the names of the logs in which the stated robot is far more off than in the others, at every joint where
    something remains; none where it is as far off in all of them, or there is but one.
    """
    names = gap.log.name.split(JOINED)
    if len(gap.log.begins) < 2 or not remaining:
        return ()
    log_of = np.searchsorted(gap.log.begins, gap.chain.time, side="right") - 1
    loud = np.ones(len(names), dtype=bool)
    for entry in remaining:
        joint = gap.robot.joints.index(entry.joint)
        clear = gap.clear[:, joint]
        left = [gap.residual[clear & (log_of == k), joint] for k in range(len(names))]
        power = np.array([np.mean(np.square(own)) if own.size else 0.0 for own in left])
        loud &= power > LOUDER * np.min(power)
    return tuple(name for name, own in zip(names, loud.tolist(), strict=True) if own)
