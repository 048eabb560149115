"""The machine obeys physics: springs, give, play, events; its sensors say what they are stated to say."""

from __future__ import annotations

import numpy as np
import pyarrow as pa
import pytest
from scipy.optimize import curve_fit

from mjfriction.body.inverse import inverse_dynamics, mass_matrix_at
from mjfriction.control.servo import Control
from mjfriction.errors import RobotError
from mjfriction.plant.machine import run_machine, simulate
from mjfriction.plant.motions import excitation, sine
from mjfriction.plant.sensors import Recorder
from mjfriction.plant.trajectory import Trajectory
from mjfriction.record.readers.table import log_from_table
from mjfriction.robot.files import read_robot
from mjfriction.robot.friction import stated_levels
from mjfriction.robot.friction_tables import Event, WarmUp
from mjfriction.robot.predict import predict_log
from mjfriction.robot.robot import Robot
from mjfriction.robot.schema import Coupling, Spring, Transmission
from mjfriction.sim.transmission import GIVE_DAMPING
from tests.plant.bare import frictionless

HOME = np.array([0.0, -1.2, 1.4, -0.4, 1.2, 0.0])
ELBOW = 2


@pytest.fixture(scope="module")
def ur5() -> Robot:
    return read_robot("ur5")


def with_elbow(robot: Robot, **changes: object) -> Robot:
    return robot.with_joint(robot.table.joint[ELBOW].model_copy(update=changes))


def motion(robot: Robot, seconds: float = 8.0, seed: int = 1) -> Trajectory:
    count = len(robot.joints)
    return excitation(robot.joints, HOME, np.full(count, 0.5), np.full(count, 1.2), seconds, seed=seed)


def hold(robot: Robot, pose: np.ndarray, seconds: float = 3.0) -> Trajectory:
    time = np.linspace(0.0, seconds, 50)
    return Trajectory(robot.joints, time, np.tile(pose, (time.size, 1)))


def run(robot: Robot, trajectory: Trajectory, control: Control | None = None, controller: Robot | None = None):
    return run_machine(robot, trajectory, 1000.0, control or Control(), controller or robot)


def test_the_log_is_what_the_robot_predicts(ur5: Robot) -> None:
    robot = with_elbow(
        ur5, coupling=(Coupling(joint="wrist_1_joint", viscous=3.0, inertia=0.3),), spring=Spring(stiffness=5.0)
    )
    log = log_from_table(pa.table(simulate(robot, motion(robot), recorder=Recorder(500.0))), "log")
    predicted = predict_log(log, robot)
    for joint in robot.joints:
        speed = np.abs(np.gradient(log.columns[f"position.{joint}"], log.time))
        sure = (speed > 0.1) & (log.time > 1.0) & (log.time < 7.0)
        measured = log.columns[f"effort.{joint}"]
        error = np.sqrt(np.mean((measured - predicted[f"effort.{joint}"])[sure] ** 2))
        assert error < 1e-3 * np.sqrt(np.mean(measured[sure] ** 2)), joint


def test_a_joint_that_sticks_shares_the_effort_that_its_drive_gives(ur5: Robot) -> None:
    robot = with_elbow(ur5, coupling=(Coupling(joint="wrist_1_joint", effort=0.5),))
    course = motion(robot)
    wrist = robot.joints.index("wrist_1_joint")
    course.position[:, wrist] = HOME[wrist]  # it rests, and friction holds it with any part of its level
    log = log_from_table(pa.table(simulate(robot, course, recorder=Recorder(500.0))), "log")
    predicted = predict_log(log, robot)
    speed = np.abs(np.gradient(log.columns["position.elbow_joint"], log.time))
    sure = (speed > 0.1) & (log.time > 1.0) & (log.time < 7.0)
    shared = 0.5 * (log.columns["effort.wrist_1_joint"] - predicted["effort.wrist_1_joint"])[sure]
    error = (log.columns["effort.elbow_joint"] - predicted["effort.elbow_joint"])[sure]
    assert np.sqrt(np.mean(error**2)) < 0.05 * np.sqrt(np.mean(shared**2))


