"""Less friction near rest than is stated: the stated curve is lowered, down to none, and nothing is added below it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from mjfriction.diagnose.causes.cause import Site
from mjfriction.diagnose.causes.stribeck import Stribeck
from mjfriction.diagnose.diagnosis import diagnose_log
from mjfriction.identify.measure import measure_gap
from mjfriction.record.log import Log
from mjfriction.record.readers import read_log
from mjfriction.robot.files import read_robot
from mjfriction.robot.friction import stribeck_excess, stribeck_shapes, with_less_stribeck, with_term
from mjfriction.robot.robot import Robot
from tests.hidden.machine import UR5_JOINTS, Machine, write_case

ELBOW = 2
SHAPE = {"stribeck_velocity": 0.15, "stribeck_exponent": 2.0}
EXCESS = 3.0


@pytest.fixture(scope="module")
def case(tmp_path_factory: pytest.TempPathFactory) -> tuple[Log, Robot]:
    """A log of a machine without a Stribeck curve, and a robot that states one."""
    log, robot = write_case(tmp_path_factory.mktemp("stated"), Machine(noise=0.1), seed=6)
    parameters = {"coulomb": 0.0, "static": EXCESS, "viscous": 0.0, **SHAPE}
    return read_log(log), with_term(read_robot(robot), UR5_JOINTS[ELBOW], "stribeck", parameters)


def test_a_stated_curve_that_is_not_there_is_taken_away(case: tuple[Log, Robot]) -> None:
    found = diagnose_log(*case)
    (finding,) = found.findings
    assert (finding.cause, finding.joint) == ("friction.stribeck", UR5_JOINTS[ELBOW])
    excess = finding.parameters[0]
    assert excess.low == 0.0
    assert excess.value == pytest.approx(0.0, abs=0.1 * EXCESS)
    assert stribeck_excess(found.robot.joint(UR5_JOINTS[ELBOW])) == pytest.approx(excess.value, abs=1e-9)


def test_only_the_curve_that_is_stated_is_ever_lowered(case: tuple[Log, Robot]) -> None:
    log, robot = case
    gap, cause = measure_gap(log, robot), Stribeck()
    (stated,) = stribeck_shapes(robot.joint(UR5_JOINTS[ELBOW]))
    own = Site(ELBOW, stated)
    less = np.array([-0.5 * EXCESS])
    assert own in cause.sites(gap)
    assert cause.admissible(gap, own, less)
    assert not cause.admissible(gap, own, np.array([-1.3 * EXCESS]))
    assert stribeck_excess(cause.extend(robot, own, np.array([-1.2 * EXCESS])).joint(UR5_JOINTS[ELBOW])) == 0.0
    assert not cause.admissible(gap, replace(own, shape=(0.1, 2.0)), less)
    lowered = cause.extend(robot, own, less)
    assert stribeck_excess(lowered.joint(UR5_JOINTS[ELBOW])) == pytest.approx(0.5 * EXCESS)
    assert stribeck_shapes(lowered.joint(UR5_JOINTS[ELBOW])) == (stated,)


def test_a_curve_stated_at_the_motor_is_lowered_by_what_the_joint_feels() -> None:
    robot = read_robot("ur5")
    joint = robot.joints[0]
    ratio = 101.0
    table = robot.joint(joint)
    geared = robot.with_joint(
        table.model_copy(update={"actuator": table.actuator.model_copy(update={"gear_ratio": ratio}), "friction": ()})
    )
    parameters = {"coulomb": 0.1, "static": 0.15, "viscous": 0.0, **SHAPE}
    moved = with_term(geared, joint, "stribeck", parameters)
    (term,) = moved.joint(joint).friction or ()
    motor = moved.with_joint(
        moved.joint(joint).model_copy(update={"friction": (term.model_copy(update={"side": "motor"}),)})
    )
    assert stribeck_shapes(motor.joint(joint)) == ((pytest.approx(0.15 / ratio), 2.0),)
    assert stribeck_excess(motor.joint(joint)) == pytest.approx(0.05 * ratio)
    assert stribeck_excess(with_less_stribeck(motor, joint, 0.02 * ratio).joint(joint)) == pytest.approx(0.03 * ratio)
    assert stribeck_excess(with_less_stribeck(motor, joint, 9.0 * ratio).joint(joint)) == 0.0
