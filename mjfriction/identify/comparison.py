"""Several robots compared with one log, side by side."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from mjfriction.errors import RobotError
from mjfriction.identify.gap import Gap
from mjfriction.identify.measure import gap_of, measure_gap
from mjfriction.identify.stretches import simulated_error
from mjfriction.progress import Tell, counting, silently
from mjfriction.record.log import Log
from mjfriction.robot.effort import reported_unit
from mjfriction.robot.robot import Robot

ALIKE = 1.02  # times the best robot's error at every joint, up to which no robot counts as nearer


@dataclass(frozen=True)
class ModelError:
    """The RMS error of one robot at one joint.

    ``effort`` is in N·m or N at the joint; ``current`` in A at the motor, None where the robot states no torque
    constant; ``share`` is relative to the measured effort's RMS.  ``position``, rad or m, is the error of the joint's
    course where the efforts drive the robot freely, None where that was not asked for.
    """

    effort: float
    current: float | None
    share: float
    position: float | None = None


@dataclass(frozen=True)
class JointComparison:
    """The errors of all robots at a joint, in the robots' order, and the sensor's noise in N·m or N."""

    joint: str
    unit: str
    measured: float
    noise_floor: float
    errors: tuple[ModelError, ...]

    @property
    def position_unit(self) -> str:
        """The unit of the joint's position."""
        return "m" if self.unit == "N" else "rad"


@dataclass(frozen=True)
class Comparison:
    """The ``gaps`` of the robots ``names``, in that order, all along one motion and at the same rows.

    ``seconds`` is how long the robots were driven freely at a time, None where they were not.
    """

    names: tuple[str, ...]
    gaps: tuple[Gap, ...]
    joints: tuple[JointComparison, ...]
    seconds: float | None = None

    @property
    def gap(self) -> Gap:
        """The first robot's gap."""
        return self.gaps[0]

    @property
    def best(self) -> str:
        """The robot with the least error, relative to the measured effort and averaged over the joints."""
        shares = [np.mean([joint.errors[k].share for joint in self.joints]) for k in range(len(self.names))]
        return self.names[int(np.argmin(shares))]

    @property
    def summary(self) -> str:
        """A sentence that says which robot is nearest to the log, and by how much."""
        least = self.names.index(self.best)
        joint = max(self.joints, key=lambda j: max(e.effort for e in j.errors) / max(j.errors[least].effort, 1e-300))
        most = max(range(len(self.names)), key=lambda k: joint.errors[k].effort)
        if joint.errors[most].effort < ALIKE * joint.errors[least].effort:
            return (
                f"They are equally near to the log, within {100 * (ALIKE - 1.0):.0f} % at every joint: nothing is left "
                "to choose by."
            )
        return (
            f"{self.best} is nearest to the log; they differ most at {joint.joint}: "
            f"{joint.errors[least].effort:.3g} {joint.unit} there, {self.names[most]} "
            f"{joint.errors[most].effort:.3g} {joint.unit}."
        )


def compare_robots(
    log: Log, robots: Sequence[tuple[str, Robot]], tell: Tell = silently, *, simulated: float | None = None
) -> Comparison:
    """Compare named robots with the same joints with a log.

    Errors are over the same rows for all, through one low-pass (see :mod:`mjfriction.identify.rows`).  Only rows where
    the joint moves count, because at rest and in reversals friction may be anything within its level.  With
    ``simulated`` the log's efforts also drive every robot freely, that many seconds at a time (infinite: the whole
    log).  ``tell`` is called with the robot that is compared.  Raises :class:`RobotError` where the robots do not have
    the same joints or two have one name, and what :func:`measure_gap` raises.
    """
    names = [name for name, _ in robots]
    if len(names) < 2:
        raise RobotError("one robot compares with nothing; give --robot once for each")
    if len(set(names)) < len(names):
        raise RobotError(f"two robots are called '{max(names, key=names.count)}'; give each once")
    first = robots[0][1]
    for name, robot in robots[1:]:
        if robot.joints != first.joints:
            raise RobotError(
                f"{name}: has joints {', '.join(robot.joints)}, but {robots[0][0]} has {', '.join(first.joints)}; "
                "compare robots with the same joints in the same order"
            )
    begin = counting(tell, len(robots))
    begin(f"holding the log against {names[0]}")
    gap = measure_gap(log, first, yielding=0.0)
    gaps = [gap]
    for name, robot in robots[1:]:
        begin(f"holding the log against {name}")
        gaps.append(gap_of(robot, gap))
    courses, seconds = [], None
    if simulated is not None:
        tell("driving the robots freely")
        ends = [simulated_error(own, robot, simulated) for (_, robot), own in zip(robots, gaps, strict=True)]
        courses, seconds = [course for course, _ in ends], ends[0][1]
    joints = []
    for joint in gap.examined:
        measured = gap.rms(gap.measured[:, joint], joint)
        errors = []
        for k, ((_, robot), own) in enumerate(zip(robots, gaps, strict=True)):
            rms = gap.rms(own.residual[:, joint], joint)
            worth = robot.table.joint[joint].actuator.effort_per_ampere
            current = None if worth is None else rms / abs(worth)
            position = float(courses[k][joint]) if courses else None
            errors.append(ModelError(rms, current, rms / max(measured, 1e-300), position))
        unit = reported_unit("effort", gap.body.sliding[joint])
        joints.append(
            JointComparison(gap.robot.joints[joint], unit, measured, float(gap.noise_floor[joint]), tuple(errors))
        )
    return Comparison(tuple(names), tuple(gaps), tuple(joints), seconds)
