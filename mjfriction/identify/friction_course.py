"""One joint's friction along a log: the effort that links, cogging and springs leave."""

from __future__ import annotations

from dataclasses import dataclass

from mjfriction.errors import LogError
from mjfriction.record.log import Floats, Log, check_joints
from mjfriction.record.motion import Motion
from mjfriction.robot.bandwidth import choose_cutoff
from mjfriction.robot.effort import as_given, effort_per_reported, predict_effort, without_offsets
from mjfriction.robot.measured_motion import measured_motion
from mjfriction.robot.robot import Robot


@dataclass(frozen=True)
class FrictionCourse:
    """One joint's ``friction`` (n,), N·m or N, along the ``motion`` of its robot; ``joint`` is its index there."""

    motion: Motion
    joint: int
    friction: Floats

    @property
    def position(self) -> Floats:
        """The joint's position, (n,)."""
        return self.motion.position[:, self.joint]

    @property
    def velocity(self) -> Floats:
        """The joint's velocity, (n,)."""
        return self.motion.velocity[:, self.joint]


def friction_course(log: Log, robot: Robot, joint: str, band: float | None = None) -> FrictionCourse:
    """Return a joint's friction along a log, ignoring its stated friction and trusting the rest of the robot.

    With a ``band`` (Hz) it is low-passed without phase lag.  Raises :class:`LogError` where the log has no effort of
    that joint, :class:`~mjfriction.errors.RobotError` for a joint that the robot does not have.
    """
    place = robot.joints.index(robot.joint(joint).name)
    bare = robot.with_joint(robot.joint(joint).model_copy(update={"friction": ()}))
    body = bare.body()
    bare = bare.with_stated_friction(body)
    check_joints(log, bare.name, bare.joints)
    motion = measured_motion(log, bare, body, choose_cutoff(log, bare, body))
    if motion.quantity[place] is None:
        raise LogError(f"{log.source}: no effort.{joint} or current.{joint}; friction cannot be told without one")
    own = bare.table.joint[place]
    reported = motion.torque[:, place] * effort_per_reported(own, motion.quantity[place], bare.name)
    given = as_given(own, reported, motion, without_offsets(bare, motion).position[:, place])
    friction = given - predict_effort(bare, body, motion).total[:, place]
    return FrictionCourse(motion, place, friction if band is None else motion.low_passed(friction, band))
