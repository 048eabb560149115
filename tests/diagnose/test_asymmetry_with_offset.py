"""An offset that was identified along with friction alike in both directions stands for half of an asymmetry."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from mjfriction.diagnose import diagnosis as module
from mjfriction.diagnose.causes.asymmetry import AsymmetryWithOffset
from mjfriction.diagnose.causes.cause import Site
from mjfriction.diagnose.causes.torque_constant import TorqueConstant
from mjfriction.diagnose.diagnosis import diagnose_log
from mjfriction.diagnose.fit.extend import extend_robot
from mjfriction.diagnose.fit.model import Chosen, build_model
from mjfriction.diagnose.fit.nuisance import make_nuisance
from mjfriction.identify.measure import measure_gap
from mjfriction.record.log import Log
from mjfriction.record.readers import read_log
from mjfriction.robot.files import read_robot
from mjfriction.robot.robot import Robot
from tests.hidden.machine import Machine, write_case

ELBOW, ASYMMETRY = 2, -6.0


def stated_with_offset(log: Log, right: Robot) -> Robot:
    """The robot with the offset at the elbow that friction alike in both directions leaves."""
    elbow = right.joint("elbow_joint")
    speed = float(np.mean(np.abs(np.gradient(log.columns["position.elbow_joint"], log.time))))
    sensor = elbow.effort_sensor.model_copy(update={"offset": ASYMMETRY * speed})
    return right.with_joint(elbow.model_copy(update={"effort_sensor": sensor}))


def test_the_offset_is_not_divided_by_the_scale_of_its_sensor(tmp_path: Path) -> None:
    """A reading is scale times effort plus offset: of the two strengths, the scale is in the damping's alone."""
    machine = Machine(hidden={ELBOW: lambda at: ASYMMETRY * np.abs(at.v)}, noise=0.05)
    case = write_case(tmp_path, machine, seed=4, seconds=15.0)
    log, right = read_log(case[0]), read_robot(case[1])
    scaled = {**log.columns, "effort.elbow_joint": 1.3 * log.columns["effort.elbow_joint"]}
    gap = measure_gap(replace(log, columns=scaled), stated_with_offset(log, right))
    causes = tuple(Chosen(cause, Site(ELBOW)) for cause in (TorqueConstant(), AsymmetryWithOffset()))
    model = build_model(gap, make_nuisance(gap), causes)
    extended = extend_robot(model).joint("elbow_joint")
    assert extended.effort_sensor.scale == pytest.approx(1.3, abs=0.01)
    stated = gap.robot.joint("elbow_joint").effort_sensor.offset
    assert extended.effort_sensor.offset == pytest.approx(0.0, abs=0.05 * abs(stated))


def test_the_asymmetry_brings_the_offset_back(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    machine = Machine(hidden={ELBOW: lambda at: ASYMMETRY * np.abs(at.v)}, noise=0.05)
    case = write_case(tmp_path, machine, seed=4, seconds=40.0)
    log, right = read_log(case[0]), read_robot(case[1])
    stated = stated_with_offset(log, right)
    sensor = stated.joint("elbow_joint").effort_sensor
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
