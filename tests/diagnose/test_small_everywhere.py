"""What all joints show alike is told of an even machine though it makes less than what one joint may show.

So is what one joint alone shows, where no more than the sensors' noise is left anywhere.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import mujoco
import numpy as np
import pytest

from mjfriction.diagnose.causes.gravity_direction import GravityDirection
from mjfriction.diagnose.diagnosis import diagnose_log
from mjfriction.diagnose.fit import trial
from mjfriction.diagnose.fit.exact import usual_nuisance
from mjfriction.diagnose.fit.model import Chosen, build_model
from mjfriction.diagnose.tell.outcome import Diagnosis
from mjfriction.diagnose.tell.visible import visible_causes
from mjfriction.identify.measure import measure_gap
from mjfriction.record.readers import read_log
from mjfriction.robot.files import read_robot
from tests.hidden.machine import UR5_COULOMB, UR5_JOINTS, UR5_VISCOUS, Instant, Machine, write_case

TILT = 0.004  # rad
PAN, LIFT, ELBOW = 0, 1, 2
BEND = 0.5  # N·m·s²/rad²
HEAVY = Machine(  # its second joint rubs little, and holds much
    noise=0.02, coulomb=(9.0, 3.0, *UR5_COULOMB[2:]), viscous=(11.0, 3.0, *UR5_VISCOUS[2:])
)


def leaning(model: mujoco.MjModel) -> None:
    model.opt.gravity[:] = 9.81 * np.array([np.sin(TILT), 0.0, -np.cos(TILT)])


def diagnosed(folder: Path, machine: Machine) -> Diagnosis:
    log, robot = write_case(folder, machine, seed=21, seconds=30.0)
    return diagnose_log(read_log(log), read_robot(robot))


@pytest.mark.deep
def test_a_base_that_leans_a_little_is_told_of_an_even_machine(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    machine = Machine(noise=0.02, change=leaning)
    assert [finding.cause for finding in diagnosed(tmp_path / "told", machine).findings] == ["body.gravity_direction"]
    monkeypatch.setattr(trial, "EVENEST", 1.0)
    monkeypatch.setattr("mjfriction.diagnose.search.unevenness.EVENEST", 1.0)
    assert diagnosed(tmp_path / "as of an uneven one", machine).findings == ()


def test_how_little_an_even_machine_could_show_is_said(tmp_path: Path) -> None:
    log, robot = write_case(tmp_path, Machine(noise=0.02), seed=21, seconds=30.0)
    shown = visible_causes(measure_gap(read_log(log), read_robot(robot)))
    tilts = [one.share for one in shown if one.cause == "body.gravity_direction"]
    springs = [one.share for one in shown if one.cause == "body.spring"]
    assert 0.0 < min(tilts) < trial.LEAST_EFFECT
    assert trial.QUIETLY * trial.LEAST_EFFECT < min(springs) < trial.LEAST_EFFECT


def bending(at: Instant) -> np.ndarray:
    return BEND * np.abs(at.v) * at.v


def test_as_little_at_a_joint_that_holds_gravity_is_told_where_all_is_quiet(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Damping that grows with speed, by a few thousandths of an effort that is mostly weight, above all noise."""
    machine = replace(HEAVY, hidden={LIFT: bending})
    found = diagnosed(tmp_path / "told", machine)
    assert [(one.cause, one.joint) for one in found.findings] == [("friction.viscous_nonlinear", UR5_JOINTS[LIFT])]
    rms = next(one for one in found.joints if one.joint == UR5_JOINTS[LIFT])
    effort = found.gap.rms(found.gap.measured[:, LIFT], LIFT)
    assert rms.rms_heldout_before**2 - rms.rms_heldout_after**2 < (trial.LEAST_EFFECT * effort) ** 2
    monkeypatch.setattr(trial, "QUIETLY", 1.0)
    assert diagnosed(tmp_path / "too little", machine).findings == ()


def test_as_little_is_not_told_where_other_small_errors_show(tmp_path: Path) -> None:
    def rippling(at: Instant) -> np.ndarray:
        return 0.02 * UR5_COULOMB[PAN] * sum(np.sin(turns * at.q) for turns in (23.0, 31.0, 41.0, 53.0))

    machine = replace(HEAVY, hidden={LIFT: bending, PAN: rippling})
    assert UR5_JOINTS[LIFT] not in {one.joint for one in diagnosed(tmp_path, machine).findings}


def test_what_several_joints_feel_is_as_large_as_where_it_shows_most(tmp_path: Path) -> None:
    """A quiet joint full of gravity gains most from a tilt that is next to nothing of its effort; not so at another."""

    def tilted(model: mujoco.MjModel) -> None:
        model.opt.gravity[:] = 9.81 * np.array([np.sin(3.0 * TILT), 0.0, -np.cos(3.0 * TILT)])

    quiet = Machine(noise=0.05, coulomb=(UR5_COULOMB[0], 1.0, 1.0, *UR5_COULOMB[3:]), change=tilted)
    log, robot = write_case(tmp_path, quiet, seed=21, seconds=30.0)
    gap = measure_gap(read_log(log), read_robot(robot))
    model, (site,) = build_model(gap, usual_nuisance(gap), ()), GravityDirection().sites(gap)
    tilt = trial.try_out(model, Chosen(GravityDirection(), site))
    assert tilt is not None
    normal = model.with_candidate(tilt.chosen)
    gains = np.sum(model.heldout_errors - normal.heldout_errors(gap.blocks.folds), axis=1)
    assert np.argmax(gains) == ELBOW
    made = trial.effects(model, tilt.chosen, normal.fitted[-2:], ELBOW)[0]
    assert made < trial.LEAST_EFFECT < tilt.effect
