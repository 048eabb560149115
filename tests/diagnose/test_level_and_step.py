"""A friction level that is off, and steps besides: the step's moment may not move to make up for the level."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from mjfriction.diagnose.diagnosis import diagnose_log
from mjfriction.record.readers import read_log
from mjfriction.robot.files import read_robot
from tests.hidden.machine import UR5_COULOMB, Instant, Machine, write_case

WRIST, MOMENT = 4, 19.0  # s
LEVEL, STEP = 0.48 * UR5_COULOMB[WRIST], 0.37 * UR5_COULOMB[WRIST]


def higher_and_stepping(at: Instant) -> np.ndarray:
    return (LEVEL + STEP * (at.time > MOMENT)) * np.sign(at.v)


@pytest.mark.deep
def test_a_level_that_is_off_and_a_step_are_told_as_two(tmp_path: Path) -> None:
    log, robot = write_case(tmp_path, Machine(hidden={WRIST: higher_and_stepping}, noise=0.1), seed=4)
    findings = diagnose_log(read_log(log), read_robot(robot)).findings
    told = {finding.cause: finding.parameters[0].value for finding in findings}
    assert told.keys() == {"friction.coulomb_viscous", "event.change"}
    assert told["friction.coulomb_viscous"] == pytest.approx(UR5_COULOMB[WRIST] + LEVEL, rel=0.03)
    assert told["event.change"] == pytest.approx(STEP, rel=0.1)
