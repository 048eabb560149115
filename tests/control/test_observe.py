"""Friction along a log of six axes, as observers estimate it, held against the friction that acted."""

from __future__ import annotations

import numpy as np
import pyarrow as pa
import pytest

from mjfriction.control import observe
from mjfriction.control.observe import OBSERVERS, observe_log
from mjfriction.control.servo import Control
from mjfriction.errors import ControlError
from mjfriction.identify.protocol import plan_excitation
from mjfriction.plant.machine import log_columns, run_machine
from mjfriction.plant.sensors import Recorder
from mjfriction.plant.trajectory import Trajectory
from mjfriction.record.log import Log
from mjfriction.record.readers.table import log_from_table
from mjfriction.robot.files import read_robot
from mjfriction.robot.friction_tables import FrictionTerm
from mjfriction.robot.robot import Robot


@pytest.fixture(scope="module")
def arm() -> Robot:
    robot = read_robot("ur5")
    for joint in robot.table.joint:
        (term,) = joint.friction or ()
        level = term.value("coulomb")
        values = {
            "coulomb": level,
            "static": 1.3 * level,
            "stribeck_velocity": 0.05,
            "stribeck_exponent": 1.0,
            "viscous": term.value("viscous"),
            "bristle_stiffness": 1e3 * level,
            "bristle_damping": 10.0 * level,
        }
        robot = robot.with_joint(joint.model_copy(update={"friction": (FrictionTerm(law="lugre", parameters=values),)}))
    return robot


@pytest.fixture(scope="module")
def recorded(arm: Robot) -> tuple[Log, np.ndarray]:
    motion, recorder = plan_excitation(arm, 15.0).trajectory, Recorder(500.0)
    run = run_machine(arm, motion, 500.0, Control())
    columns = log_columns(arm, motion, recorder, run, 0)
    true = np.column_stack([np.interp(columns["time"], run.time, own) for own in run.played.friction.T])
    return log_from_table(pa.table(columns), "excited"), true


@pytest.mark.parametrize("bandwidth", [5.0, 15.0])
@pytest.mark.parametrize("name", OBSERVERS)
def test_every_joints_friction_is_met(
    arm: Robot, recorded: tuple[Log, np.ndarray], name: str, bandwidth: float
) -> None:
    log, true = recorded
    found = observe_log(log, arm, name, bandwidth)
    for i, joint in enumerate(arm.joints):
        error = (found[f"friction.{joint}"] - true[:, i])[500:-500]
        # Friction of level F that turns over f times a second, told a time T late, is missed by 2F·√(fT) in the mean:
        # 0.28 of it for a time constant at 5 Hz and, as these joints do, two thirds of a turn a second.
        assert np.sqrt(np.mean(np.square(error))) < 0.28 * np.sqrt(np.mean(np.square(true[:, i])))
        assert found[f"velocity.{joint}"].shape == log.time.shape


def test_nothing_is_told_before_an_observer_has_settled(arm: Robot, recorded: tuple[Log, np.ndarray]) -> None:
    told = observe_log(recorded[0], arm, "disturbance", 10.0)["friction.elbow_joint"]
    settling = round(4.0 / (2.0 * np.pi * 10.0) * 500.0)
    assert np.all(np.isnan(told[: settling - 1]))
    assert np.all(np.isfinite(told[settling + 1 : -1]))


def test_the_balance_is_nearer_than_any_observer_that_knows_no_law(
    arm: Robot, recorded: tuple[Log, np.ndarray]
) -> None:
    log, true = recorded
    errors = {}
    for name in OBSERVERS:
        found = observe_log(log, arm, name, 10.0)["friction.elbow_joint"]
        errors[name] = float(np.sqrt(np.mean(np.square((found - true[:, 2])[500:-500]))))
    assert errors["balance"] < min(error for name, error in errors.items() if name not in ("balance", "bristle"))


def test_the_jumps_of_a_drive_at_a_reversal_are_none_of_the_friction(monkeypatch: pytest.MonkeyPatch) -> None:
    # A controller that feeds friction forward turns it over within a step; the acceleration that follows is over before
    # a position can show it.
    arm = read_robot("comau_ns12")
    time = np.arange(0.0, 5.0, 0.001)
    turning = 0.3 * (1.0 - np.cos(np.pi * time))[:, None] * np.ones(6)
    motion = Trajectory(arm.joints, time, turning)
    run = run_machine(arm, motion, 1000.0, Control(bandwidth=20.0, friction="law"))
    columns = log_columns(arm, motion, Recorder(1000.0), run, 0)
    log = log_from_table(pa.table(columns), "turning")
    true = np.column_stack([np.interp(columns["time"], run.time, own) for own in run.played.friction.T])[500:-500]

    def most() -> np.ndarray:
        found = observe_log(log, arm, "balance")
        seen = np.column_stack([found[f"friction.{joint}"] for joint in arm.joints])[500:-500]
        return np.max(np.abs(seen - true), axis=0) / np.max(np.abs(true), axis=0)

    # Friction that jumps from F to −F is off by F where it is smoothed, and the filter overshoots by a few percent.
    assert np.all(most() < 1.1)
    monkeypatch.setattr(observe, "smooth_derivatives", lambda _, values: [values])
    assert np.any(most() > 2.0)


def test_a_drive_that_reports_late_is_put_back_in_time(arm: Robot) -> None:
    late = arm
    for joint in arm.table.joint:
        sensor = joint.effort_sensor.model_copy(update={"delay": 0.02})
        late = late.with_joint(joint.model_copy(update={"effort_sensor": sensor}))
    motion = plan_excitation(arm, 10.0).trajectory
    run = run_machine(late, motion, 500.0, Control())
    columns = log_columns(late, motion, Recorder(500.0), run, 0)
    log = log_from_table(pa.table(columns), "late")
    true = np.interp(columns["time"], run.time, run.played.friction[:, 2])
    errors = [
        np.sqrt(np.mean(np.square((observe_log(log, robot, "balance")["friction.elbow_joint"] - true)[500:-500])))
        for robot in (late, arm)
    ]
    assert errors[0] < 0.5 * errors[1]


def test_a_law_that_is_known_is_followed_twice_as_near(arm: Robot, recorded: tuple[Log, np.ndarray]) -> None:
    log, true = recorded
    errors = []
    for name in ("bristle", "disturbance"):
        found = observe_log(log, arm, name, 10.0)["friction.elbow_joint"]
        errors.append(np.sqrt(np.mean(np.square((found - true[:, 2])[500:-500]))))
    assert errors[0] < 0.5 * errors[1]


def test_a_faster_observer_lags_less(arm: Robot, recorded: tuple[Log, np.ndarray]) -> None:
    log, true = recorded

    def error(bandwidth: float) -> float:
        found = observe_log(log, arm, "disturbance", bandwidth)["friction.elbow_joint"]
        return float(np.sqrt(np.mean(np.square((found - true[:, 2])[1000:-500]))))

    assert error(20.0) < 0.8 * error(5.0)


def test_what_cannot_be_observed_is_refused_by_name(arm: Robot, recorded: tuple[Log, np.ndarray]) -> None:
    log, _ = recorded
    with pytest.raises(ControlError, match="no observer 'tafazolli'; did you mean 'tafazoli'"):
        observe_log(log, arm, "tafazolli")
    with pytest.raises(ControlError, match="bandwidth = -1 Hz"):
        observe_log(log, arm, "tafazoli", -1.0)
    with pytest.raises(ControlError, match="joint 'shoulder_pan_joint': the bristle observer goes by"):
        observe_log(log, read_robot("ur5"), "bristle")
