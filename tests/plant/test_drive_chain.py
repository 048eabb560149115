"""Drives and transmissions against closed-form answers: two masses, play, current loop, ripple, coupled wrists."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pyarrow as pa
import pytest
from scipy.linalg import expm
from scipy.signal import butter, sosfiltfilt

from mjfriction.body.inverse import inverse_dynamics, mass_matrix_at
from mjfriction.control.course import Course
from mjfriction.control.servo import Control, ServoDrives
from mjfriction.plant.machine import run_machine, simulate
from mjfriction.plant.motions import excitation, sine
from mjfriction.plant.sensors import Recorder
from mjfriction.plant.trajectory import Trajectory
from mjfriction.record.readers.table import log_from_table
from mjfriction.robot.files import read_robot
from mjfriction.robot.friction_tables import FrictionTerm
from mjfriction.robot.predict import predict_log
from mjfriction.robot.robot import Robot
from mjfriction.robot.schema import Actuator, CommonDrive, PositionSensor, Transmission
from mjfriction.robot.table import Wave
from mjfriction.sim.transmission import DeadZone

LINK, ROTOR = 60.0, 6.0e-5 * 628.3185307**2  # kg of the linear axis
NONE = FrictionTerm(law="coulomb_viscous", parameters={"coulomb": 0.0, "viscous": 0.0})


def axis(**changes: object) -> Robot:
    robot = read_robot("linear_axis")
    return robot.with_joint(robot.table.joint[0].model_copy(update={"friction": (NONE,), **changes}))


def gains(robot: Robot, control: Control, step: float) -> tuple[float, float]:
    still = np.zeros((1, 1))
    servo = ServoDrives(robot, robot, control, Course(still, still, still), step)
    return float(servo.stiffness[0]), float(servo.damping[0])


def test_two_masses_on_a_spring_move_as_the_matrix_exponential_says() -> None:
    compliance = 2e-6
    soft = axis(transmission=Transmission(compliance=compliance))
    control = Control(bandwidth=6.0, damping=0.5, feedforward="none", friction="none")
    time = np.arange(0.0, 1.0, 0.004)
    # The course jumps aside within a step at 0.1 s; the controller then pulls both masses after it.
    place = np.where(time > 0.1, 0.01, 0.0)[:, None]
    done = run_machine(soft, Trajectory(("axis",), time, place), 4000.0, control)
    step = done.time[1] - done.time[0]
    p, d = gains(soft, control, step)
    k, own = 1.0 / compliance, 2.0 * 0.1 * np.sqrt(LINK / compliance)
    motion = np.array(
        [
            [0.0, 1.0, 0.0, 0.0],
            [-(p + k) / ROTOR, -(d + own) / ROTOR, k / ROTOR, own / ROTOR],
            [0.0, 0.0, 0.0, 1.0],
            [k / LINK, own / LINK, -k / LINK, -own / LINK],
        ]
    )
    once = expm(motion * step)
    begin = int(np.searchsorted(done.time, 0.12))
    played = done.played
    state = np.array(
        [
            played.position[begin, 0],
            played.velocity[begin, 0],
            played.link_position[begin, 0],
            np.gradient(played.link_position[:, 0], step)[begin],
        ]
    )
    state -= [0.01, 0.0, 0.01, 0.0]
    expected = []
    for _ in range(begin, done.time.size):
        expected.append(0.01 + state[[0, 2]])
        state = once @ state
    mine = np.column_stack([played.position[begin:, 0], played.link_position[begin:, 0]])
    swing = np.ptp(mine, axis=0)
    assert np.all(swing > 1e-3)
    error = np.sqrt(np.mean((mine - np.array(expected)) ** 2, axis=0))
    assert np.all(error < 0.01 * swing)


def test_in_its_play_the_link_coasts_and_only_the_stops_move_it() -> None:
    loose = axis(transmission=Transmission(backlash=0.002))
    time = np.linspace(0.0, 1.0, 251)
    ramp = np.where(time > 0.2, 0.05 * (time - 0.2), 0.0)[:, None]
    done = run_machine(loose, Trajectory(("axis",), time, ramp), 4000.0, Control(bandwidth=15.0)).played
    motor, link = done.position[:, 0], done.link_position[:, 0]
    give = motor - link
    assert np.max(motor) > 0.03
    assert np.max(np.abs(give)) < 0.00105
    # The link begins in the middle of its play, and rests until the motor has come half of it.
    begin = int(np.argmax(np.abs(give) > 0.00095))
    assert np.max(np.abs(link[:begin])) < 1e-9
    # From then on it flies from stop to stop as a mass does that nothing holds.
    free = np.abs(give) < 0.00095
    edges = np.flatnonzero(np.diff(free.astype(int)))
    flights = [link[a + 1 : b] for a, b in itertools.pairwise(edges) if free[a + 1] and b - a > 40]
    assert flights
    for flight in flights:
        line = np.polyval(np.polyfit(np.arange(flight.size), flight, 1), np.arange(flight.size))
        np.testing.assert_allclose(flight, line, atol=1e-8)


def test_the_current_loop_lags_by_its_bandwidth() -> None:
    robot = axis(actuator=Actuator(gear_ratio=628.3185307, rotor_inertia=6.0e-5, current_bandwidth=50.0))
    course = Course(*(np.zeros((2, 1)) for _ in range(3)))
    servo = ServoDrives(robot, robot, Control(feedforward="none", friction="none"), course, 1e-3)
    away = np.array([-0.001])  # a constant error asks for a constant force
    force = np.array([servo(0, away, np.zeros(1))[0] for _ in range(40)])
    asked = 0.001 * servo.stiffness[0]
    np.testing.assert_allclose(force, asked * -np.expm1(-2.0 * np.pi * 50.0 * 1e-3 * np.arange(1, 41)), rtol=1e-9)


def test_ripple_makes_a_current_worth_more_here_and_less_there() -> None:
    smooth = read_robot("linear_axis")
    wave = Wave(wavenumber=80.0, cosine=0.1)
    drive = smooth.table.joint[0].actuator.model_copy(update={"ripple": (wave,)})
    rippled = smooth.with_joint(smooth.table.joint[0].model_copy(update={"actuator": drive}))
    course = sine("axis", 0.0, 0.2, 0.2, 3.0)
    log = log_from_table(pa.table(simulate(rippled, course, recorder=Recorder(500.0), controller_robot=smooth)), "log")
    speed = np.abs(np.gradient(log.columns["position.axis"], log.time))
    sure = (speed > 0.05) & (log.time > 1.0) & (log.time < log.time[-1] - 1.0)
    measured = log.columns["effort.axis"]

    def error(robot: Robot) -> float:
        return float(np.sqrt(np.mean((measured - predict_log(log, robot)["effort.axis"])[sure] ** 2)))

    assert error(rippled) < 0.1 * error(smooth)


def test_a_coupled_wrist_works_through_the_published_matrix() -> None:
    # Staubli TX40: motors turn by θ = R·q with R = [[45, 0], [32, 32]] for joints 5 and 6, so that joints feel Rᵀ·τ.
    ratio, coulomb, viscous, inertia = 32.0, 1.95, 0.616, 0.00964
    matrix = np.array([[45.0, 0.0], [ratio, ratio]])
    plain = read_robot("ur5")
    shared = CommonDrive(joint="wrist_2_joint", ratio=1.0, coulomb=coulomb, viscous=viscous, inertia=inertia)
    coupled = plain.with_joint(plain.joint("wrist_3_joint").model_copy(update={"common_drive": (shared,)}))
    home = np.array([0.0, -1.2, 1.4, -0.4, 1.2, 0.0])
    course = excitation(plain.joints, home, np.full(6, 0.5), np.full(6, 1.2), 8.0, seed=1)
    runs = [run_machine(robot, course, 1000.0, controller_robot=plain) for robot in (plain, coupled)]
    beyond = []
    for done in runs:
        played = done.played
        acceleration = np.gradient(played.velocity, 1e-3, axis=0)
        rigid = inverse_dynamics(plain.body(), played.position, played.velocity, acceleration)
        beyond.append((played.torque - rigid - played.friction)[:, 4:])
    turn = runs[1].played.velocity[:, 4:] @ matrix.T
    motor = np.zeros_like(turn)
    acceleration = np.gradient(turn[:, 1], 1e-3)
    motor[:, 1] = coulomb / ratio * np.sign(turn[:, 1]) + (viscous * turn[:, 1] + inertia * acceleration) / ratio**2
    expected = motor @ matrix
    sure = np.abs(turn[:, 1]) > 0.1 * ratio
    sure[:200] = sure[-200:] = False
    size = np.sqrt(np.mean(expected[sure] ** 2))
    assert np.sqrt(np.mean((beyond[1] - expected)[sure] ** 2)) < 0.02 * size
    assert np.sqrt(np.mean(beyond[0][sure] ** 2)) < 0.02 * size  # without the coupling there is nothing of it


def test_a_shared_rotor_weighs_on_both_its_joints() -> None:
    # The same excitation with a rotor heavy enough to count beside the links.
    plain = read_robot("ur5")
    shared = CommonDrive(joint="wrist_2_joint", ratio=1.0, inertia=0.3)
    coupled = plain.with_joint(plain.joint("wrist_3_joint").model_copy(update={"common_drive": (shared,)}))
    home = np.array([0.0, -1.2, 1.4, -0.4, 1.2, 0.0])
    course = excitation(plain.joints, home, np.full(6, 0.5), np.full(6, 1.2), 8.0, seed=1)
    log = log_from_table(pa.table(simulate(coupled, course, recorder=Recorder(500.0), controller_robot=plain)), "log")
    for joint in ("wrist_2_joint", "wrist_3_joint"):
        speed = np.abs(np.gradient(log.columns[f"position.{joint}"], log.time))
        sure = (speed > 0.1) & (log.time > 1.0) & (log.time < 7.0)
        measured = log.columns[f"effort.{joint}"]
        with_it, without = (
            np.sqrt(np.mean((measured - predict_log(log, robot)[f"effort.{joint}"])[sure] ** 2))
            for robot in (coupled, plain)
        )
        assert with_it < 0.15 * without


def test_a_drive_that_differentiates_its_encoder_reports_velocity_late() -> None:
    robot = axis(position_sensor=PositionSensor(resolution=1e-6, velocity_bandwidth=20.0))
    frequency = 0.5
    course = sine("axis", 0.0, 0.1, frequency, 6.0)
    log = simulate(robot, course, recorder=Recorder(1000.0, velocity=True))
    true = simulate(axis(), course, recorder=Recorder(1000.0, velocity=True))
    steady = slice(4000, 8000)  # two whole periods
    turn = np.exp(-2j * np.pi * frequency * log["time"][steady])
    seen, real = (np.sum(columns["velocity.axis"][steady] * turn) for columns in (log, true))
    # A first-order low-pass, run sample by sample, and half a sample for the difference.
    lag = np.arctan(frequency / 20.0) / (2.0 * np.pi * frequency)
    assert -np.angle(seen / real) / (2.0 * np.pi * frequency) == pytest.approx(lag, abs=6e-4)
    assert abs(seen / real) == pytest.approx(1.0, abs=2e-3)
    rough = log["velocity.axis"][steady] - true["velocity.axis"][steady]
    assert np.std(np.diff(rough)) > 0.0


def test_a_gear_of_stated_efficiency_loses_that_share_lifting_and_lowering() -> None:
    efficiency = 0.8
    losses = {"load_driving": 1.0 / efficiency - 1.0, "load_braking": 1.0 - efficiency, "coulomb": 0.0, "viscous": 0.0}
    robot = read_robot("ur5")
    for joint in robot.table.joint:
        law = FrictionTerm(law="geared_load", parameters=losses) if joint.name == "shoulder_lift_joint" else NONE
        robot = robot.with_joint(joint.model_copy(update={"friction": (law,)}))
    # Slowly up and down with the arm stretched out: inertia is next to nothing, the load is gravity's.
    time = np.linspace(0.0, 16.0, 801)
    place = np.zeros((time.size, 6))
    place[:, 1] = -0.4 + 0.3 * np.sin(2.0 * np.pi * time / 8.0)
    done = run_machine(robot, Trajectory(robot.joints, time, place), 500.0, Control(bandwidth=8.0)).played
    sure = np.abs(done.velocity[:, 1]) > 0.1
    load = inverse_dynamics(robot.body(), done.position, 0.0 * done.velocity, 0.0 * done.velocity)[:, 1]
    share = done.torque[:, 1] / load
    lifting = load * done.velocity[:, 1] > 0.0
    assert np.median(share[sure & lifting]) == pytest.approx(1.0 / efficiency, rel=0.01)
    assert np.median(share[sure & ~lifting]) == pytest.approx(efficiency, rel=0.01)


def test_behind_its_play_a_transmission_gives_with_the_load() -> None:
    # The link weighs on a vertical axis: it rests on one stop, and on the spring behind it.
    both = axis(transmission=Transmission(compliance=2.0e-6, backlash=0.002))
    hanging = Robot(both.table.model_copy(update={"gravity": (-9.81, 0.0, 0.0)}), both.folder)
    body = hanging.body()
    load = float(inverse_dynamics(body, np.zeros((1, 1)), np.zeros((1, 1)), np.zeros((1, 1)))[0, 0])
    done = run_machine(hanging, Trajectory(("axis",), np.linspace(0.0, 3.0, 50), np.zeros((50, 1))), 4000.0).played
    behind = done.position[-1, 0] - done.link_position[-1, 0]
    assert load > 100.0
    assert behind == pytest.approx(2.0e-6 * load + 0.001, rel=1e-3)


@pytest.mark.parametrize("machine", ["linear_axis", "machine_table"])
def test_what_slides_lags_its_motor_by_what_it_needs(machine: str) -> None:
    robot = read_robot(machine)
    (joint,) = robot.table.joint
    soft = robot.with_joint(joint.model_copy(update={"transmission": Transmission(compliance=1.0e-6)}))
    course = excitation(robot.joints, np.zeros(1), np.array([0.05]), np.array([0.3]), 4.0, seed=1)
    run = run_machine(soft, course, 4000.0)
    behind = run.played.position[:, 0] - run.played.link_position[:, 0]
    step, body = float(run.time[1]), soft.body()
    link = float(mass_matrix_at(body, np.zeros(1))[0, 0] - body.armature[0])
    needed = 1.0e-6 * link * np.gradient(np.gradient(run.played.link_position[:, 0], step), step)
    inner = slice(2000, -2000)  # once the start has rung out
    slow = butter(4, 20.0, fs=1.0 / step, output="sos")
    behind, needed = (sosfiltfilt(slow, course)[inner] for course in (behind, needed))
    assert np.std(needed) > 1e-6
    assert np.sqrt(np.mean(np.square(behind - needed))) < 0.05 * np.std(needed)


def test_the_spring_behind_a_play_only_pushes() -> None:
    zone = DeadZone(half=0.01, stiffness=100.0, damping=5.0)
    assert zone.force(0.009, 3.0) == 0.0
    assert zone.force(0.03, 0.1) == pytest.approx(-100.0 * 0.02 - 5.0 * 0.1)
    assert zone.force(-0.03, -0.1) == pytest.approx(100.0 * 0.02 + 5.0 * 0.1)
    assert zone.force(0.03, -1.0) == 0.0  # it leaves faster than the spring follows


@pytest.mark.parametrize(("give", "speed"), [(0.03, 0.0), (-0.03, 0.0), (0.03, -0.1)])
def test_beyond_its_play_a_spring_that_hardens_pushes_back_by_its_cubic(give: float, speed: float) -> None:
    zone, beyond = DeadZone(0.01, 200.0, 5.0, hardening=4e5), math.copysign(abs(give) - 0.01, give)
    assert zone.force(give, speed) == pytest.approx(-200.0 * beyond - 4e5 * beyond**3 - 5.0 * speed)
    assert zone.force(0.5 * zone.half, speed) == 0.0
