"""A drive of a joint's own that turns with its neighbour too: what is stated of its friction turns with both."""

from __future__ import annotations

import inspect
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pyarrow as pa
import pytest

from mjfriction.benchmark.cases import Setting, make_case
from mjfriction.benchmark.effects.drive import turned_too
from mjfriction.benchmark.effects.effect import Effect, Place, sign
from mjfriction.diagnose.causes.carried_drive import (
    DifferenceCarried,
    DifferenceCarriedRotor,
    SumCarried,
    SumCarriedRotor,
)
from mjfriction.diagnose.causes.cause import Site
from mjfriction.diagnose.causes.coupling import SumDrive
from mjfriction.diagnose.diagnosis import diagnose_log
from mjfriction.diagnose.fit.exact import level_changes
from mjfriction.diagnose.fit.model import Chosen, Model, build_model
from mjfriction.diagnose.fit.nuisance import make_nuisance
from mjfriction.diagnose.search import compete
from mjfriction.diagnose.search.field import chances_in
from mjfriction.diagnose.search.one_transmission import leaning
from mjfriction.diagnose.settle.levels_kept import drives_besides
from mjfriction.diagnose.tell.outcome import Diagnosis, Verdict
from mjfriction.identify.measure import measure_gap
from mjfriction.record.log import Log
from mjfriction.record.readers import read_log
from mjfriction.record.readers.table import log_from_table
from mjfriction.robot.effort import predict_effort
from mjfriction.robot.files import read_robot
from tests.hidden.machine import UR5_COULOMB, UR5_JOINTS, UR5_VISCOUS, Instant, Machine, write_case

WRIST = 4
ROTOR = 0.08


def turning(own: int, neighbour: int, ratio: float) -> dict[int, Callable[[Instant], np.ndarray]]:
    """Return what it makes of two joints' efforts that the drive of one turns with the other too."""
    coulomb, viscous = UR5_COULOMB[own], UR5_VISCOUS[own]

    def rubs(speed: np.ndarray) -> np.ndarray:
        return coulomb * np.sign(speed) + viscous * speed

    def turn(instant: Instant) -> np.ndarray:
        return instant.velocities[:, own] + ratio * instant.velocities[:, neighbour]

    return {
        own: lambda instant: rubs(turn(instant)) - rubs(instant.velocities[:, own]),
        neighbour: lambda instant: ratio * rubs(turn(instant)),
    }


def told(machine: Machine, own: int, folder: Path) -> tuple[Log, Diagnosis, dict[str, float]]:
    """Return the log of a machine, its diagnosis, and what the one finding of that says of a joint's drive."""
    path, robot = write_case(folder, machine, seed=3, seconds=40.0)
    log = read_log(path)
    diagnosis = diagnose_log(log, read_robot(robot))
    (finding,) = diagnosis.findings
    assert (finding.cause, finding.joint) == ("drive.coupling", UR5_JOINTS[own])
    return log, diagnosis, {fitted.name: fitted.value for fitted in finding.parameters}


@pytest.mark.deep
@pytest.mark.parametrize(
    ("own", "neighbour", "ratio"),
    [(WRIST + 1, WRIST, 0.15), (WRIST, WRIST + 1, -0.8)],
)
def test_it_is_one_finding_at_the_joint_whose_drive_it_is(
    own: int, neighbour: int, ratio: float, tmp_path: Path
) -> None:
    log, diagnosis, found = told(Machine(hidden=turning(own, neighbour, ratio)), own, tmp_path)
    truth = {"coulomb": UR5_COULOMB[own], "viscous": UR5_VISCOUS[own], "ratio": abs(ratio)}
    assert found == pytest.approx(truth, rel=0.1)
    # None of its friction is left to the joint alone.
    (drive,) = diagnosis.robot.joint(UR5_JOINTS[own]).common_drive
    assert np.sign(drive.ratio) == np.sign(ratio)
    left = sum(term.value("coulomb") for term in diagnosis.robot.joint(UR5_JOINTS[own]).friction or ())
    assert left < 0.1 * UR5_COULOMB[own]
    assert diagnose_log(log, diagnosis.robot).verdict is Verdict.CONSISTENT


