"""A torque constant a little off beside causes at half of the joints of a robot that is else stated exactly."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from mjfriction.diagnose.diagnosis import diagnose_log
from mjfriction.diagnose.search import second_look
from mjfriction.record.readers import read_log
from mjfriction.robot.files import read_robot
from tests.hidden.machine import UR5_COULOMB, UR5_JOINTS, UR5_VISCOUS, Machine, write_case

PAN, LIFT, ELBOW = 0, 1, 2
FACTOR = 1.035


HIDDEN = {
    PAN: lambda now: 0.25 * UR5_COULOMB[PAN] * np.cos(14.0 * now.q) * np.sign(now.v),
    LIFT: lambda now: (FACTOR - 1.0) * (now.rigid + now.friction),
    ELBOW: lambda now: 0.4 * UR5_VISCOUS[ELBOW] * np.abs(now.v),
}


@pytest.mark.deep
def test_it_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    log, robot = write_case(tmp_path, Machine(hidden=HIDDEN, noise=0.1), seed=3)

    def named() -> set[tuple[str, str | None]]:
        return {(one.cause, one.joint) for one in diagnose_log(read_log(log), read_robot(robot)).findings}

    beside = {("friction.position", UR5_JOINTS[PAN]), ("friction.asymmetry", UR5_JOINTS[ELBOW])}
    assert named() == beside | {("drive.torque_constant", UR5_JOINTS[LIFT])}
    monkeypatch.setattr(second_look, "FEWEST_JOINTS", 7)
    assert named() == beside