def test_a_joint_that_gives_sags_by_compliance_times_load(ur5: Robot) -> None:
    soft = with_elbow(frictionless(ur5), transmission=Transmission(compliance=2e-4))
    done = run(soft, hold(soft, HOME, 6.0)).played
    load = inverse_dynamics(soft.body(), done.link_position[-1:], 0.0 * HOME[None], 0.0 * HOME[None])[0, ELBOW]
    give = done.link_position[-1, ELBOW] - done.position[-1, ELBOW]
    assert give == pytest.approx(-2e-4 * load, rel=1e-3)


def test_two_masses_on_a_spring_ring_at_their_own_frequency(ur5: Robot) -> None:
    compliance, bandwidth, damping = 2e-4, 25.0, 0.3
    soft = with_elbow(frictionless(ur5), transmission=Transmission(compliance=compliance))
    shaken = hold(soft, HOME, 2.0)
    shaken.position[:10, ELBOW] += 0.02  # the course steps from here to its place, and the link swings after it
    done = run(soft, shaken, Control(bandwidth=bandwidth, damping=damping, friction="none")).played
    give = done.link_position[2000:, ELBOW] - done.position[2000:, ELBOW]
    time = np.arange(give.size) * (shaken.time[-1] / (done.position.shape[0] - 1))

    # Six motors, held by the controller, and the elbow's link behind its spring: eigenvalues at small angles.
    body = soft.body()
    mass = mass_matrix_at(body, HOME)
    spread = np.insert(np.eye(6), 6, np.eye(6)[ELBOW], axis=1)
    spread[ELBOW, ELBOW] = 0.0
    masses = spread.T @ (mass - np.diag(body.armature)) @ spread + np.diag(np.append(body.armature, 0.0))
    stiffness = np.diag(np.append(np.diag(mass) * (2.0 * np.pi * bandwidth) ** 2, 0.0))
    stiffness[np.ix_([ELBOW, 6], [ELBOW, 6])] += np.array([[1.0, -1.0], [-1.0, 1.0]]) / compliance
    dampings = np.diag(np.append(np.diag(mass) * 2.0 * damping * 2.0 * np.pi * bandwidth, 0.0))
    loss = 2.0 * GIVE_DAMPING * np.sqrt((mass[ELBOW, ELBOW] - body.armature[ELBOW]) / compliance)
    dampings[np.ix_([ELBOW, 6], [ELBOW, 6])] += np.array([[1.0, -1.0], [-1.0, 1.0]]) * loss
    pull, drag = np.linalg.solve(masses, stiffness), np.linalg.solve(masses, dampings)
    system = np.block([[np.zeros((7, 7)), np.eye(7)], [-pull, -drag]])
    rings = [value for value in np.linalg.eigvals(system) if value.imag > 1.0]
    slowest = max(rings, key=lambda value: value.real)

    def ringing(t: np.ndarray, rate: float, pulsation: float, cosine: float, sine: float, rest: float) -> np.ndarray:
        return np.exp(-rate * t) * (cosine * np.cos(pulsation * t) + sine * np.sin(pulsation * t)) + rest

    begin = (-slowest.real, slowest.imag, np.ptp(give) / 2.0, 0.0, give[-1])
    fitted, _ = curve_fit(ringing, time, give, begin, method="trf", x_scale="jac")
    assert fitted[1] == pytest.approx(slowest.imag, rel=0.005)
    assert fitted[0] == pytest.approx(-slowest.real, rel=0.03)