@pytest.mark.deep
def test_where_the_neighbour_leans_on_the_drive_that_is_the_same_finding(tmp_path: Path) -> None:
    """Its own drive then reports so much less of what the other gives, in place of a part of the other's friction."""
    own, neighbour, ratio = 2, 3, 0.2
    leant_on: list[np.ndarray] = []
    turned = turning(own, neighbour, ratio)[own]

    def turn(instant: Instant) -> np.ndarray:
        leant_on.append(instant.rigid)
        return turned(instant)

    machine = Machine(hidden={own: turn, neighbour: lambda _: -ratio * leant_on[-1]})
    log, diagnosis, found = told(machine, own, tmp_path)
    assert found["ratio"] == pytest.approx(ratio, rel=0.1)
    assert found["effort"] == pytest.approx(-ratio, rel=0.1)
    assert diagnosis.verdict is Verdict.EXPLAINED
    assert diagnose_log(log, diagnosis.robot).verdict is Verdict.CONSISTENT


@pytest.mark.parametrize(("carried", "leans"), [(-0.2, True), (0.2, False), (-0.5, False)])
def test_a_neighbour_leans_by_the_ratio_or_not_at_all(carried: float, leans: bool, tmp_path: Path) -> None:
    own, neighbour, ratio = 2, 3, 0.2
    given: list[np.ndarray] = []
    turned, feels = (turning(own, neighbour, ratio)[joint] for joint in (own, neighbour))

    def turn(instant: Instant) -> np.ndarray:
        given.append(instant.rigid + instant.friction + turned(instant))
        return turned(instant)

    machine = Machine(hidden={own: turn, neighbour: lambda instant: feels(instant) + carried * given[-1]})
    log, robot = write_case(tmp_path, machine, seed=3, seconds=20.0)
    gap = measure_gap(read_log(log), read_robot(robot))
    drive = Chosen(SumCarried(), Site(neighbour, (ratio,), other=own))
    model = leaning(build_model(gap, make_nuisance(gap), (drive,)), chances_in(()))
    assert [choice.cause.name for choice in model.chosen] == ["drive.coupling"] * (1 + leans)


@pytest.mark.deep
def test_the_rotor_is_told_where_it_shows() -> None:
    """In MuJoCo, all of a wrist's friction and rotor turn with both."""

    def draw(rng: np.random.Generator, place: Place) -> Effect:
        names = place.robot.joints
        i = names.index(place.joint)
        return turned_too(place, names[i + 1] if i + 1 < len(names) else names[i - 1], sign(rng))

    case = make_case(1, Setting(seconds=50.0, rate=250.0, encoder=1.2e-5), (draw,), 5.0)
    (finding,) = diagnose_log(log_from_table(pa.table(case.log), "case"), case.stated).findings
    assert (finding.cause, finding.joint) == ("drive.coupling", case.hidden[0].joint)
    found = {fitted.name: fitted.value for fitted in finding.parameters}
    rotor = case.stated.joint(case.hidden[0].joint or "").actuator.reflected_inertia
    assert found["inertia"] == pytest.approx(rotor, rel=0.1)
    assert found["ratio"] == pytest.approx(case.hidden[0].strength, rel=0.05)


@pytest.mark.parametrize("cause", [SumCarriedRotor(), DifferenceCarriedRotor()])
@pytest.mark.parametrize("neighbour", [WRIST - 1, WRIST + 1])
def test_what_turns_with_both_is_what_the_extended_robot_predicts(
    cause: SumCarriedRotor | DifferenceCarriedRotor, neighbour: int, tmp_path: Path
) -> None:
    log, path = write_case(tmp_path, Machine(), seed=3, seconds=10.0)
    robot = read_robot(path)
    table = robot.table.joint[WRIST]
    actuator = table.actuator.model_copy(update={"rotor_inertia": ROTOR / table.actuator.gear_ratio**2})
    gap = measure_gap(read_log(log), robot.with_joint(table.model_copy(update={"actuator": actuator})))
    strengths, site = np.array([1.2, 0.5, 0.6 * ROTOR]), Site(neighbour, (0.3,), other=WRIST)
    extended = cause.extend(gap.robot, site, strengths)
    before, after = (predict_effort(one, one.body(), gap.motion).reported for one in (gap.robot, extended))
    expected = np.zeros_like(before)
    expected[:, neighbour] = cause.samples(gap, site) @ strengths
    expected[:, WRIST] = cause.at_drive(gap, site, WRIST) @ strengths
    # While a joint turns over, its own damping is taken at a speed that is not quite zero.
    assert np.max(np.abs(after - before - expected)) < 1e-3 * np.max(np.abs(expected))


