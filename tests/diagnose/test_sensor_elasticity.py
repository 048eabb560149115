"""A sensor that moves with the load on its joint, whose friction follows the link."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from mjfriction.diagnose import diagnosis
from mjfriction.diagnose.causes.cause import Site
from mjfriction.diagnose.causes.elasticity import SensorElasticity
from mjfriction.diagnose.diagnosis import diagnose_log
from mjfriction.diagnose.tell.outcome import Diagnosis, Verdict
from mjfriction.identify.measure import measure_gap
from mjfriction.record.readers import read_log
from mjfriction.robot.files import read_robot
from tests.hidden.machine import UR5_JOINTS, Machine, write_case

WRIST, COMPLIANCE = 4, 0.018


@pytest.fixture(scope="module")
def case(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path]:
    soft = Machine(sensed={WRIST: lambda at: COMPLIANCE * at.rigid})
    return write_case(tmp_path_factory.mktemp("soft"), soft, seed=4)


def diagnosed(case: tuple[Path, Path]) -> Diagnosis:
    return diagnose_log(read_log(case[0]), read_robot(case[1]))


@pytest.mark.deep
def test_where_friction_points_tells_that_a_sensor_moves_with_the_load(case: tuple[Path, Path]) -> None:
    found = diagnosed(case)
    (finding,) = found.findings
    assert (finding.cause, finding.joint) == ("drive.elasticity", UR5_JOINTS[WRIST])
    assert finding.parameters[0].value == pytest.approx(COMPLIANCE, rel=0.05)
    wrist = found.joints[WRIST]
    assert wrist.rms_heldout_after < 1.1 * wrist.noise_floor < 0.75 * wrist.rms_heldout_before
    # The extended robot has it, and a log of it is then as it should be.
    again = diagnose_log(read_log(case[0]), found.robot)
    assert (again.verdict, again.findings) == (Verdict.CONSISTENT, ())


@pytest.mark.deep
def test_friction_on_the_motor_s_side_does_not_do_as_well(
    case: tuple[Path, Path], monkeypatch: pytest.MonkeyPatch
) -> None:
    others = tuple(cause for cause in diagnosis.STRUCTURAL if not isinstance(cause, SensorElasticity))
    monkeypatch.setattr(diagnosis, "STRUCTURAL", others)
    wrist = diagnosed(case).joints[WRIST]
    assert wrist.rms_heldout_after > 1.4 * wrist.noise_floor


@pytest.mark.parametrize(("noise", "told"), [(0.05, True), (2.0, False)])
def test_what_is_smaller_than_the_noise_is_none(noise: float, told: bool, tmp_path: Path) -> None:
    log, robot = write_case(tmp_path, Machine(noise=noise), seed=4, seconds=10.0)
    gap = measure_gap(read_log(log), read_robot(robot))
    site = Site(WRIST, around=COMPLIANCE)
    assert SensorElasticity().admissible(gap, site, np.array([COMPLIANCE])) is told
