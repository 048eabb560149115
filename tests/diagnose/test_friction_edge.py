"""Friction that is higher from one place of the stroke on is told with the place and the side."""

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
from mjfriction.diagnose.search import courses
from mjfriction.diagnose.settle import stated
from mjfriction.diagnose.tell.outcome import Diagnosis, Verdict
from mjfriction.record.readers import read_log
from mjfriction.robot.files import read_robot
from tests.diagnose.in_the_file import left_by_the_file
from tests.hidden.machine import UR5_COULOMB, Effect, Instant, Machine, write_case

LIFT, PLACE = 1, 0.6
HIGHER = 0.45 * UR5_COULOMB[LIFT]


def above(at: Instant) -> np.ndarray:
    return HIGHER * (at.q > np.min(at.q) + PLACE * np.ptp(at.q)) * np.sign(at.v)


def below(at: Instant) -> np.ndarray:
    return HIGHER * np.sign(at.v) - above(at)


def diagnosed(folder: Path, effect: Effect) -> Diagnosis:
    log, robot = write_case(folder, Machine(hidden={LIFT: effect}, noise=0.1), seed=7)
    return diagnose_log(read_log(log), read_robot(robot))


@pytest.mark.parametrize("effect", [pytest.param(above, marks=pytest.mark.deep), below])
def test_it_is_told_with_its_place_and_its_side(effect: Effect, tmp_path: Path) -> None:
    found = diagnosed(tmp_path, effect)
    assert found.verdict is Verdict.EXPLAINED
    (finding,) = found.findings
    assert (finding.cause, finding.joint) == ("friction.position", "shoulder_lift_joint")
    assert finding.evidence.startswith(effect.__name__)
    position = found.gap.motion.position[:, LIFT]
    told = {value.name: value.value for value in finding.parameters}
    assert told["coulomb"] == pytest.approx(HIGHER, rel=0.03)
    assert told["position"] == pytest.approx(np.min(position) + PLACE * np.ptp(position), abs=0.01 * np.ptp(position))
    (lift,) = [error for error in found.joints if error.joint == finding.joint]
    assert lift.rms_heldout_after < 1.1 * lift.noise_floor
    left = left_by_the_file(found, tmp_path / "extended")
    assert found.gap.rms(left[:, LIFT], LIFT) == pytest.approx(lift.rms_after, rel=1e-3)


@pytest.mark.deep
def test_waves_and_courses_leave_more_of_it(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(courses, "_with_edge", lambda model, joint: None)
    found = diagnosed(tmp_path, above)
    (lift,) = [error for error in found.joints if error.joint == "shoulder_lift_joint"]
    assert lift.rms_heldout_after > 1.5 * lift.noise_floor


@pytest.mark.deep
def test_shapes_do_not_move_where_the_level_as_stated_makes_them_worse(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(courses, "_with_edge", lambda model, joint: None)
    found = diagnosed(tmp_path, above)
    assert found.verdict is Verdict.EXPLAINED
    assert {(finding.cause, finding.joint) for finding in found.findings} == {
        ("friction.position", "shoulder_lift_joint")
    }

    def beside_moved_shapes(model: Model, level: Level) -> tuple[Model, Trial | None]:
        joint = level.site.joint
        held = reshaped(build_model(model.gap, model.nuisance.without_level(joint), model.chosen), {joint})
        return held, try_out(held, Chosen(STATED_LEVELS, level.site))

    monkeypatch.setattr(stated, "_as_stated", beside_moved_shapes)
    assert diagnosed(tmp_path, above).verdict is not Verdict.EXPLAINED
