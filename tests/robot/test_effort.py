"""The balance of the robot file, against MuJoCo's inverse dynamics and the laws written out."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from mjfriction.errors import RobotError
from mjfriction.laws.ambient import ambient
from mjfriction.record.log import Log
from mjfriction.record.motion import Motion, estimate_motion
from mjfriction.record.readers import read_log
from mjfriction.robot.effort import friction_states
from mjfriction.robot.files import read_robot
from mjfriction.robot.friction_tables import FrictionTerm
from mjfriction.robot.predict import predict_log
from mjfriction.robot.robot import Robot
from mjfriction.robot.rubbing import direction, friction_along, resting_level, term_torque, unsettled_along
from tests.hidden.machine import Machine, write_case


def test_prediction_is_what_a_noiseless_machine_reports(tmp_path: Path) -> None:
    machine = Machine(noise=0.0, encoder_bits=26)
    log_path, robot_path = write_case(tmp_path, machine, seed=1, seconds=15.0)
    log, robot = read_log(log_path), read_robot(robot_path)
    predicted = predict_log(log, robot)
    assert set(predicted) == {"time"} | {name for name in log.columns if name.startswith("effort.")}
    for name, values in predicted.items():
        if name == "time":
            continue
        # Apart from reversals, where the filter blurs what changes at once.
        measured = log.columns[name]
        reversing = np.abs(np.gradient(log.columns[name.replace("effort", "position")], 1.0 / 250.0)) < 0.1
        moving = ~np.convolve(reversing, np.ones(25), "same").astype(bool)
        error = measured[moving] - values[moving]
        assert np.mean(moving) > 0.4
        assert np.sqrt(np.mean(error**2)) < 2e-3 * np.sqrt(np.mean(measured**2))


def test_currents_go_through_ratio_and_constant(tmp_path: Path) -> None:
    log_path, robot_path = write_case(tmp_path, Machine(), seed=1, seconds=10.0)
    log, robot = read_log(log_path), read_robot(robot_path)
    columns = {name.replace("effort.elbow", "current.elbow"): values for name, values in log.columns.items()}
    in_amperes = replace(log, columns=columns)
    with pytest.raises(
        RobotError, match=r"the log has current.elbow_joint but the robot file no actuator.torque_constant"
    ):
        predict_log(in_amperes, robot)
    elbow = robot.joint("elbow_joint")
    drive = elbow.actuator.model_copy(update={"gear_ratio": -50.0, "torque_constant": 0.1})
    driven = robot.with_joint(elbow.model_copy(update={"actuator": drive}))
    current = predict_log(in_amperes, driven)["current.elbow_joint"]
    np.testing.assert_allclose(-5.0 * current, predict_log(log, robot)["effort.elbow_joint"], rtol=1e-2, atol=1e-2)


def test_a_law_twice_on_a_joint_has_the_states_of_both(tmp_path: Path) -> None:
    log_path, robot_path = write_case(tmp_path, Machine(), seed=1, seconds=5.0)
    robot = read_robot(robot_path)
    body, motion = robot.body(), estimate_motion(read_log(log_path), robot.joints, 20.0)
    soft, stiff = (
        FrictionTerm(
            law="dahl",
            parameters={"coulomb": 3.0, "bristle_stiffness": stiffness, "shape_exponent": 1.0, "viscous": 0.0},
        )
        for stiffness in (30.0, 300.0)
    )
    each = []
    for terms in ((soft,), (stiff,), (soft, stiff)):
        rubbed = robot.with_joint(robot.joint("elbow_joint").model_copy(update={"friction": terms}))
        each.append(friction_states(rubbed, body, motion)["elbow_joint"]["dahl"])
    assert each[0].shape == (motion.time.size, 1)
    assert np.mean(np.abs(each[1])) > np.mean(np.abs(each[0])), "the stiffer one builds up sooner"
    np.testing.assert_array_equal(each[2], np.hstack(each[:2]))


def test_friction_passes_over_as_a_joint_turns_and_is_none_at_rest() -> None:
    velocity = np.array([0.5, 0.2, 0.02, 0.0, -0.02, -0.2, -0.5])
    sure = np.full(7, 0.03)
    forward, speed = direction(velocity, sure)
    np.testing.assert_allclose(forward, [1.0, 1.0, 0.75, 0.5, 0.25, 0.0, 0.0])
    assert np.all(speed > 0.0)
    resting = np.array([0.5, 0.01, -0.01, 0.01, -0.01, 0.01, -0.5])
    np.testing.assert_allclose(direction(resting, sure)[0], [1.0, 0.5, 0.5, 0.5, 0.5, 0.5, 0.0])
    at_rest, _ = direction(np.zeros(5), sure[:5])
    assert at_rest.tolist() == [0.5] * 5
    starting, _ = direction(np.array([0.0, 0.0, 0.3]), sure[:3])
    assert starting.tolist() == [0.5, 0.5, 1.0]


@pytest.mark.parametrize("way", [1.0, -1.0])
def test_a_sample_stands_for_the_time_around_it_where_a_joint_turns_at_once(way: float) -> None:
    """Quick turns at every place between two samples: the mean of sgn v from halfway to halfway."""
    for turn in np.linspace(2.0, 3.0, 11):
        velocity = way * 0.3 * (turn - np.arange(7.0))
        if np.min(np.abs(velocity)) < 1e-3:
            continue
        around = np.arange(7.0)[:, None] + np.linspace(-0.5, 0.5, 2001)
        expected = np.mean(way * (turn - around) > 0.0, axis=1)
        np.testing.assert_allclose(direction(velocity, np.full(7, 1e-3))[0], expected, atol=1e-3)


def moved(velocity: np.ndarray, noise: float) -> Motion:
    count = velocity.size
    time = np.arange(count) / 1000.0
    columns = {"position.a": np.cumsum(velocity) / 1000.0, "effort.a": np.zeros(count)}
    motion = estimate_motion(Log("test", time, np.zeros(count, dtype=np.int64), ("a",), columns), ["a"], 20.0)
    return replace(motion, velocity=velocity[:, None], velocity_noise=np.array([noise]))


def test_springs_that_yield_within_the_noise_are_not_followed() -> None:
    # Along a noisy velocity near rest their state is noise; the law's steady curve is all that can be told.
    rng = np.random.default_rng(1)
    velocity = 0.3 * np.sin(2.0 * np.pi * np.arange(4000) / 2000.0) + 1e-3 * rng.standard_normal(4000)
    law = {"coulomb": 5.0, "static": 9.0, "stribeck_velocity": 0.05, "stribeck_exponent": 2.0, "viscous": 1.0}
    stiff = FrictionTerm(law="lugre", parameters={**law, "bristle_stiffness": 1e9, "bristle_damping": 1e5})
    plain = FrictionTerm(law="stribeck", parameters=law)
    near = ambient(velocity.size)
    told = [term_torque(term, 1.0, moved(velocity, 1e-3), 0, near) for term in (stiff, plain)]
    np.testing.assert_allclose(told[0], told[1], atol=1e-9)
    followed = term_torque(stiff, 1.0, moved(velocity, 0.0), 0, near)
    assert np.max(np.abs(followed - told[1])) > 0.5 * law["static"]


def test_a_joint_at_rest_may_hold_all_that_its_law_gives_there() -> None:
    robot = read_robot("ur5")
    elbow = robot.joint("elbow_joint")
    law = {"coulomb": 5.0, "static": 9.0, "stribeck_velocity": 1e-3, "stribeck_exponent": 2.0, "viscous": 1.0}
    sticky = FrictionTerm(law="stribeck", parameters=law)
    changed = robot.with_joint(elbow.model_copy(update={"friction": (sticky,)}))
    columns = {f"position.{name}": np.sin(np.arange(3000) / 300.0) for name in robot.joints}
    log = Log("test", np.arange(3000) / 1000.0, np.zeros(3000, dtype=np.int64), robot.joints, columns)
    motion = estimate_motion(log, robot.joints, 20.0)
    load = np.zeros((3000, 6))
    level = resting_level(changed, motion, load, load, np.full(6, 0.02))
    assert level[2] == pytest.approx(9.0, rel=0.01)
    assert level[1] == pytest.approx(stated_level(robot, 1), rel=0.03)


@pytest.mark.parametrize(
    ("law", "values"),
    [
        ("maxwell_slip", {"stiffness": (400.0, 200.0), "level": (4.0, 5.0), "viscous": 1.0}),
        ("lugre", {"coulomb": 9.0, "static": 9.0, "stribeck_velocity": 0.1, "bristle_stiffness": 400.0}),
    ],
)
def test_friction_is_settled_once_it_is_what_it_would_be_had_its_motion_been_seen_before(
    law: str, values: dict[str, float]
) -> None:
    if law == "lugre":
        values = values | {"bristle_damping": 1.0, "viscous": 1.0, "stribeck_exponent": 2.0}
    robot = read_robot("ur5")
    elbow = robot.joint("elbow_joint").model_copy(update={"friction": (FrictionTerm(law=law, parameters=values),)})
    robot = robot.with_joint(elbow)
    time, broken_off = np.arange(6000) / 1000.0, (np.arange(6000) >= 3500).astype(np.int64)
    columns = {f"position.{name}": np.sin(2.0 * time) for name in robot.joints}
    load = np.zeros((6000, 6))
    whole, parts = (
        estimate_motion(Log("test", time, segment, robot.joints, columns), robot.joints, 20.0)
        for segment in (np.zeros(6000, dtype=np.int64), broken_off)
    )
    seen, unseen = (friction_along(robot, motion, load, load)[3500:, 2] for motion in (whole, parts))
    unsettled = unsettled_along(robot, parts, load, load)[3500:, 2]
    off = np.abs(unseen - seen)
    assert off[0] > 4.0  # what the springs hold after sliding
    # And what velocities differ by that are told with what was before, and without.
    assert np.all(off[~unsettled] < 0.05 * 9.0 + 0.05)
    told = np.flatnonzero(~unsettled)[0]
    assert np.all(unsettled[:told])
    assert 0.02 < abs(np.ptp(columns["position.elbow_joint"][3500 : 3500 + told])) < 0.2  # some times the travel
    assert not np.any(unsettled_along(read_robot("ur5"), parts, load, load))


def stated_level(robot: Robot, index: int) -> float:
    (term,) = robot.table.joint[index].friction or ()
    return term.value("coulomb")
