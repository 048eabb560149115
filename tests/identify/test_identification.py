"""Hidden friction is recovered from free motion, with intervals that hold it; a wrong law is said to be one."""

from __future__ import annotations

import functools
from pathlib import Path

import numpy as np
import pyarrow as pa
import pytest

from mjfriction.errors import LawError, LogError
from mjfriction.identify import conclude, problem
from mjfriction.identify.colour import NOTHING
from mjfriction.identify.identification import identify_log
from mjfriction.identify.outcome import Identification, JointLaw
from mjfriction.record.log import Log
from mjfriction.record.readers.table import log_from_table
from mjfriction.report.identified import make_identified_report
from mjfriction.robot.files import read_robot, write_robot
from mjfriction.robot.predict import predict_log
from mjfriction.robot.robot import Robot
from tests.hidden.machine import UR5_COULOMB, UR5_JOINTS, UR5_VISCOUS, Machine, record, robot_toml

ELBOW = 2
EXCESS, FADING = 5.0, 0.15
KNOTS = np.linspace(0.0, 40.0, 160)  # of what wanders too fast for any curve over time


def machine(kind: str) -> Machine:
    effects = {
        "plain": None,
        "stribeck": lambda i: EXCESS * np.sign(i.v) * np.exp(-((i.v / FADING) ** 2)),
        "load": lambda i: 0.1 * np.abs(i.rigid) * np.sign(i.v),
        "outside": lambda i: 3.0 * np.sin(7.0 * i.q),
        "wander": lambda i: np.interp(i.time, KNOTS, np.random.default_rng(8).normal(size=KNOTS.size)),
    }
    return Machine(noise=0.1, hidden={ELBOW: effects[kind]} if effects[kind] else {})


def robot_of(machine: Machine, folder: Path, off: float = 0.05) -> Robot:
    (folder / "robot.toml").write_text(robot_toml(machine, off=off), encoding="utf-8")
    return read_robot(folder / "robot.toml")


@functools.cache
def log_of(kind: str, seed: int = 11, seconds: float = 40.0) -> Log:
    return log_from_table(pa.table(record(machine(kind), seed, seconds)), kind)


def at_elbow(identification: Identification) -> JointLaw:
    return next(law for law in identification.laws if law.joint == "elbow_joint")


def test_levels_of_every_joint_are_recovered_within_their_intervals(tmp_path: Path) -> None:
    found = identify_log(log_of("plain"), robot_of(machine("plain"), tmp_path, off=0.3), law="coulomb_viscous")
    assert [law.joint for law in found.laws] == list(UR5_JOINTS)
    for law, coulomb, viscous in zip(found.laws, UR5_COULOMB, UR5_VISCOUS, strict=True):
        values = {fitted.name: fitted for fitted in law.parameters}
        for name, truth in (("coulomb", coulomb), ("viscous", viscous)):
            # Six joints and two values: one of twelve may well lie outside its 95 %, none by as much again.
            half = 0.5 * (values[name].high - values[name].low)
            assert abs(values[name].value - truth) < 2.0 * half
            assert half < 0.05 * truth
        assert law.trusted


@pytest.mark.deep
def test_intervals_hold_the_truth_nine_times_in_ten(tmp_path: Path) -> None:
    robot = robot_of(machine("plain"), tmp_path)
    held = []
    for seed in range(100, 108):
        found = identify_log(log_of("plain", seed, 20.0), robot, law="coulomb_viscous")
        for law, *truth in zip(found.laws, UR5_COULOMB, UR5_VISCOUS, strict=True):
            held += [fitted.low < value < fitted.high for fitted, value in zip(law.parameters, truth, strict=True)]
    assert np.mean(held) > 0.9


