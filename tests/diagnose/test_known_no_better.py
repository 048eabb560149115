"""Stated values that nobody knows any better are no findings, nor are gears that are as stiff as any."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from mjfriction.diagnose.causes import elasticity, offset, torque_constant
from mjfriction.diagnose.causes.cause import Site
from mjfriction.diagnose.causes.elasticity import Elasticity, SensorElasticity
from mjfriction.diagnose.causes.moved_link import own_slopes
from mjfriction.diagnose.diagnosis import diagnose_log
from mjfriction.diagnose.fit.exact import usual_nuisance
from mjfriction.diagnose.fit.model import Chosen, build_model
from mjfriction.diagnose.settle.stated import Settled
from mjfriction.diagnose.tell import untold
from mjfriction.diagnose.tell.outcome import Diagnosis
from mjfriction.diagnose.tell.untold import find_untold
from mjfriction.diagnose.tell.visible import visible_causes
from mjfriction.identify.measure import measure_gap
from mjfriction.record.readers import read_log
from mjfriction.robot.files import read_robot
from tests.hidden.machine import UR5_COULOMB, UR5_JOINTS, Instant, Machine, write_case

PAN, LIFT, ELBOW = 0, 1, 2
OFF, DRIFT = 0.015, 0.04  # of the effort, of the Coulomb level


def diagnosed(folder: Path, machine: Machine) -> Diagnosis:
    log, robot = write_case(folder, machine, seed=21, seconds=25.0, rate=125.0)
    return diagnose_log(read_log(log), read_robot(robot))


def test_a_torque_constant_that_is_off_by_a_percent(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def reads_more(at: Instant) -> np.ndarray:
        return OFF * (at.rigid + at.friction)

    machine = Machine(noise=0.01, hidden={LIFT: reads_more})
    found = diagnosed(tmp_path, machine)
    assert found.findings == ()
    (factor,) = [own for own in found.adjustments if own.what == "factor"]
    assert factor.fitted == pytest.approx(1.0 + OFF, abs=0.003)
    monkeypatch.setattr(torque_constant, "LEAST_OFF", 0.0)
    told = [(one.cause, one.joint) for one in diagnosed(tmp_path, machine).findings]
    assert told == [("drive.torque_constant", UR5_JOINTS[LIFT])]


def test_a_zero_that_is_off_by_a_few_percent_of_friction(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    machine = Machine(noise=0.02, hidden={ELBOW: lambda at: np.full_like(at.q, DRIFT * UR5_COULOMB[ELBOW])})
    found = diagnosed(tmp_path, machine)
    assert found.findings == ()
    (zero,) = [own for own in found.adjustments if (own.what, own.joint) == ("offset", UR5_JOINTS[ELBOW])]
    assert zero.fitted == pytest.approx(DRIFT * UR5_COULOMB[ELBOW], rel=0.1)
    monkeypatch.setattr(offset, "ONE_WAY", 0.0)
    told = [(one.cause, one.joint) for one in diagnosed(tmp_path, machine).findings]
    assert told == [("drive.offset", UR5_JOINTS[ELBOW])]


def test_what_a_log_could_show_is_no_less(tmp_path: Path) -> None:
    log, robot = write_case(tmp_path, Machine(noise=0.01), seed=21, seconds=25.0, rate=125.0)
    shown = visible_causes(measure_gap(read_log(log), read_robot(robot)))
    least = {one.cause: one for one in shown if one.joint == UR5_JOINTS[LIFT]}
    assert least["drive.offset"].size == pytest.approx(offset.ONE_WAY * UR5_COULOMB[LIFT])
    assert least["drive.torque_constant"].share == pytest.approx(torque_constant.LEAST_OFF, rel=0.02)


@pytest.mark.parametrize(
    ("compliance", "usual"),
    [(3e-5, True), (1.2e-4, False)],
)
def test_a_gear_as_stiff_as_any_is_none_where_the_robot_is_a_little_off_or_other_errors_show(
    compliance: float, usual: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    log, robot = write_case(tmp_path, Machine(), seed=21, seconds=25.0, rate=125.0)
    gap = measure_gap(read_log(log), read_robot(robot))
    inertia = float(np.median(own_slopes(gap, PAN)[2]))
    swings = 1.0 / (2.0 * np.pi * float(np.sqrt(compliance * inertia)))
    assert (swings > elasticity.USUALLY_SWINGS) is usual
    soft = Chosen(Elasticity(), Site(PAN))
    assert soft.cause.usual(gap, soft.site, np.array([compliance])) is usual
    assert not SensorElasticity().usual(gap, soft.site, np.array([compliance]))
    # A heavy load makes it give by more.
    monkeypatch.setattr(Elasticity, "load", lambda *_: np.array([1.1 * elasticity.USUALLY_GIVES / compliance]))
    assert not soft.cause.usual(gap, soft.site, np.array([compliance]))
    monkeypatch.undo()
    model = build_model(gap, usual_nuisance(gap), (soft,))
    monkeypatch.setattr(Elasticity, "usual", lambda *_: usual)
    monkeypatch.setattr(untold, "shows", lambda *_, **__: True)
    monkeypatch.setattr(untold, "negligible", lambda *_: False)
    left = model.heldout_residual()
    for exact, heldout in ((True, left), (False, left), (True, 3.0 * left)):
        keys = find_untold(Settled(model, (), exact=exact), (), (), heldout).keys
        assert (soft.key in keys) is (usual and not (exact and heldout is left))
