"""The recorded motion of a robot, without the sensor jumps across play that its transmissions are stated to have."""

from __future__ import annotations

from dataclasses import replace

from mjfriction.body.model import Body
from mjfriction.record.jump_free import without_jumps
from mjfriction.record.jumps import Jumps, find_jumps
from mjfriction.record.log import Log
from mjfriction.record.motion import Motion, estimate_motion
from mjfriction.robot.effort import carry
from mjfriction.robot.robot import Robot


def measured_motion(log: Log, robot: Robot, body: Body, cutoff: float) -> Motion:
    """Estimate the motion of a robot's joints with a position filter of the given ``cutoff`` (Hz).

    Where the robot states play that is crossed instantly and the jumps are visible in the log, they are subtracted from
    the positions: the visible jumps tell better when the play was crossed than any predicted load.

    Raises what :func:`~mjfriction.record.motion.estimate_motion` raises.
    """
    motion = estimate_motion(log, robot.joints, cutoff, body.sliding)
    stated = {i: joint.transmission.jump for i, joint in enumerate(robot.table.joint) if joint.transmission.jump > 0.0}
    if not stated:
        return motion
    seen = seen_jumps(log, robot, body, motion)
    plays = {joint: (play, seen[joint].course) for joint, play in stated.items() if joint in seen}
    return without_jumps(log, motion, plays) if plays else motion


def seen_jumps(log: Log, robot: Robot, body: Body, motion: Motion) -> dict[int, Jumps]:
    """Return the jumps of a log's position sensors by joint; ``motion`` is the one estimated with the jumps in it."""
    tight = _jump_free(robot)
    return find_jumps(log, motion, lambda along: carry(tight, body, along).load)


def _jump_free(robot: Robot) -> Robot:
    joints = [joint.model_copy(update={"transmission": joint.transmission.jump_free}) for joint in robot.table.joint]
    return replace(robot, table=robot.table.model_copy(update={"joint": tuple(joints)}))
