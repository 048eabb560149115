"""Motions stay within what they were given, and show what they are for."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pyarrow.parquet
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mjfriction.errors import LogError, RobotError
from mjfriction.identify.protocol import UNSTATED_SPEED, candidate_motions, plan_excitation, room
from mjfriction.identify.usual_motions import (
    plan_loops,
    plan_pick_and_place,
    plan_sawtooth,
    plan_sine,
    plan_voltages,
)
from mjfriction.plant.cylinder import speed_per_volt
from mjfriction.plant.machine import run_machine
from mjfriction.plant.motions import (
    KNOTS,
    excitation,
    forward_backward,
    inner_loops,
    pick_and_place,
    sawtooth,
    sine,
    trapezoid,
    valve_steps,
)
from mjfriction.plant.trajectory import read_trajectory
from mjfriction.robot.files import read_robot
from mjfriction.robot.robot import bundled_robots


@settings(max_examples=15)
@given(seed=st.integers(0, 10**6), reach=st.floats(0.1, 1.5), speed=st.floats(0.1, 3.0))
def test_an_excitation_keeps_its_limits_and_begins_and_ends_at_rest(seed: int, reach: float, speed: float) -> None:
    centre = np.array([0.3, -1.0])
    made = excitation(("a", "b"), centre, np.full(2, reach), np.full(2, speed), 20.0, seed=seed)
    assert np.all(np.abs(made.position - centre) <= reach * (1.0 + 1e-9))
    _, velocity, _ = made.at(made.time)
    assert np.max(np.abs(velocity)) <= speed * 1.01
    np.testing.assert_allclose(made.position[[0, -1]], [centre, centre], atol=1e-9)
    assert np.max(np.abs(velocity[[0, -1]])) < 1e-9


@pytest.mark.parametrize(("name", "joint"), [("ur5", 2), ("machine_table", 0), ("comau_ns12", 1)])
def test_a_joint_moved_to_its_sides_stays_within_its_limits(name: str, joint: int) -> None:
    robot = read_robot(name)
    body = robot.body()
    middle, reach = room(body)
    top = np.minimum(body.top_speed, UNSTATED_SPEED)
    for side in (-1.0, 1.0):
        (alone,) = candidate_motions(robot.joints, body, top, joint, all_joints=False, side=side)
        moved = alone.position[:, joint]
        assert np.min(moved) >= body.lower[joint] - 1e-9
        assert np.max(moved) <= body.upper[joint] + 1e-9
        assert np.ptp(moved) == pytest.approx(2.0 * reach[joint])
        # As far aside as the range allows, or by a quarter of a turn.
        stop = body.upper[joint] if side > 0.0 else body.lower[joint]
        nearest = np.max(moved) if side > 0.0 else np.min(moved)
        aside = abs(0.5 * (np.max(moved) + np.min(moved)) - middle[joint])
        assert nearest == pytest.approx(stop) or aside == pytest.approx(0.5 * np.pi)
        np.testing.assert_allclose(np.delete(np.ptp(alone.position, axis=0), joint), 0.0)


def test_every_speed_has_its_phase_in_both_directions() -> None:
    speeds = (0.05, 0.2, 0.8)
    made = forward_backward("a", 0.1, 1.2, speeds, 4.0)
    _, velocity, _ = made.at(made.time)
    for speed in speeds:
        for sign in (1.0, -1.0):
            steady = np.abs(velocity[:, 0] - sign * speed) < 1e-3 * speed
            expected = 1.2 / speed - speed / 4.0
            assert np.count_nonzero(steady) / 250.0 == pytest.approx(expected, rel=0.05)


def test_a_degenerate_trapezoid_is_refused_with_the_speed_that_would_do() -> None:
    with pytest.raises(LogError, match=r"joint 'a': at 3 the trapezoid degenerates .* below 2.191"):
        forward_backward("a", 0.0, 1.2, (0.1, 3.0), 4.0)


@given(stroke=st.floats(0.05, 5.0), speed=st.floats(0.05, 5.0), acceleration=st.floats(0.1, 20.0))
def test_a_trapezoid_covers_its_stroke(stroke: float, speed: float, acceleration: float) -> None:
    place = trapezoid(stroke, speed, acceleration)
    assert place[-1] == pytest.approx(stroke)
    steps = np.diff(place, prepend=0.0)
    assert np.all(steps >= -1e-12 * stroke)
    assert np.all(steps <= speed / 250.0 * (1.0 + 1e-6))


def test_a_sawtooth_turns_at_its_amplitudes_at_one_speed() -> None:
    made = sawtooth("a", 0.5, (0.3, 0.1), 0.05)
    assert np.max(made.position) == pytest.approx(0.8, abs=1e-3)
    assert np.min(made.position) == pytest.approx(0.2, abs=1e-3)
    speed = np.abs(np.diff(made.position[:, 0])) * 250.0
    assert np.quantile(speed, 0.1) == pytest.approx(0.05, rel=1e-6)


def test_a_sine_swings_and_pick_and_place_visits_its_poses() -> None:
    swing = sine("a", 1.0, 0.2, 0.5, 6.0)
    assert np.ptp(swing.position) == pytest.approx(0.4, rel=1e-3)
    poses = np.array([[0.0, 0.0], [1.0, -0.5], [0.5, 0.5]])
    made = pick_and_place(("a", "b"), poses, np.full(2, 1.0), np.full(2, 3.0), rounds=2)
    for pose in poses:
        assert np.min(np.linalg.norm(made.position - pose, axis=1)) < 1e-6
    _, velocity, acceleration = made.at(made.time)
    assert np.max(np.abs(velocity)) < 1.02
    assert np.max(np.abs(acceleration)) < 3.3


def test_a_trajectory_is_read_back_as_it_was_written(tmp_path: Path) -> None:
    made = sine("a", 1.0, 0.2, 0.5, 4.0)
    path = tmp_path / "swing.parquet"
    pyarrow.parquet.write_table(made.table(), path)
    again = read_trajectory(path)
    assert again.joints == ("a",)
    np.testing.assert_array_equal(again.position, made.position)
    (tmp_path / "bad.csv").write_text("time,position.a\n0,0\n1,0\n1,0\n2,0\n")
    with pytest.raises(LogError, match="whose time increases"):
        read_trajectory(tmp_path / "bad.csv")
    (tmp_path / "none.csv").write_text("time,a\n0,0\n1,0\n")
    with pytest.raises(LogError, match="a trajectory has 'time' and 'position"):
        read_trajectory(tmp_path / "none.csv")


def test_loops_turn_back_once_on_either_way() -> None:
    made = inner_loops("a", 0.1, 50e-6, 10.0, periods=2)
    course = (made.position[:, 0] - 0.1) / 50e-6
    turns = course[1:-1][np.diff(np.sign(np.diff(course))) != 0]
    expected = [-1.0, *([0.6, -0.1, 1.0, -0.6, 0.1, -1.0] * 2)]
    np.testing.assert_allclose(turns, expected[: turns.size], atol=1e-3)
    assert turns.size == len(expected) - 1  # the last is where it ends
    _, velocity, _ = made.at(made.time)
    assert np.max(np.abs(velocity[[0, -1]])) < 1e-9
    assert made.time[-1] == pytest.approx(20.0 + 10.0 / 7.0, abs=0.1)


@pytest.mark.deep
def test_voltages_are_held_out_and_back_and_keep_within_the_stroke() -> None:
    cylinder = read_robot("hydraulic_cylinder")
    of = cylinder.table.joint[0].hydraulics
    assert of is not None
    made = valve_steps("piston", of, 0.2, [3.0, 9.0])
    volts = made.ambient["voltage.piston"]
    assert set(np.unique(volts)) == {-9.0, -3.0, 0.0, 3.0, 9.0}
    out, _ = speed_per_volt(of)
    held = np.count_nonzero(volts == 3.0) / KNOTS
    assert held * out * 3.0 == pytest.approx(0.8 * 0.2, rel=0.01)
    run = run_machine(cylinder, made, 500.0)
    asked = np.interp(run.time, made.time, volts)
    place, speed = run.played.position[:, 0], run.played.velocity[:, 0]
    assert np.max(place) < 0.19
    for voltage in (3.0, 9.0, -9.0):
        steps = np.flatnonzero(np.abs(asked - voltage) < 1e-9)
        late = speed[steps[int(0.7 * steps.size) :]]
        # Held until it is steady: neither still getting under way nor at an end.
        assert np.ptp(late) < 0.02 * np.abs(np.mean(late))


@pytest.mark.parametrize("name", sorted(bundled_robots()))
def test_every_motion_of_the_laboratory_keeps_a_robots_limits(name: str) -> None:
    robot = read_robot(name)
    body = robot.body()
    plans = [plan_sine(robot, robot.joints), plan_sawtooth(robot, robot.joints), plan_loops(robot, robot.joints)]
    plans += [plan_pick_and_place(robot), plan_excitation(robot, 20.0)]
    for plan in plans:
        made = plan.trajectory
        assert np.all(made.position >= np.maximum(body.lower, -np.inf) - 1e-9)
        assert np.all(made.position <= np.minimum(body.upper, np.inf) + 1e-9)
        velocity = np.abs(np.gradient(made.position, made.time, axis=0))
        assert np.all(velocity <= 1.02 * np.minimum(body.top_speed, UNSTATED_SPEED))


def test_a_motor_has_no_valve() -> None:
    robot = read_robot("ur5")
    with pytest.raises(RobotError, match="of elbow_joint of 'ur5' none of them has"):
        plan_voltages(robot, ["elbow_joint"])


def test_amplitudes_past_a_joints_limits_are_refused() -> None:
    robot = read_robot("ur5")
    with pytest.raises(RobotError, match="an amplitude of 50 is past its limits; at most 1.2 is allowed"):
        plan_sawtooth(robot, ["elbow_joint"], 50.0)
    with pytest.raises(RobotError, match="'elbow_joint': an amplitude of 1.2 is past its limits"):
        plan_loops(robot, ["elbow_joint"], 1.2)
