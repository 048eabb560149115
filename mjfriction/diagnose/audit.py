"""Faults of a log that would otherwise be blamed on physics."""

from __future__ import annotations

import numpy as np
from scipy.optimize import nnls

from mjfriction.body.inverse import inverse_dynamics
from mjfriction.diagnose.units import find_unit_faults
from mjfriction.identify.gap import Gap
from mjfriction.record.faults import Fault
from mjfriction.record.log import Floats

ALIKE = 0.9  # correlation from which on an effort is taken as the image of a prediction
UNLIKE = 0.6  # and under which it is not
SAMPLES = 1500  # of a log that positions are judged by
POOR = 0.25  # of an effort's variance left unexplained, past which columns may be misplaced
MENDED = 0.3  # of that, which may be left once they are in their places
MOST_OFF = 5.0  # times too large or small, past which no constant of a drive is off


def find_faults(gap: Gap) -> list[Fault]:
    """Hold every joint's effort against what the robot says it needs, and name what no physics does.

    A clear likeness to the prediction with its sign turned, or many times too large or small, or to another joint's
    prediction that in turn looks like this one's, is a fault of signs, units or wiring.  Then positions in a unit, with
    a sign or at a joint that they should not have.
    """
    return find_unit_faults(gap.log, gap.body) or find_misread(gap) or find_misplaced(gap)


def find_misread(gap: Gap) -> list[Fault]:
    """Return the effort columns that look like no prediction, but like one turned, scaled, or of another joint."""
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


def find_misplaced(gap: Gap) -> list[Fault]:
    """Return the position column whose sign is turned, or the two that are exchanged, if that makes the efforts fit.

    Efforts that a model explains badly, but well once one column is turned or two are exchanged, are no physics.
    """
    motion, body = gap.motion, gap.body
    rows = np.arange(0, motion.time.size, max(1, motion.time.size // SAMPLES))
    course = [values[rows] for values in (motion.position, motion.velocity, motion.acceleration)]
    effort = (motion.torque * gap.per_reported)[rows][:, list(gap.examined)]

    def unexplained(changed: list[Floats]) -> Floats:
        rigid = inverse_dynamics(body, *changed)[:, list(gap.examined)]
        velocity = changed[1][:, list(gap.examined)]
        left = []
        for own, torque, speed in zip(effort.T, rigid.T, velocity.T, strict=True):
            one = np.ones_like(speed)
            columns = np.column_stack([torque, np.sign(speed), speed, one, -one])
            # A weight below none, or friction that drives, is no explanation.
            left.append(float(nnls(columns, own)[1]) ** 2 / max(own.size * float(np.var(own)), 1e-300))
        return np.asarray(left)

    as_logged = unexplained(course)
    poor = as_logged > POOR
    if not np.any(poor):
        return []
    count = len(gap.robot.joints)
    names = gap.robot.joints
    best: tuple[float, Fault] | None = None
    for i in range(count):
        turned = [values * np.where(np.arange(count) == i, -1.0, 1.0) for values in course]
        kinds = [(turned, Fault("data.sign", f"position.{names[i]}", "turn its sign"))]
        for j in range(i):
            order = np.arange(count)
            order[[i, j]] = order[[j, i]]
            where = f"position.{names[i]} and that of {names[j]}"
            kinds.append(
                ([values[:, order] for values in course], Fault("data.swap", where, "exchange the two columns"))
            )
        for changed, fault in kinds:
            left = unexplained(changed)
            mended = bool(np.all(left[poor] < MENDED * as_logged[poor]))
            if mended and (best is None or float(np.sum(left)) < best[0]):
                best = (float(np.sum(left)), fault)
    return [best[1]] if best is not None else []
