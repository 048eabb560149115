"""An offset that was identified along with friction alike in both directions stands for half of an asymmetry."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from mjfriction.diagnose import diagnosis as module
from mjfriction.diagnose.causes.asymmetry import AsymmetryWithOffset
from mjfriction.diagnose.diagnosis import diagnose_log
from mjfriction.record.readers import read_log
from mjfriction.robot.files import read_robot
from tests.hidden.machine import Machine, write_case

ELBOW, ASYMMETRY = 2, -6.0


def test_the_asymmetry_brings_the_offset_back(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    machine = Machine(hidden={ELBOW: lambda at: ASYMMETRY * np.abs(at.v)}, noise=0.05)
    case = write_case(tmp_path, machine, seed=4, seconds=40.0)
    log, right = read_log(case[0]), read_robot(case[1])
    elbow = right.joint("elbow_joint")
    speed = float(np.mean(np.abs(np.gradient(log.columns["position.elbow_joint"], log.time))))
    sensor = elbow.effort_sensor.model_copy(update={"offset": ASYMMETRY * speed})
    stated = right.with_joint(elbow.model_copy(update={"effort_sensor": sensor}))
    found = diagnose_log(log, stated)
    (finding,) = found.findings
    assert (finding.cause, finding.joint) == ("friction.asymmetry", "elbow_joint")
    damping, offset = finding.parameters
    assert damping.value == pytest.approx(ASYMMETRY, rel=0.01)
    assert abs(offset.value) < 0.02 * abs(sensor.offset)
    assert found.robot.joint("elbow_joint").effort_sensor.offset == pytest.approx(offset.value)
    # Without the two as one question, a sound sensor is blamed as well.
    rest = tuple(cause for cause in module.STRUCTURAL if not isinstance(cause, AsymmetryWithOffset))
    monkeypatch.setattr(module, "STRUCTURAL", rest)
    assert "drive.offset" in {one.cause for one in diagnose_log(log, stated).findings}
