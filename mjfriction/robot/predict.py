"""Predict what a log would have read according to a robot file."""

from __future__ import annotations

from mjfriction.record.log import Floats, Log, check_joints
from mjfriction.record.motion import back_to_log
from mjfriction.robot.bandwidth import choose_cutoff
from mjfriction.robot.effort import effort_per_reported, predict_effort
from mjfriction.robot.measured_motion import measured_motion
from mjfriction.robot.robot import Robot


def predict_log(log: Log, robot: Robot) -> dict[str, Floats]:
    """Return ``time`` and, for every effort or current in the log, the reading that the robot file predicts.

    All columns have the rows of the log's file; rows that were dropped as faulty, and those in stretches too short to
    differentiate, are NaN.  Raises :class:`~mjfriction.errors.LogError` or :class:`~mjfriction.errors.RobotError` if
    the log or the robot cannot be used.
    """
    body = robot.body()
    robot = robot.with_stated_friction(body)
    check_joints(log, robot.name, robot.joints)
    motion = measured_motion(log, robot, body, choose_cutoff(log, robot, body))
    effort = predict_effort(robot, body, motion)
    columns = {"time": log.time if log.recorded is None else log.recorded}
    for i, joint in enumerate(robot.table.joint):
        quantity = motion.quantity[i]
        if quantity is not None:
            reported = effort.reported[:, i] / effort_per_reported(joint, quantity, robot.name)
            columns[f"{quantity}.{joint.name}"] = log.as_recorded(back_to_log(motion, log, reported))
    return columns