@pytest.mark.deep
def test_the_law_that_is_there_is_chosen_and_its_values_found(tmp_path: Path) -> None:
    found = identify_log(log_of("stribeck"), robot_of(machine("stribeck"), tmp_path))
    laws = {law.joint: law.fit.law.name for law in found.laws}
    assert laws.pop("elbow_joint") == "stribeck"
    assert set(laws.values()) == {"coulomb_viscous"}
    values = {fitted.name: fitted for fitted in at_elbow(found).parameters}
    assert values["coulomb"].low < UR5_COULOMB[ELBOW] < values["coulomb"].high
    assert values["static"].low < UR5_COULOMB[ELBOW] + EXCESS < values["static"].high
    assert values["stribeck_velocity"].low < FADING < values["stribeck_velocity"].high
    assert values["stribeck_exponent"].low < 2.0 < values["stribeck_exponent"].high


@pytest.mark.deep
def test_load_dependence_is_chosen_where_it_is(tmp_path: Path) -> None:
    law = at_elbow(identify_log(log_of("load"), robot_of(machine("load"), tmp_path)))
    assert law.fit.law.name == "load_dependent"
    values = {fitted.name: fitted for fitted in law.parameters}
    assert values["load"].low < 0.1 < values["load"].high


@pytest.mark.parametrize("kind", ["stribeck", "load", "outside"])
def test_a_law_that_does_not_hold_is_said_not_to(kind: str, tmp_path: Path) -> None:
    found = identify_log(log_of(kind), robot_of(machine(kind), tmp_path), law="coulomb_viscous")
    assert not at_elbow(found).trusted
    assert "elbow_joint" in found.summary
    assert all(law.trusted for law in found.laws if law.joint != "elbow_joint")


def test_friction_alone_is_fitted_where_nothing_else_is_free(tmp_path: Path) -> None:
    # Links as stated, and a law whose two levels hold the zero of the effort too: nothing stands beside it.
    robot = robot_of(machine("plain"), tmp_path)
    found = identify_log(log_of("plain"), robot, law="asymmetric", links=False)
    assert found.background == ()
    values = {fitted.name: fitted for fitted in at_elbow(found).parameters}
    for name in ("coulomb_positive", "coulomb_negative"):
        assert values[name].value == pytest.approx(UR5_COULOMB[ELBOW], rel=0.03)


