"""Friction that is higher from one place of the stroke on."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from mjfriction.diagnose.causes.catalog import STATED_LEVELS
from mjfriction.diagnose.diagnosis import diagnose_log
from mjfriction.diagnose.fit.model import Chosen, Model, build_model
from mjfriction.diagnose.fit.refitted import Level
from mjfriction.diagnose.fit.shapes import reshaped
from mjfriction.diagnose.fit.trial import Trial, try_out
from mjfriction.diagnose.settle import stated
from mjfriction.diagnose.tell.outcome import Diagnosis, Verdict
from mjfriction.record.readers import read_log
from mjfriction.robot.files import read_robot
from tests.hidden.machine import UR5_COULOMB, Instant, Machine, write_case

LIFT = 1
HIGHER = 0.45 * UR5_COULOMB[LIFT]


def dry_beyond(at: Instant) -> np.ndarray:
    return HIGHER * (at.q > np.min(at.q) + 0.6 * np.ptp(at.q)) * np.sign(at.v)


def diagnosed(folder: Path) -> Diagnosis:
    log, robot = write_case(folder, Machine(hidden={LIFT: dry_beyond}, noise=0.1), seed=7)
    return diagnose_log(read_log(log), read_robot(robot))


def test_shapes_do_not_move_where_the_level_as_stated_makes_them_worse(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    found = diagnosed(tmp_path)
    assert found.verdict is Verdict.EXPLAINED
    assert {(finding.cause, finding.joint) for finding in found.findings} == {
        ("friction.position", "shoulder_lift_joint")
    }

    def beside_moved_shapes(model: Model, level: Level) -> tuple[Model, Trial | None]:
        joint = level.site.joint
        held = reshaped(build_model(model.gap, model.nuisance.without_level(joint), model.chosen), {joint})
        return held, try_out(held, Chosen(STATED_LEVELS, level.site))

    monkeypatch.setattr(stated, "_as_stated", beside_moved_shapes)
    assert diagnosed(tmp_path).verdict is not Verdict.EXPLAINED
