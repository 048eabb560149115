"""Friction that differs between directions may have a constant part: an offset, told beside it where it is anything."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from mjfriction.diagnose.diagnosis import diagnose_log
from mjfriction.record.readers import read_log
from mjfriction.robot.files import read_robot
from tests.hidden.machine import UR5_COULOMB, UR5_VISCOUS, Machine, write_case

PAN = 0


@pytest.mark.parametrize(("offset", "told"), [(0.008, False), (0.02, True)])
def test_next_to_nothing_is_not_told(offset: float, tmp_path: Path, *, told: bool) -> None:
    level = offset * UR5_COULOMB[PAN]
    hidden = {PAN: lambda now: 0.3 * UR5_VISCOUS[PAN] * np.abs(now.v) + level}
    log, robot = write_case(tmp_path, Machine(hidden=hidden, noise=0.02), seed=4)
    diagnosis = diagnose_log(read_log(log), read_robot(robot))
    half = {"drive.offset"} if told else set()
    assert {one.cause for one in diagnosis.findings} == {"friction.asymmetry"} | half
    kept = diagnosis.robot.table.joint[PAN].effort_sensor.offset
    assert kept == pytest.approx(level, rel=0.5), "what is not told is built in all the same"
