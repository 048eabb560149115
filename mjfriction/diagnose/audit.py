"""Faults of a log that would otherwise be blamed on physics."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mjfriction.diagnose.gap import Gap

ALIKE = 0.9  # correlation from which on an effort is taken as the image of a prediction
UNLIKE = 0.6  # and under which it is not
MOST_OFF = 5.0  # times too large or small, past which no constant of a drive is off


@dataclass(frozen=True)
class Fault:
    """A fault of the log: its ``kind`` (``data.sign``, ``data.unit``, ``data.swap``), where, and what to do."""

    kind: str
    where: str
    action: str


def find_faults(gap: Gap) -> list[Fault]:
    """Hold every joint's effort against what the robot says it needs, and name what no physics does.

    A clear likeness to the prediction with its sign turned, or many times too large or small, or to another joint's
    prediction that in turn looks like this one's, is a fault of signs, units or wiring.
    """
    examined = list(gap.examined)
    predicted = gap.chain.rows(gap.effort.reported)[:, examined]
    measured = gap.measured[:, examined]
    measured, predicted = (values - np.mean(values, axis=0) for values in (measured, predicted))
    size = np.sqrt(np.outer(np.sum(np.square(measured), axis=0), np.sum(np.square(predicted), axis=0)))
    likeness = np.divide(measured.T @ predicted, size, out=np.zeros_like(size), where=size > 0.0)
    faults = []
    for i, joint in enumerate(examined):
        name = gap.robot.joints[joint]
        column = f"{gap.motion.quantity[joint]}.{name}"
        own = likeness[i, i]
        factor = float(np.sqrt(np.mean(np.square(measured[:, i])) / max(np.mean(np.square(predicted[:, i])), 1e-300)))
        for j in range(i):
            other = gap.robot.joints[examined[j]]
            crossed = min(likeness[i, j], likeness[j, i])
            if crossed > ALIKE and max(own, likeness[j, j]) < UNLIKE:
                faults.append(Fault("data.swap", f"{column} and that of {other}", "exchange the two columns"))
        if own < -ALIKE and 1.0 / MOST_OFF < factor < MOST_OFF:
            faults.append(Fault("data.sign", column, "turn its sign"))
        elif abs(own) > ALIKE and not 1.0 / MOST_OFF < factor < MOST_OFF:
            action = f"it reads {factor:.3g} times what the robot needs; convert it to N·m or N at the joint, or A"
            faults.append(Fault("data.unit", column, action))
    return faults