def test_play_lets_the_link_lag_to_one_stop_or_the_other(ur5: Robot) -> None:
    loose = with_elbow(ur5, transmission=Transmission(backlash=0.02))
    done = run(loose, motion(loose)).played
    give = done.link_position[:, ELBOW] - done.position[:, ELBOW]
    assert np.max(np.abs(give)) < 0.0105
    load = inverse_dynamics(loose.body(), done.position[-1:], 0.0 * HOME[None], 0.0 * HOME[None])[0, ELBOW]
    assert give[-1] == pytest.approx(-0.01 * np.sign(load), abs=2e-4)


def test_an_event_steps_the_friction_at_its_moment(ur5: Robot) -> None:
    eased = with_elbow(ur5, events=(Event(time=4.0, coulomb=6.0),))
    course = sine("elbow_joint", 1.4, 0.4, 0.5, 4.0)
    plain, changed = (run(robot, course, controller=ur5).played.torque[:, ELBOW] for robot in (ur5, eased))
    np.testing.assert_array_equal(plain[:4000], changed[:4000])
    speed = np.gradient(course.at(np.arange(changed.size) * 1e-3)[0][:, 0])
    fast = (np.abs(speed) > 5e-4) & (np.arange(changed.size) > 4500)
    fast = fast[: changed.size]
    assert np.mean((changed - plain)[fast] * np.sign(speed[fast])) == pytest.approx(6.0, rel=0.1)


def test_what_pushes_from_outside_is_held_by_the_drive_and_logged_by_none(ur5: Robot) -> None:
    course = motion(ur5)
    push = 20.0 * np.sin(0.8 * course.time)
    alone, pushed = (
        run(ur5, Trajectory(course.joints, course.time, course.position, ambient))
        for ambient in ({}, {"push.elbow_joint": push})
    )
    added = (pushed.played.torque - alone.played.torque)[:, ELBOW]
    late = (alone.time > 1.0) & (np.abs(alone.played.velocity[:, ELBOW]) > 0.1)
    wanted = -np.interp(alone.time, course.time, push)
    assert np.sqrt(np.mean(np.square(added - wanted)[late])) < 0.05 * 20.0
    log = simulate(ur5, Trajectory(course.joints, course.time, course.position, {"push.elbow_joint": push}))
    assert not any(name.startswith("push") for name in log)
    with pytest.raises(RobotError, match="has no joint 'elbow' to push"):
        simulate(ur5, Trajectory(course.joints, course.time, course.position, {"push.elbow": push}))


@pytest.mark.parametrize(("name", "amplitude"), [("comau_ns12", 0.8), ("machine_table", 0.02)])
def test_levels_vary_whatever_the_laws_of_the_joint(name: str, amplitude: float) -> None:
    robot = read_robot(name)
    joint = robot.joints[0]
    level = stated_levels(robot.joint(joint))[0]
    falls = WarmUp(coulomb=-0.2 * level, viscous=0.0, time_constant=2.0)
    steps = Event(time=2.0, coulomb=0.5 * level, viscous=0.0)
    table = robot.joint(joint).model_copy(update={"warm_up": falls, "events": (steps,)})
    course = sine(joint, 0.0, amplitude, 0.5, 3.0)
    whole = np.zeros((course.time.size, len(robot.joints)))
    whole[:, 0] = course.position[:, 0]
    trajectory = Trajectory(robot.joints, course.time, whole)
    plain, varied = (run(own, trajectory) for own in (robot, robot.with_joint(table)))
    speed = np.abs(plain.played.velocity[:, 0])
    sliding = speed > 0.8 * np.max(speed)
    changed = (np.abs(varied.played.friction) - np.abs(plain.played.friction))[:, 0]
    wanted = level * (-0.2 * -np.expm1(-plain.time / 2.0) + 0.5 * (plain.time >= 2.0))
    before, after = (sliding & (plain.time > start) & (plain.time < start + 1.0) for start in (1.0, 4.0))
    for part in (before, after):  # half a stroke after each change, where the bristles have met it
        assert np.any(part)
        assert changed[part] == pytest.approx(wanted[part], abs=0.03 * level)