def test_it_takes_no_more_than_is_stated_and_stands_against_the_motion(tmp_path: Path) -> None:
    log, robot = write_case(tmp_path, Machine(), seed=3, seconds=10.0)
    gap = measure_gap(read_log(log), read_robot(robot))
    coulomb, viscous = UR5_COULOMB[WRIST], UR5_VISCOUS[WRIST]
    site = Site(WRIST - 1, (0.3,), other=WRIST)
    for cause in (SumCarried(), DifferenceCarried()):
        assert cause.admissible(gap, site, np.array([coulomb, viscous]))
        assert not cause.admissible(gap, site, 1.3 * np.array([coulomb, viscous]))
        assert not cause.admissible(gap, site, np.array([-0.1 * coulomb, 0.0]))
        # What is less when slow and more when fast is two values that make up for each other.
        assert cause.admissible(gap, site, np.array([0.8 * coulomb, 1.2 * viscous]))
    # A rotor of which nothing is stated cannot turn with another joint.
    assert not SumCarriedRotor().admissible(gap, site, np.array([coulomb, viscous, 0.01]))


@pytest.mark.deep
def test_a_rotor_that_turns_too_is_told_at_once_or_much_is_asked_in_vain(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    own, neighbour, ratio, inertia = WRIST - 1, WRIST, -0.76, 1.0
    rubs = turning(own, neighbour, ratio)

    def spins(at: Instant) -> np.ndarray:
        hard = np.gradient(at.velocities, at.time, axis=0)
        return inertia * (hard[:, own] + ratio * hard[:, neighbour])

    hidden = {own: lambda at: rubs[own](at) + spins(at), neighbour: lambda at: rubs[neighbour](at) + ratio * spins(at)}
    log, path = write_case(tmp_path, Machine(hidden=hidden, noise=0.02), seed=3, off=0.03)
    robot = read_robot(path)
    table = robot.table.joint[own]
    actuator = table.actuator.model_copy(update={"rotor_inertia": inertia / table.actuator.gear_ratio**2})
    robot = robot.with_joint(table.model_copy(update={"actuator": actuator}))
    fulfilled, ranked, asked = compete.fulfilled, compete.ranked, []
    monkeypatch.setattr(compete, "ranked", lambda model, field: (asked.append(model), ranked(model, field))[1])
    (finding,) = diagnose_log(read_log(log), robot).findings
    assert (finding.cause, finding.joint) == ("drive.coupling", UR5_JOINTS[own])
    found = {fitted.name: fitted.value for fitted in finding.parameters}
    truth = {"coulomb": UR5_COULOMB[own], "viscous": UR5_VISCOUS[own], "inertia": inertia, "ratio": abs(ratio)}
    assert found == pytest.approx(truth, rel=0.02)
    at_once = len(asked)

    def at_last(model: Model) -> Model:
        return model if inspect.stack()[1].function == "_forward" else fulfilled(model)

    monkeypatch.setattr(compete, "fulfilled", at_last)
    diagnose_log(read_log(log), robot)
    assert len(asked) - at_once > 2 * at_once


@pytest.mark.deep
@pytest.mark.parametrize("ratio", [0.7, -0.9])
def test_one_besides_the_joints_own_is_no_level_that_is_off(ratio: float, tmp_path: Path) -> None:
    # What turns with both rubs as much again as half of what is stated of the wrist.
    coulomb, own, neighbour = 0.5 * UR5_COULOMB[WRIST], WRIST, WRIST - 1

    def rubs(instant: Instant) -> np.ndarray:
        return coulomb * np.sign(instant.velocities[:, own] + ratio * instant.velocities[:, neighbour])

    hidden: dict[int, Callable[[Instant], np.ndarray]] = {own: rubs, neighbour: lambda one: ratio * rubs(one)}
    log, robot = write_case(tmp_path, Machine(hidden=hidden), seed=3, seconds=40.0)
    found = diagnose_log(read_log(log), read_robot(robot))
    (finding,) = found.findings
    assert (finding.cause, found.verdict) == ("drive.coupling", Verdict.EXPLAINED)
    assert finding.joint in {UR5_JOINTS[own], UR5_JOINTS[neighbour]}
    # It is told per turn of the one joint or of the other.
    told = {fitted.name: fitted.value for fitted in finding.parameters}
    by_own, by_neighbour = (coulomb, abs(ratio)), (abs(ratio) * coulomb, 1.0 / abs(ratio))
    assert (told["coulomb"], told["ratio"]) in (pytest.approx(by_own, rel=0.02), pytest.approx(by_neighbour, rel=0.02))


@pytest.mark.parametrize("own", [WRIST, WRIST + 1])
@pytest.mark.parametrize("additional", [True, False])
def test_a_drive_whose_friction_no_joint_states_is_an_additional_one(
    own: int, additional: bool, tmp_path: Path
) -> None:
    """With free levels it fits as well that a joint's own drive turns with both and the joint rubs as much more."""
    neighbour = 2 * WRIST + 1 - own

    def rubs(instant: Instant) -> np.ndarray:
        turn = instant.velocities[:, own] + instant.velocities[:, neighbour]
        return 0.4 * np.sign(turn) + 0.5 * turn

    hidden = {own: rubs, neighbour: rubs} if additional else turning(own, neighbour, 1.0)
    log, robot = write_case(tmp_path, Machine(hidden=hidden), seed=3, seconds=20.0)
    gap = measure_gap(read_log(log), read_robot(robot))
    carried = Chosen(SumCarried(), Site(neighbour, (1.0,), other=own))
    found = drives_besides(build_model(gap, make_nuisance(gap), (carried,)))
    (choice,) = found.chosen
    assert isinstance(choice.cause, SumDrive if additional else SumCarried)
    if additional:
        assert found.strengths_of(choice) == pytest.approx([0.4, 0.5], rel=0.1)


@pytest.mark.parametrize("ratio", [1.0, 0.5])
def test_its_ratio_is_the_one_beside_which_levels_are_near(ratio: float, tmp_path: Path) -> None:
    """Beside free levels, the equal one fits as well, and leaves the joint's damping as far off as the carried one."""
    neighbour = WRIST - 1

    def rubs(instant: Instant) -> np.ndarray:
        return 0.8 * (instant.velocities[:, WRIST] + ratio * instant.velocities[:, neighbour])

    hidden: dict[int, Callable[[Instant], np.ndarray]] = {WRIST: rubs, neighbour: lambda one: ratio * rubs(one)}
    log, robot = write_case(tmp_path, Machine(hidden=hidden), seed=1, seconds=20.0)
    gap = measure_gap(read_log(log), read_robot(robot))
    found = drives_besides(
        build_model(gap, make_nuisance(gap), (Chosen(SumCarried(), Site(neighbour, (0.5,), other=WRIST)),))
    )
    (choice,) = found.chosen
    assert isinstance(choice.cause, SumDrive)
    assert max(level_changes(found)[joint] for joint in (WRIST, neighbour)) < 0.02


def test_a_neighbour_of_which_no_friction_is_stated_does_not_hide_it(tmp_path: Path) -> None:
    neighbour = WRIST + 1

    def rubs(instant: Instant) -> np.ndarray:
        turn = instant.velocities[:, WRIST] + instant.velocities[:, neighbour]
        return 0.4 * np.sign(turn) + 0.5 * turn

    machine = Machine(
        hidden={WRIST: rubs, neighbour: rubs},
        coulomb=(*UR5_COULOMB[:neighbour], 0.0),
        viscous=(*UR5_VISCOUS[:neighbour], 0.0),
        noise=0.0,
    )
    log, path = write_case(tmp_path, machine, seed=3, seconds=20.0)
    robot = read_robot(path)
    robot = robot.with_joint(robot.table.joint[neighbour].model_copy(update={"friction": ()}))
    gap = measure_gap(read_log(log), robot)
    carried = Chosen(SumCarried(), Site(neighbour, (1.0,), other=WRIST))
    (choice,) = drives_besides(build_model(gap, make_nuisance(gap), (carried,))).chosen
    assert isinstance(choice.cause, SumDrive)
