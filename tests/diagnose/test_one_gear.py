"""A gear that loses more where the drive works against the load than where the load drives it."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from mjfriction.diagnose.causes.cause import Site
from mjfriction.diagnose.causes.load import GearedDriveLoad, GearedLoad
from mjfriction.diagnose.diagnosis import diagnose_log
from mjfriction.diagnose.search import compete
from mjfriction.diagnose.tell.outcome import Verdict
from mjfriction.identify.measure import measure_gap
from mjfriction.laws.geared_load import GEARED_LOAD
from mjfriction.laws.law import Law
from mjfriction.laws.load_dependent import LOAD_DEPENDENT
from mjfriction.record.readers import read_log
from mjfriction.robot.effort import predict_effort
from mjfriction.robot.files import read_robot
from mjfriction.robot.friction import with_term
from mjfriction.robot.load_friction import stated_load, stated_loads, with_less_load
from tests.hidden.machine import UR5_JOINTS, Instant, Machine, write_case

ELBOW, LOAD, DIFFERENCE = 2, 0.12, 0.08


def gear(instant: Instant) -> np.ndarray:
    return LOAD * np.abs(instant.rigid) * np.sign(instant.v) + DIFFERENCE * instant.rigid


def two_causes(instant: Instant) -> np.ndarray:
    load = LOAD * np.abs(instant.rigid) * np.sign(instant.v)
    return (1.0 + DIFFERENCE) * load + DIFFERENCE * (instant.rigid + instant.friction)


@pytest.mark.deep
def test_it_is_one_finding_with_two_coefficients(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path, stated = write_case(tmp_path, Machine(hidden={ELBOW: gear}), seed=3, seconds=40.0)
    log, robot = read_log(path), read_robot(stated)
    diagnosis = diagnose_log(log, robot)
    (finding,) = diagnosis.findings
    assert (finding.cause, finding.joint, finding.alternatives) == ("friction.load", UR5_JOINTS[ELBOW], ())
    found = {fitted.name: fitted.value for fitted in finding.parameters}
    truth = {"load_driving": LOAD + DIFFERENCE, "load_braking": LOAD - DIFFERENCE}
    assert found == pytest.approx(truth, abs=0.005)
    assert diagnose_log(log, diagnosis.robot).verdict is Verdict.CONSISTENT

    monkeypatch.setattr(compete, "geared", lambda model: model)
    apart = {one.cause for one in diagnose_log(log, robot).findings}
    assert apart >= {"friction.load", "drive.torque_constant"}


def test_a_torque_constant_beside_load_friction_stays_one(tmp_path: Path) -> None:
    log, robot = write_case(tmp_path, Machine(hidden={ELBOW: two_causes}), seed=3, seconds=40.0)
    findings = diagnose_log(read_log(log), read_robot(robot)).findings
    assert {one.cause for one in findings} == {"friction.load", "drive.torque_constant"}
    factor = next(one for one in findings if one.cause == "drive.torque_constant").parameters[0]
    assert factor.value == pytest.approx(1.0 + DIFFERENCE, abs=0.01)


@pytest.mark.parametrize("cause", [GearedLoad(), GearedDriveLoad()])
@pytest.mark.parametrize("strengths", [(0.2, 0.04), (-0.05, 0.1), (0.1, -0.05)])
@pytest.mark.parametrize("law", [LOAD_DEPENDENT, GEARED_LOAD])
@pytest.mark.parametrize("more_backward", [0.0, 0.05])
def test_what_is_drawn_is_what_the_extended_robot_predicts(
    cause: GearedLoad | GearedDriveLoad,
    strengths: tuple[float, float],
    law: Law,
    more_backward: float,
    tmp_path: Path,
) -> None:
    log, path = write_case(tmp_path, Machine(), seed=3, seconds=10.0)
    loads = {"load": 0.06} if law is LOAD_DEPENDENT else {"load_driving": 0.1, "load_braking": 0.06}
    parameters = {"coulomb": 0.5, **loads, "viscous": 0.0}
    own = read_robot(path)
    table = own.joint(UR5_JOINTS[ELBOW])
    turned = table.actuator.model_copy(update={"rotor_inertia": 0.5 / table.actuator.gear_ratio**2})
    own = own.with_joint(table.model_copy(update={"actuator": turned}))
    robot = with_term(own, UR5_JOINTS[ELBOW], law.name, parameters, load_includes_rotor=cause.includes_rotor)
    table = robot.joint(UR5_JOINTS[ELBOW])
    *others, last = table.friction or ()
    backward = {name: load + more_backward for name, load in loads.items()}
    last = last.model_copy(update={"negative": backward if more_backward else None})
    robot = robot.with_joint(table.model_copy(update={"friction": (*others, last)}))
    gap, site = measure_gap(read_log(log), robot), Site(ELBOW)
    added = np.array(strengths)
    assert cause.admissible(gap, site, added)
    extended = cause.extend(robot, site, added)
    before, after = (predict_effort(one, one.body(), gap.motion).reported[:, ELBOW] for one in (robot, extended))
    expected = cause.samples(gap, site) @ added
    driving, braking = stated_loads(extended.joint(UR5_JOINTS[ELBOW]), includes_rotor=cause.includes_rotor)
    told = [quantity.shift + change for quantity, change in zip(cause.quantities(gap, site), strengths, strict=True)]
    assert told == pytest.approx([driving, braking])
    # While a joint turns over, which way it goes is a matter of degree.
    clear = np.abs(gap.forward(ELBOW)) == 1.0
    assert np.mean(clear) > 0.9
    assert np.max(np.abs(after - before - expected)[clear]) < 1e-3 * np.max(np.abs(expected))


def test_neither_coefficient_drives_the_joint(tmp_path: Path) -> None:
    log, path = write_case(tmp_path, Machine(), seed=3, seconds=10.0)
    gap = measure_gap(read_log(log), read_robot(path))
    for strengths, possible in (((0.2, 0.0), True), ((0.2, -0.01), True), ((0.2, -0.1), False), ((-0.1, -0.2), False)):
        assert GearedLoad().admissible(gap, Site(ELBOW), np.array(strengths)) is possible


def test_less_of_a_gear_is_less_in_both_directions_of_power(tmp_path: Path) -> None:
    _, path = write_case(tmp_path, Machine(), seed=3, seconds=1.0)
    own = {"coulomb": 0.5, "load_driving": 0.1, "load_braking": 0.06, "viscous": 0.0}
    robot = with_term(read_robot(path), UR5_JOINTS[ELBOW], GEARED_LOAD.name, own)
    assert stated_load(robot.joint(UR5_JOINTS[ELBOW])) == 0.06
    lower = with_less_load(robot, UR5_JOINTS[ELBOW], 0.05)
    assert stated_loads(lower.joint(UR5_JOINTS[ELBOW])) == pytest.approx((0.05, 0.01))
    assert stated_loads(with_less_load(robot, UR5_JOINTS[ELBOW], 1.0).joint(UR5_JOINTS[ELBOW])) == pytest.approx(
        (0.04, 0.0)
    )
