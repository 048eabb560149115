"""A drive that turns with two joints: its friction tells of it, and then its rotor's inertia may be told too."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from mjfriction.diagnose.causes.cause import Site
from mjfriction.diagnose.causes.coupling import (
    DifferenceAddedRotor,
    DifferenceRotor,
    SharedRotor,
    SumAddedRotor,
    SumDrive,
    SumRotor,
)
from mjfriction.diagnose.diagnosis import diagnose_log
from mjfriction.diagnose.fit.judged import judged
from mjfriction.diagnose.fit.model import Chosen, build_model
from mjfriction.diagnose.fit.nuisance import make_nuisance
from mjfriction.diagnose.search.kin import fulfilled
from mjfriction.identify.measure import measure_gap
from mjfriction.record.readers import read_log
from mjfriction.robot.effort import predict_effort
from mjfriction.robot.files import read_robot
from mjfriction.robot.robot import Robot
from tests.hidden.machine import UR5_JOINTS, Instant, Machine, write_case

WRIST = 4
LEVEL, DAMPING, INERTIA = 0.9, 0.5, 0.04


def shared(instant: Instant, inertia: float) -> np.ndarray:
    turn = instant.velocities[:, WRIST] + instant.velocities[:, WRIST + 1]
    return LEVEL * np.sign(turn) + DAMPING * turn + inertia * np.gradient(turn, instant.time)


def with_rotors(path: Path, inertia: float) -> Robot:
    robot = read_robot(path)
    for joint in robot.joints[WRIST:]:
        table = robot.joint(joint)
        actuator = table.actuator.model_copy(update={"rotor_inertia": inertia})
        robot = robot.with_joint(table.model_copy(update={"actuator": actuator}))
    return robot


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


@pytest.mark.parametrize("cause", [SumRotor(), DifferenceRotor(), SumAddedRotor(), DifferenceAddedRotor()])
@pytest.mark.parametrize("rotor", [0.0, 3.0 * INERTIA])
@pytest.mark.parametrize("ratio", [1.0, 0.6])
def test_what_the_rotor_takes_is_what_the_extended_robot_predicts(
    cause: SharedRotor, rotor: float, ratio: float, tmp_path: Path
) -> None:
    log, path = write_case(tmp_path, Machine(), seed=3, seconds=10.0)
    gap = measure_gap(read_log(log), with_rotors(path, rotor))
    strengths, site = np.array([0.0, DAMPING, INERTIA]), Site(WRIST, (ratio,), other=WRIST + 1)
    extended = cause.extend(gap.robot, site, strengths)
    before, after = (predict_effort(one, one.body(), gap.motion).reported for one in (gap.robot, extended))
    expected = np.zeros_like(before)
    expected[:, WRIST] = cause.samples(gap, site) @ strengths
    expected[:, WRIST + 1] = cause.at_drive(gap, site, WRIST + 1) @ strengths
    assert np.max(np.abs(after - before - expected)) < 1e-9 * np.max(np.abs(expected))
    rotors = [joint.actuator.rotor_inertia for joint in extended.table.joint[WRIST:]]
    taken = 0.0 if cause.adds else INERTIA
    assert rotors == pytest.approx([max(0.0, rotor - own**2 * taken) for own in (ratio, 1.0)])


@pytest.mark.parametrize("added", [True, False])
def test_the_rotor_of_a_shared_drive_comes_besides_those_stated_or_is_one_of_them(added: bool, tmp_path: Path) -> None:
    rotor = 3.0 * INERTIA

    def hidden(instant: Instant) -> np.ndarray:
        return (rotor if added else rotor - INERTIA) * instant.a + shared(instant, INERTIA)

    log, path = write_case(tmp_path, Machine(hidden={WRIST: hidden, WRIST + 1: hidden}), seed=3)
    gap = measure_gap(read_log(log), with_rotors(path, rotor))
    found = fulfilled(build_model(gap, make_nuisance(gap), (Chosen(SumDrive(), Site(WRIST, other=WRIST + 1)),)))
    (choice,) = found.chosen
    assert isinstance(choice.cause, SumAddedRotor if added else SumRotor)
    assert found.strengths[-1] == pytest.approx(INERTIA, rel=0.1)


def test_a_shared_drive_is_not_judged_where_it_turns_about_although_both_joints_move(tmp_path: Path) -> None:
    log, path = write_case(tmp_path, Machine(), seed=3, seconds=20.0)
    gap = measure_gap(read_log(log), read_robot(path))
    model = build_model(gap, make_nuisance(gap), (Chosen(SumDrive(), Site(WRIST, other=WRIST + 1)),))
    turn = np.abs(np.sum(gap.at_rows("velocity")[:, WRIST:], axis=1))
    slowly = np.hypot(*gap.doubt_speed[WRIST:])
    kept = judged(model).clear
    for joint in (WRIST, WRIST + 1):
        left_out = gap.clear[:, joint] & ~kept[:, joint]
        assert np.median(turn[left_out]) < 0.2 * np.median(turn[kept[:, joint]])
        assert np.min(turn[kept[:, joint]]) > 0.5 * slowly
    assert np.array_equal(np.delete(kept, (WRIST, WRIST + 1), axis=1), gap.clear[:, :WRIST])


def test_where_a_drive_reports_late_it_is_not_judged_as_late(tmp_path: Path) -> None:
    log, path = write_case(tmp_path, Machine(), seed=3, seconds=20.0)
    prompt = read_robot(path)
    table = prompt.table.joint[WRIST]
    sensor = table.effort_sensor.model_copy(update={"delay": 0.1})
    late = prompt.with_joint(table.model_copy(update={"effort_sensor": sensor}))
    site = Site(WRIST, other=WRIST + 1)
    known = []
    for robot in (prompt, late):
        gap = measure_gap(read_log(log), robot)
        known.append(SumDrive().known_where(gap, site))
    rows = round(0.1 / gap.chain.step)
    assert np.mean(known[1][WRIST][rows:] == known[0][WRIST][:-rows]) > 0.98
    assert np.mean(known[1][WRIST] == known[0][WRIST]) < 0.95
    assert np.array_equal(known[1][WRIST + 1], known[0][WRIST + 1])


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
