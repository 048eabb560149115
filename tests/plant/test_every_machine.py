"""Every bundled machine obeys physics, whatever its drive: gravity, energy, and its own log."""

from __future__ import annotations

import numpy as np
import pyarrow as pa
import pytest

from mjfriction.body.inverse import inverse_dynamics
from mjfriction.control.servo import Control
from mjfriction.identify.protocol import room
from mjfriction.plant.machine import run_machine, simulate
from mjfriction.plant.motions import excitation
from mjfriction.plant.sensors import Recorder
from mjfriction.plant.trajectory import Trajectory
from mjfriction.record.readers.table import log_from_table
from mjfriction.robot.files import read_robot
from mjfriction.robot.predict import predict_log
from mjfriction.robot.robot import Robot, bundled_robots
from tests.deep import deep
from tests.plant.bare import frictionless

NAMES = sorted(bundled_robots())
ELECTRIC = [name for name in NAMES if name != "hydraulic_cylinder"]


def motion(robot: Robot, seconds: float = 8.0, seed: int = 1) -> Trajectory:
    body = robot.body()
    middle, reach = room(body)
    top = np.minimum(body.top_speed, 1.2)
    return excitation(robot.joints, middle, 0.6 * reach, 0.7 * top, seconds, seed=seed)


@pytest.mark.parametrize("name", ELECTRIC)
def test_at_rest_without_friction_the_drives_carry_gravity(name: str) -> None:
    robot = frictionless(read_robot(name))
    middle, _ = room(robot.body())
    pose = middle + 0.2
    time = np.linspace(0.0, 2.0, 50)
    held = Trajectory(robot.joints, time, np.tile(pose, (time.size, 1)))
    # A controller that feeds nothing forward has to find the torque itself.
    done = run_machine(robot, held, 1000.0, Control(bandwidth=4.0, damping=1.0, feedforward="gravity")).played
    place = done.position[-1:]
    expected = inverse_dynamics(robot.body(), place, 0.0 * place, 0.0 * place)[0]
    for i, joint in enumerate(robot.table.joint):
        for wave in joint.cogging:
            phase = wave.wavenumber * place[0, i]
            expected[i] += wave.cosine * np.cos(phase) + wave.sine * np.sin(phase)
    np.testing.assert_allclose(done.torque[-1], expected, atol=1e-6 * max(np.abs(expected).max(), 1.0))


@pytest.mark.parametrize("name", ELECTRIC)
def test_without_friction_what_the_drives_put_in_is_taken_out_again(name: str) -> None:
    robot = frictionless(read_robot(name))
    done = run_machine(robot, motion(robot), 1000.0).played
    power = done.torque[:-1] * 0.5 * (done.velocity[1:] + done.velocity[:-1])
    moved = float(np.sum(np.abs(power)))
    # It ends at rest where it began, so that no energy may be left in it.
    np.testing.assert_allclose(done.velocity[-1], 0.0, atol=1e-3)
    assert abs(float(np.sum(power))) < 3e-3 * moved


@pytest.mark.parametrize("name", ELECTRIC)
def test_friction_keeps_what_it_takes(name: str) -> None:
    robot = read_robot(name)
    done = run_machine(robot, motion(robot), 1000.0).played
    middle = 0.5 * (done.velocity[1:] + done.velocity[:-1])
    put_in = float(np.sum(done.torque[:-1] * middle))
    rubbed = float(np.sum(done.friction[:-1] * middle))
    assert rubbed > 0.0
    assert put_in == pytest.approx(rubbed, rel=2e-3)


@pytest.mark.parametrize("name", NAMES)
def test_its_log_is_what_its_robot_file_predicts(name: str) -> None:
    robot = read_robot(name)
    log = log_from_table(pa.table(simulate(robot, motion(robot), recorder=Recorder(500.0))), name)
    predicted = predict_log(log, robot)
    for joint in robot.joints:
        speed = np.abs(np.gradient(log.columns[f"position.{joint}"], log.time))
        sure = (speed > 0.2 * np.max(speed)) & (log.time > 1.0) & (log.time < 7.0)
        measured = log.columns[f"effort.{joint}"]
        error = np.sqrt(np.mean((measured - predicted[f"effort.{joint}"])[sure] ** 2))
        assert error < 0.02 * np.sqrt(np.mean(measured[sure] ** 2)), joint


@pytest.mark.parametrize("name", [deep(name) if name == "hydraulic_cylinder" else name for name in NAMES])
def test_the_same_seed_says_the_same(name: str) -> None:
    robot = read_robot(name)
    first, again = (simulate(robot, motion(robot, 2.5), recorder=Recorder(250.0), seed=3) for _ in range(2))
    assert list(first) == list(again)
    assert all(first[key].tobytes() == again[key].tobytes() for key in first)
