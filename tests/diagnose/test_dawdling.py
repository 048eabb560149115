"""A joint that hardly moves beside the others: what its friction does near rest is no finding."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pyarrow as pa
import pytest

from mjfriction.body.inverse import inverse_dynamics
from mjfriction.diagnose.diagnosis import diagnose_log
from mjfriction.diagnose.tell.outcome import Diagnosis, Verdict
from mjfriction.plant.motions import excitation
from mjfriction.record.log import Log
from mjfriction.record.motion import Motion, estimate_motion
from mjfriction.record.readers.table import log_from_table
from tests.diagnose.test_planar_arm import planar

TURNING = 0.01  # rad/s over which the wrist's friction turns over, as a film of oil does


def diagnosed(folder: Path) -> Diagnosis:
    robot = planar(folder)
    span, speed = np.array([1.2, 1.2, 0.02]), np.array([2.0, 2.0, 0.03])
    motion = excitation(robot.joints, np.zeros(3), span, speed, 40.0, seed=3)
    time = np.arange(0.0, 40.0, 0.004)
    q, v, a = motion.at(time)
    way = np.sign(v)
    way[:, 2] = np.tanh(v[:, 2] / TURNING)
    effort = inverse_dynamics(robot.body(), q, v, a) + 0.2 * way + 0.1 * v
    effort += 0.01 * np.random.default_rng(2).standard_normal(effort.shape)
    columns = {"time": time}
    columns |= {f"position.{name}": values for name, values in zip(robot.joints, q.T, strict=True)}
    columns |= {f"effort.{name}": values for name, values in zip(robot.joints, effort.T, strict=True)}
    return diagnose_log(log_from_table(pa.table(columns), "planar"), robot)


def test_a_joint_that_hardly_moves_is_not_examined(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    found = diagnosed(tmp_path)
    assert found.not_examined == ("wrist",)
    assert (found.findings, found.verdict) == ((), Verdict.CONSISTENT)
    monkeypatch.setattr(Motion, "dawdling", np.zeros(3, dtype=bool))
    monkeypatch.setattr("mjfriction.identify.measure.turning_speeds", lambda velocity, *_: np.zeros(velocity.shape[1]))
    assert {finding.joint for finding in diagnosed(tmp_path).findings} == {"wrist"}


def test_joints_are_held_against_others_of_their_kind(tmp_path: Path) -> None:
    """A slide of some centimetres beside an arm that turns by radians moves as far as slides do."""
    motion = diagnosed(tmp_path).gap.motion
    assert motion.dawdling.tolist() == [False, False, True]
    sliding = replace(motion, sliding=(False, False, True))
    assert sliding.dawdling.tolist() == [False, False, False]


def test_a_slide_that_moves_by_centimetres_beside_turning_joints_is_moving() -> None:
    """One that its drive holds, and that gives by a tenth of a millimetre, is not."""
    time = np.arange(0.0, 20.0, 0.005)
    turning = 3.0 * np.sin(2.0 * np.pi * 0.5 * time)
    for stroke, moves in ((0.02, True), (1e-4, False)):
        columns = {"position.arm": turning, "position.slide": stroke * np.sin(2.0 * np.pi * 0.2 * time)}
        log = Log("test", time, np.zeros(time.size, dtype=np.int64), ("arm", "slide"), columns)
        assert estimate_motion(log, log.joints, 10.0, (False, True)).moving.tolist() == [True, moves]
