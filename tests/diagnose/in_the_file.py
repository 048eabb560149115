"""Reading the robot file of a diagnosis again: what it leaves of the log."""

from __future__ import annotations

from pathlib import Path

from mjfriction.diagnose.tell.outcome import Diagnosis
from mjfriction.record.log import Floats
from mjfriction.robot.effort import predict_effort
from mjfriction.robot.files import read_robot, write_robot


def left_by_the_file(found: Diagnosis, folder: Path) -> Floats:
    """Return the measured effort less what the extended robot, written and read, predicts, (rows, joints)."""
    folder.mkdir()
    robot, gap = read_robot(write_robot(found.robot, folder)), found.gap
    return gap.measured - gap.chain.rows(predict_effort(robot, robot.body(), gap.motion).reported)
