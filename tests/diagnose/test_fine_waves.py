"""Waves as fine as a gear's teeth, that pass by within the rows' band only while the joint is slow."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from mjfriction.diagnose.diagnosis import diagnose_log
from mjfriction.diagnose.tell.outcome import Verdict
from mjfriction.record.readers import read_log
from mjfriction.robot.files import read_robot
from tests.hidden.machine import UR5_JOINTS, Instant, Machine, write_case

ELBOW = 2
TEETH, AMPLITUDE = 100.0, 2.5  # to a turn by 2π, N·m


def cogs(at: Instant) -> np.ndarray:
    return AMPLITUDE * np.cos(TEETH * at.q)


@pytest.mark.deep
def test_they_are_found_though_the_joint_is_mostly_too_fast(tmp_path: Path) -> None:
    machine = Machine(noise=0.1, encoder_bits=16, hidden={ELBOW: cogs})
    log, robot = write_case(tmp_path, machine, seed=6, seconds=30.0)
    found = diagnose_log(read_log(log), read_robot(robot))
    speed = np.abs(found.gap.motion.velocity[:, ELBOW])
    assert TEETH * np.median(speed) > 1.3 * 2.0 * np.pi * found.gap.chain.band
    assert found.verdict is Verdict.EXPLAINED
    (finding,) = found.findings
    assert (finding.cause, finding.joint) == ("drive.cogging", UR5_JOINTS[ELBOW])
    cosine, sine, wavenumber = (fitted.value for fitted in finding.parameters)
    assert np.hypot(cosine, sine) == pytest.approx(AMPLITUDE, rel=0.05)
    assert wavenumber == pytest.approx(TEETH, rel=1e-3)