def test_a_hand_on_the_arm_does_not_bend_its_friction(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    columns = record(machine("plain"), 11, 40.0)
    for start in (4.0, 11.0, 17.5, 23.0, 30.0, 36.0):  # six pushes of 40 N·m, a twentieth of the log in all
        swing = np.clip((columns["time"] - start) / 0.35, 0.0, 1.0)
        columns["effort.elbow_joint"] = columns["effort.elbow_joint"] + 40.0 * np.sin(np.pi * swing) ** 2
    log, robot = log_from_table(pa.table(columns), "pushed"), robot_of(machine("plain"), tmp_path)

    def missed() -> float:
        values = {p.name: p.value for p in at_elbow(identify_log(log, robot, law="coulomb_viscous")).parameters}
        pairs = ((values["coulomb"], UR5_COULOMB[ELBOW]), (values["viscous"], UR5_VISCOUS[ELBOW]))
        return max(abs(value / truth - 1.0) for value, truth in pairs)

    bent = missed()
    assert bent < 0.03
    monkeypatch.setattr(problem, "OUTLYING", np.inf)
    assert missed() > 4.0 * bent


def test_what_is_no_noise_but_follows_nothing_is_said_too(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    robot = robot_of(machine("wander"), tmp_path)
    found = identify_log(log_of("wander"), robot, law="coulomb_viscous")
    assert not at_elbow(found).trusted
    assert at_elbow(found).follows == NOTHING
    assert all(law.trusted for law in found.laws if law.joint != "elbow_joint")
    monkeypatch.setattr(conclude, "COLOURED", 1.0)
    assert at_elbow(identify_log(log_of("wander"), robot, law="coulomb_viscous")).trusted


@pytest.mark.deep
def test_the_identified_robot_predicts_another_motion(tmp_path: Path) -> None:
    robot = robot_of(machine("stribeck"), tmp_path, off=0.3)
    found = identify_log(log_of("stribeck"), robot)
    (tmp_path / "out").mkdir()
    written = read_robot(write_robot(found.robot, tmp_path / "out"))
    other = log_of("stribeck", seed=12)
    measured = other.columns["effort.elbow_joint"]
    errors = [
        float(np.sqrt(np.nanmean((measured - predict_log(other, r)["effort.elbow_joint"]) ** 2)))
        for r in (robot, written)
    ]
    assert errors[1] < 0.6 * errors[0]


@pytest.mark.deep
def test_what_the_log_does_not_show_is_named(tmp_path: Path) -> None:
    # The machine has no bristle, so that none of a LuGre law's can be fixed.
    law = at_elbow(identify_log(log_of("plain"), robot_of(machine("plain"), tmp_path), law="lugre"))
    notes = {fitted.name: fitted.note for fitted in law.parameters}
    assert notes["bristle_stiffness"] or notes["bristle_damping"]


def test_unknown_laws_are_refused(tmp_path: Path) -> None:
    robot = robot_of(machine("plain"), tmp_path)
    with pytest.raises(LawError, match="did you mean 'lugre'"):
        identify_log(log_of("plain"), robot, law="lugree")


def test_a_log_without_motion_is_refused(tmp_path: Path) -> None:
    columns = {
        name: np.full_like(values, values[0]) if name.startswith("position") else values
        for name, values in record(machine("plain"), 3, 10.0).items()
    }
    with pytest.raises(LogError):
        identify_log(log_from_table(pa.table(columns), "still"), robot_of(machine("plain"), tmp_path))


def test_a_drive_that_reports_one_value_is_left_out(tmp_path: Path) -> None:
    columns = dict(record(machine("plain"), 11, 20.0))
    columns["effort.wrist_3_joint"] = np.full_like(columns["effort.wrist_3_joint"], 0.7)
    log = log_from_table(pa.table(columns), "dead")
    found = identify_log(log, robot_of(machine("plain"), tmp_path), law="coulomb_viscous")
    assert "wrist_3_joint" not in [law.joint for law in found.laws]
    assert len(found.laws) == 5


@pytest.mark.deep
def test_the_summary_says_which_way_the_error_went(tmp_path: Path) -> None:
    truth = robot_of(machine("plain"), tmp_path, off=0.0)
    near = identify_log(log_of("plain"), truth, law="coulomb_viscous").summary
    assert " goes from " in near  # an exact stated friction cannot be bettered by one fitted to noise
    assert "rises" not in near
    # Without damping no law can be as near as the truth that was stated.
    worse = identify_log(log_of("plain"), truth, law="coulomb").summary
    assert "It rises at " in worse
    assert "the stated friction was nearer than this law can be" in worse
    far = identify_log(log_of("stribeck"), robot_of(machine("plain"), tmp_path, off=0.3), law="coulomb_viscous")
    assert " falls from " in far.summary


def test_a_drive_that_gave_no_more_is_named_and_its_samples_are_not_used(tmp_path: Path) -> None:
    columns = record(machine("plain"), 11, 30.0)
    whole = columns["effort.elbow_joint"]
    most = 0.8 * float(np.max(np.abs(whole)))
    columns["effort.elbow_joint"] = np.clip(whole, -most, most)
    found = identify_log(
        log_from_table(pa.table(columns), "clipped"), robot_of(machine("plain"), tmp_path), law="coulomb_viscous"
    )
    (problem,) = make_identified_report(found).data_problems
    assert problem.kind == "data.saturation"
    assert problem.where.startswith("effort.elbow_joint")
    assert "record slower motion" in problem.action
    values = {fitted.name: fitted for fitted in at_elbow(found).parameters}
    assert values["coulomb"].low < UR5_COULOMB[ELBOW] < values["coulomb"].high
    assert values["viscous"].low < UR5_VISCOUS[ELBOW] < values["viscous"].high