def test_the_same_seed_says_the_same_and_another_does_not(ur5: Robot) -> None:
    noisy = with_elbow(ur5, effort_sensor=ur5.table.joint[ELBOW].effort_sensor.model_copy(update={"noise": 0.5}))
    course = motion(noisy, 4.0)
    first, again, other = (simulate(noisy, course, seed=seed)["effort.elbow_joint"] for seed in (1, 1, 2))
    assert first.tobytes() == again.tobytes()
    assert first.tobytes() != other.tobytes()


def test_sensors_quantize_offset_scale_and_delay(ur5: Robot) -> None:
    joint = ur5.table.joint[ELBOW]
    sensors = with_elbow(
        ur5,
        position_sensor=joint.position_sensor.model_copy(update={"resolution": 1e-3, "offset": 0.25}),
        effort_sensor=joint.effort_sensor.model_copy(update={"scale": 1.5, "offset": 2.0, "delay": 0.05}),
    )
    course = motion(ur5, 4.0)
    true, read = (simulate(robot, course, controller_robot=ur5) for robot in (ur5, sensors))
    position = read["position.elbow_joint"]
    np.testing.assert_allclose(np.round(position / 1e-3) * 1e-3, position, atol=1e-12)
    np.testing.assert_allclose(position - 0.25, true["position.elbow_joint"], atol=0.51e-3)
    np.testing.assert_allclose(read["effort.elbow_joint"][50:], 1.5 * true["effort.elbow_joint"][:-50] + 2.0, rtol=1e-9)


def test_currents_are_efforts_through_the_drive(ur5: Robot) -> None:
    course = motion(ur5, 4.0)
    drive = ur5.table.joint[ELBOW].actuator
    assert drive.torque_constant is not None
    effort = simulate(ur5, course)["effort.elbow_joint"]
    current = simulate(ur5, course, recorder=Recorder(quantity="current"))["current.elbow_joint"]
    np.testing.assert_allclose(current * drive.gear_ratio * drive.torque_constant, effort, rtol=1e-12)


def test_a_drive_gives_no_more_than_its_limit(ur5: Robot) -> None:
    drive = ur5.table.joint[ELBOW].actuator
    weak = with_elbow(ur5, actuator=drive.model_copy(update={"current_limit": 1.0}))
    torque = run(weak, motion(weak, 4.0), controller=ur5).played.torque[:, ELBOW]
    assert drive.torque_constant is not None
    assert np.max(np.abs(torque)) <= 1.0 * drive.torque_constant * drive.gear_ratio + 1e-12


def test_a_trajectory_of_another_robot_is_refused(ur5: Robot) -> None:
    with pytest.raises(RobotError, match="no joint 'elbow_jiont'; did you mean 'elbow_joint'"):
        simulate(ur5, sine("elbow_jiont", 0.0, 0.1, 0.5, 2.0))


def test_a_controller_speaks_of_the_same_joints_in_any_order(ur5: Robot) -> None:
    course = motion(ur5, 2.5)
    turned = Robot(ur5.table.model_copy(update={"joint": ur5.table.joint[::-1]}), ur5.folder)
    straight, reversed_ = (run(ur5, course, controller=model).played.position for model in (ur5, turned))
    np.testing.assert_array_equal(straight, reversed_)
    with pytest.raises(RobotError, match="the controller's robot 'comau_ns12' has joints joint_1, "):
        run(ur5, course, controller=read_robot("comau_ns12"))


def test_a_voltage_for_a_motor_is_refused(ur5: Robot) -> None:
    course = motion(ur5, 2.5)
    stray = Trajectory(course.joints, course.time, course.position, {"voltage.elbow_joint": course.time})
    with pytest.raises(RobotError, match="'voltage.elbow_joint', but no cylinder moves such a joint"):
        run(ur5, stray)
