"""A drive that turns with two joints: its friction tells of it, and then its rotor's inertia may be told too."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from mjfriction.diagnose.causes.cause import Site
from mjfriction.diagnose.causes.coupling import DifferenceRotor, SumRotor
from mjfriction.diagnose.diagnosis import diagnose_log
from mjfriction.identify.measure import measure_gap
from mjfriction.record.readers import read_log
from mjfriction.robot.effort import predict_effort
from mjfriction.robot.files import read_robot
from tests.hidden.machine import UR5_JOINTS, Instant, Machine, write_case

WRIST = 4
LEVEL, DAMPING, INERTIA = 0.9, 0.5, 0.04


def shared(instant: Instant, inertia: float) -> np.ndarray:
    turn = instant.velocities[:, WRIST] + instant.velocities[:, WRIST + 1]
    return LEVEL * np.sign(turn) + DAMPING * turn + inertia * np.gradient(turn, instant.time)


@pytest.mark.deep
@pytest.mark.parametrize("inertia", [INERTIA, 0.0])
def test_a_drive_that_two_joints_turn_is_found_with_its_rotor_if_that_shows(inertia: float, tmp_path: Path) -> None:
    def hidden(instant: Instant) -> np.ndarray:
        return shared(instant, inertia)

    log, robot = write_case(tmp_path, Machine(hidden={WRIST: hidden, WRIST + 1: hidden}), seed=3, seconds=40.0)
    (finding,) = diagnose_log(read_log(log), read_robot(robot)).findings
    assert (finding.cause, finding.joint) == ("drive.coupling", "wrist_2_joint")
    found = {fitted.name: fitted for fitted in finding.parameters}
    truth = {"coulomb": LEVEL, "viscous": DAMPING, "ratio": 1.0} | ({"inertia": INERTIA} if inertia else {})
    assert found.keys() == truth.keys()
    for name, true in truth.items():
        assert abs(found[name].value - true) < 2.0 * (found[name].high - found[name].value)
        assert found[name].value == pytest.approx(true, rel=0.2)


@pytest.mark.parametrize("cause", [SumRotor(), DifferenceRotor()])
@pytest.mark.parametrize("rotor", [0.0, 3.0 * INERTIA])
@pytest.mark.parametrize("ratio", [1.0, 0.6])
def test_what_the_rotor_takes_is_what_the_extended_robot_predicts(
    cause: SumRotor | DifferenceRotor, rotor: float, ratio: float, tmp_path: Path
) -> None:
    log, path = write_case(tmp_path, Machine(), seed=3, seconds=10.0)
    robot = read_robot(path)
    for joint in robot.joints[WRIST:]:
        table = robot.joint(joint)
        actuator = table.actuator.model_copy(update={"rotor_inertia": rotor})
        robot = robot.with_joint(table.model_copy(update={"actuator": actuator}))
    gap = measure_gap(read_log(log), robot)
    strengths, site = np.array([0.0, DAMPING, INERTIA]), Site(WRIST, (ratio,), other=WRIST + 1)
    extended = cause.extend(gap.robot, site, strengths)
    before, after = (predict_effort(one, one.body(), gap.motion).reported for one in (gap.robot, extended))
    expected = np.zeros_like(before)
    expected[:, WRIST] = cause.samples(gap, site) @ strengths
    expected[:, WRIST + 1] = cause.at_drive(gap, site, WRIST + 1) @ strengths
    assert np.max(np.abs(after - before - expected)) < 1e-9 * np.max(np.abs(expected))
    rotors = [joint.actuator.rotor_inertia for joint in extended.table.joint[WRIST:]]
    assert rotors == pytest.approx([max(0.0, rotor - own**2 * INERTIA) for own in (ratio, 1.0)])


@pytest.mark.deep
@pytest.mark.parametrize(("first", "second", "told"), [(1.0, -0.6, 0), (-0.7, 1.0, 1)])
def test_the_ratio_is_the_one_beside_which_damping_is_as_stated(
    first: float, second: float, told: int, tmp_path: Path
) -> None:
    def hidden(weight: float) -> Callable[[Instant], np.ndarray]:
        def torque(instant: Instant) -> np.ndarray:
            turn = first * instant.velocities[:, WRIST] + second * instant.velocities[:, WRIST + 1]
            return weight * 2.0 * DAMPING * turn

        return torque

    machine = Machine(hidden={WRIST: hidden(first), WRIST + 1: hidden(second)})
    log, robot = write_case(tmp_path, machine, seed=3, seconds=40.0)
    # Another ratio would leave both joints' dampings to be told as off.
    (finding,) = diagnose_log(read_log(log), read_robot(robot)).findings
    assert (finding.cause, finding.joint) == ("drive.coupling", UR5_JOINTS[WRIST + told])
    found = {fitted.name: fitted for fitted in finding.parameters}
    assert found["ratio"].value == pytest.approx(abs(first / second), rel=0.1)
    assert found["viscous"].value == pytest.approx(2.0 * DAMPING * second**2, rel=0.1)
