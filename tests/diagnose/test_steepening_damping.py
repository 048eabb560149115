"""Damping that grows with the cube of speed, far beyond what is stated: a quadratic term takes damping below none."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from mjfriction.diagnose.causes.steepening_viscous import SteepeningViscous
from mjfriction.diagnose.diagnosis import diagnose_log
from mjfriction.diagnose.tell.outcome import Diagnosis, Verdict
from mjfriction.record.readers import read_log
from mjfriction.robot.files import read_robot
from tests.hidden.machine import Instant, Machine, write_case

WRIST, CUBIC = 5, 12.0
# Next to no damping is stated there.
VISCOUS = (11.0, 14.0, 8.0, 2.0, 1.6, 0.02)


def cubic(at: Instant) -> np.ndarray:
    return CUBIC * at.v**3


@pytest.mark.deep
def test_the_power_of_speed_is_found(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    log, robot = write_case(tmp_path, Machine(viscous=VISCOUS, hidden={WRIST: cubic}, noise=0.05), seed=4, seconds=22.0)

    def diagnosed() -> Diagnosis:
        return diagnose_log(read_log(log), read_robot(robot))

    found = diagnosed()
    assert found.verdict is Verdict.EXPLAINED
    (finding,) = found.findings
    assert (finding.cause, finding.joint) == ("friction.viscous_nonlinear", "wrist_3_joint")
    told = {value.name: value for value in finding.parameters}
    assert told["power"].low < 3.0 < told["power"].high
    assert told["power"].high - told["power"].low < 0.2
    assert told["power_coefficient"].value == pytest.approx(CUBIC, rel=0.05)
    # The robot file holds it.
    gap = found.gap
    left = gap.rms((gap.measured - gap.predicted(found.robot))[:, WRIST], WRIST)
    assert left == pytest.approx(gap.noise_floor[WRIST], rel=0.05)
    monkeypatch.setattr(SteepeningViscous, "sites", lambda *_: [])
    assert diagnosed().verdict is not Verdict.EXPLAINED
