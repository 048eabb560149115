"""The hydraulic cylinder: balance of forces and of oil, ringing, its valve's speeds, cavitation."""

from __future__ import annotations

import numpy as np
import pytest

from mjfriction.errors import SimulationError
from mjfriction.laws.ambient import ambient
from mjfriction.laws.friction import friction
from mjfriction.plant.cylinder import speed_per_volt
from mjfriction.plant.machine import Run, run_machine, simulate
from mjfriction.plant.motions import sine
from mjfriction.plant.trajectory import Trajectory
from mjfriction.robot.files import read_robot
from mjfriction.robot.friction_tables import FrictionTerm, PressureFriction
from mjfriction.robot.robot import Robot
from mjfriction.robot.schema import Hydraulics
from tests.deep import deep
from tests.plant.bare import frictionless


@pytest.fixture(scope="module")
def cylinder() -> Robot:
    return read_robot("hydraulic_cylinder")


def of(robot: Robot) -> Hydraulics:
    hydraulics = robot.table.joint[0].hydraulics
    assert hydraulics is not None
    return hydraulics


def changed(robot: Robot, **changes: float) -> Robot:
    joint = robot.table.joint[0]
    return robot.with_joint(joint.model_copy(update={"hydraulics": of(robot).model_copy(update=changes)}))


def voltages(*steps: tuple[float, float]) -> Trajectory:
    """Constant voltages, (volts, seconds) one after another."""
    course = np.concatenate([np.full(round(1000 * seconds), volts) for volts, seconds in steps])
    return Trajectory((), np.arange(course.size) / 1000.0, np.empty((course.size, 0)), {"voltage.piston": course})


def run(robot: Robot, *steps: tuple[float, float]) -> Run:
    return run_machine(robot, voltages(*steps), 1000.0)


@pytest.mark.parametrize("volts", [deep(0.3), 1.5, 6.0, deep(-0.3), -1.5, -6.0])
def test_at_constant_speed_the_pressures_carry_the_friction(cylinder: Robot, volts: float) -> None:
    done = run(cylinder, (volts, 0.8 if abs(volts) > 1.0 else 4.0))
    oil, played = done.cylinders["piston"], done.played
    hydraulics = of(cylinder)
    force = oil.p1[-1] * hydraulics.head_area - oil.p2[-1] * hydraulics.rod_area
    speed = played.velocity[-1, 0]
    assert np.sign(speed) == np.sign(volts)
    # The law of the robot file, evaluated on its own at that speed and those pressures.
    term = cylinder.table.joint[0].friction[0]  # type: ignore[index]
    law = friction(term.law, term.parameters)
    around = ambient(1, pressure_head=float(oil.p1[-1]), pressure_rod=float(oil.p2[-1]))
    assert force == pytest.approx(float(law.steady(np.array([speed]), around)[0]), rel=1e-4)
    # And what flows in fills the chamber, but for what leaks past the piston.
    past = hydraulics.leakage * (oil.p1[-1] - oil.p2[-1])
    assert oil.q1[-1] == pytest.approx(hydraulics.head_area * speed + past, rel=2e-3)
    assert oil.q2[-1] == pytest.approx(-hydraulics.rod_area * speed - past, rel=2e-3)


def test_retracting_costs_more_than_extending(cylinder: Robot) -> None:
    out, back = (abs(run(cylinder, (volts, 0.8)).played.torque[-1, 0]) for volts in (3.0, -3.0))
    assert back > 1.5 * out


def test_behind_a_closed_valve_the_piston_rings_on_its_oil(cylinder: Robot) -> None:
    tight = changed(frictionless(cylinder), leakage=0.0, valve_bandwidth=400.0)
    done = run(tight, (1.0, 0.05), (0.0, 0.4))
    x, v = done.played.position[700:, 0], done.played.velocity[700:, 0]
    hydraulics, middle = of(tight), float(np.mean(x))
    first = (hydraulics.head_volume + hydraulics.head_area * middle) / hydraulics.bulk_modulus
    second = (hydraulics.rod_volume - hydraulics.rod_area * middle) / hydraulics.bulk_modulus
    compliance = hydraulics.hose_compliance
    stiffness = hydraulics.head_area**2 / (first + compliance) + hydraulics.rod_area**2 / (second + compliance)
    mass = 6.0
    crossings = np.flatnonzero(np.diff(np.sign(v)) != 0)
    step = done.time[1] - done.time[0]
    half_period = step * (crossings[-1] - crossings[0]) / (crossings.size - 1)
    assert crossings.size > 60
    assert half_period == pytest.approx(np.pi * np.sqrt(mass / stiffness), rel=2e-3)
    energy = 0.5 * mass * v**2 + 0.5 * stiffness * (x - middle) ** 2
    quarter = energy.size // 4
    assert np.mean(energy[-quarter:]) == pytest.approx(np.mean(energy[:quarter]), rel=5e-3)


@pytest.mark.parametrize("volts", [2.0, -2.0])
def test_without_friction_the_piston_goes_as_fast_as_its_valve_lets_it(cylinder: Robot, volts: float) -> None:
    tight = changed(frictionless(cylinder), leakage=0.0)
    out, back = speed_per_volt(of(tight))
    # A little friction damps the ringing; its force is nothing to the oil's.
    damped = FrictionTerm(law="coulomb_viscous", parameters={"coulomb": 0.0, "viscous": 200.0})
    tight = tight.with_joint(tight.table.joint[0].model_copy(update={"friction": (damped,)}))
    speed = run(tight, (volts, 0.8)).played.velocity[-1, 0]
    # Near a closed edge the flow is laminar below half a bar: a percent of the drop.
    assert speed == pytest.approx(volts * (out if volts > 0.0 else back), rel=0.01)


def test_seals_that_the_chambers_press_on_follow_the_pressures_live(cylinder: Robot) -> None:
    joint = frictionless(cylinder).table.joint[0]
    seals = PressureFriction(head=1e-4, rod=5e-5, difference=2e-4)
    pressed = cylinder.with_joint(joint.model_copy(update={"pressure_friction": seals}))
    done = run(pressed, (4.0, 0.3), (-4.0, 0.4))
    oil = done.cylinders["piston"]
    for k in (2900, -1):
        way = np.sign(done.played.velocity[k, 0])
        expected = way * (1e-4 * oil.p1[k] + 5e-5 * oil.p2[k] + 2e-4 * abs(oil.p1[k] - oil.p2[k]))
        assert done.played.friction[k, 0] == pytest.approx(expected, rel=1e-6)


def test_a_heavy_load_shut_off_cavitates_and_that_is_said(cylinder: Robot) -> None:
    heavy = changed(cylinder, supply_pressure=2.0e6, valve_bandwidth=400.0)
    heavy = type(heavy)(heavy.table.model_copy(update={"link_scale": {"piston": 60.0}}), heavy.folder)
    course = voltages((9.0, 1.0), (0.0, 0.5))
    done = run_machine(heavy, course, 1000.0)
    oil = done.cylinders["piston"]
    assert np.all(oil.p1 >= 0.0)
    assert np.all(oil.p2 >= 0.0)
    assert any("head chamber cavitated" in note for note in done.notes)
    with pytest.warns(UserWarning, match="cavitated"):
        simulate(heavy, course)


@pytest.mark.deep
def test_pressures_stay_positive_and_nothing_is_said_in_ordinary_work(cylinder: Robot) -> None:
    done = run_machine(cylinder, sine("piston", 0.0, 0.05, 0.5, 3.0), 1000.0)
    oil = done.cylinders["piston"]
    assert min(np.min(oil.p1), np.min(oil.p2)) > 0.0
    assert done.notes == ()


@pytest.mark.deep
def test_the_piston_follows_its_course(cylinder: Robot) -> None:
    course = sine("piston", 0.0, 0.05, 0.2, 3.0)
    done = run_machine(cylinder, course, 1000.0)
    wanted = np.interp(done.time, course.time, course.position[:, 0])
    assert np.max(np.abs(done.played.position[:, 0] - wanted)) < 1e-3


def test_chambers_too_small_for_the_stroke_are_refused(cylinder: Robot) -> None:
    small = changed(cylinder, rod_volume=1e-4)
    with pytest.raises(SimulationError, match="past the end of its chambers"):
        run_machine(small, sine("piston", 0.0, 0.15, 0.2, 1.0), 1000.0)
