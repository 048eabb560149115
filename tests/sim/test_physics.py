"""Friction in MuJoCo against physics: small steps, the native element, constraints, loads, the measured goals."""

from __future__ import annotations

import mujoco
import numpy as np
import pytest

from mjfriction.laws.friction import friction
from mjfriction.sim.attach import attach
from mjfriction.sim.callback import friction_active
from mjfriction.sim.reading import read_friction, torques
from scripts.sim_accuracy import error, native_lugre, ours, reference, rotor_case, run, six_axis_case
from tests.sim.models import LUGRE, PENDULUM, ROTOR, lugre, spec


@pytest.fixture(autouse=True)
def active():
    with friction_active():
        yield


def swung(h: float, seconds: float = 0.6) -> float:
    model = attach(spec(PENDULUM), {"swing": lugre(coulomb=0.2, static=0.25, viscous=0.02, bristle_stiffness=500.0)})
    model.opt.timestep = h
    data = mujoco.MjData(model)
    data.qpos[0] = 2.0
    mujoco.mj_step(model, data, nstep=round(seconds / h))
    return float(data.qpos[0])


def test_convergence_to_the_fine_solution_is_of_first_order() -> None:
    fine = swung(1e-6)
    steps = [2e-3, 1e-3, 5e-4, 2.5e-4]
    errors = [abs(swung(h) - fine) for h in steps]
    order = float(np.polyfit(np.log(steps), np.log(errors), 1)[0])
    assert order == pytest.approx(1.0, abs=0.2)


def test_small_steps_meet_the_native_lugre_element() -> None:
    """MuJoCo's own bristles and ours are the same equations: at ever smaller steps they meet."""
    soft = {**LUGRE, "bristle_stiffness": 400.0, "bristle_damping": 2.0, "viscous": 0.05}

    def both(h: float) -> float:
        model = attach(spec(ROTOR), {"rotor": friction("lugre", soft)})
        native = spec(ROTOR)
        native.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
        element = native.add_actuator(name="rub", trntype=mujoco.mjtTrn.mjTRN_JOINT, target="rotor")
        names = ("bristle_stiffness", "bristle_damping", "coulomb", "static", "stribeck_velocity")
        element.set_to_dcmotor(motorconst=[0.0, 0.0], resistance=1.0, lugre=[soft[n] for n in names], ctrlspec=16)
        native.joint("rotor").damping[0] = soft["viscous"]
        ends = []
        for one in (model, native.compile()):
            one.opt.timestep = h
            data = mujoco.MjData(one)
            for k in range(round(0.5 / h)):
                data.ctrl[0] = 12.0 * np.sin(20.0 * k * h)
                mujoco.mj_step(one, data)
            ends.append(float(data.qpos[0]))
        return ends[1] - ends[0]

    apart = [both(h) for h in (2e-4, 1e-4, 5e-5)]
    assert abs(apart[0]) > 1.6 * abs(apart[1]) > 2.5 * abs(apart[2])
    # What is left is of first order in the step: extrapolated to none, they agree.
    assert abs(2.0 * apart[2] - apart[1]) < 0.05 * abs(apart[2])


@pytest.mark.deep
def test_the_goal_on_the_ns12_rotor_at_one_millisecond() -> None:
    case = rotor_case()
    truth = reference(case)
    own = float(error(run(case, ours(case), 1e-3), truth)[0])
    native = float(error(run(case, native_lugre(case), 1e-3), truth)[0])
    assert own <= native / 50.0


@pytest.mark.parametrize(("h", "most"), [(1e-3, 6e-4), (2e-3, 1e-3)])
def test_the_goal_on_six_axes(h: float, most: float) -> None:
    case = six_axis_case()
    assert np.max(error(run(case, ours(case), h), reference(case))) <= most


def test_a_joint_pressed_against_its_limit_stays_and_comes_away_again() -> None:
    made = spec(ROTOR)
    made.compiler.degree = False
    joint = made.joint("rotor")
    joint.limited, joint.range = mujoco.mjtLimited.mjLIMITED_TRUE, [-0.1, 0.1]
    joint.solref_limit = [0.004, 1.0]
    model = attach(made, {"rotor": lugre()})
    data = mujoco.MjData(model)
    data.ctrl[0] = 20.0
    mujoco.mj_step(model, data, nstep=1500)
    assert data.qpos[0] == pytest.approx(0.1, abs=5e-3)
    assert abs(data.qvel[0]) < 1e-6
    # Nothing slides, so no more than the bristles' own deflection holds: the limit carries the rest.
    assert abs(torques(model, data)["rotor"]) <= 8.0 + 1e-6
    data.ctrl[0] = -20.0
    mujoco.mj_step(model, data, nstep=500)
    assert data.qpos[0] == pytest.approx(-0.1, abs=5e-3)


CARRIAGE = """
<mujoco>
  <option timestep="0.001"/>
  <worldbody>
    <geom type="plane" size="2 2 .1"/>
    <body pos="0 0 .3"><joint name="lift" type="slide" axis="0 0 1"/><geom type="sphere" size=".1" mass="2"/></body>
  </worldbody>
</mujoco>
"""


def test_a_falling_carriage_slows_by_its_friction_and_lands() -> None:
    model = attach(spec(CARRIAGE), {"lift": friction("coulomb", {"coulomb": 5.0})})
    data = mujoco.MjData(model)
    mujoco.mj_step(model, data, nstep=100)
    assert data.qvel[0] == pytest.approx(-(9.81 - 2.5) * 0.1, rel=1e-3)
    mujoco.mj_step(model, data, nstep=1900)
    assert data.qpos[0] == pytest.approx(-0.2, abs=5e-3)
    assert abs(data.qvel[0]) < 1e-5


COUPLED = """
<mujoco>
  <option timestep="0.001" gravity="0 0 0"/>
  <worldbody>
    <body><joint name="one" axis="0 0 1" armature="0.02"/><geom size=".01" mass="1e-6"/></body>
    <body><joint name="two" axis="0 0 1" armature="0.02"/><geom size=".01" mass="1e-6"/></body>
  </worldbody>
  <equality><joint joint1="one" joint2="two" polycoef="0 1 0 0 0" solref="0.004 1"/></equality>
  <actuator><motor joint="one"/></actuator>
</mujoco>
"""


def test_two_joints_coupled_by_an_equality_share_their_friction() -> None:
    model = attach(spec(COUPLED), {"one": lugre(viscous=0.0), "two": lugre(viscous=0.0)})
    data = mujoco.MjData(model)
    data.ctrl[0] = 10.0  # more than one joint's 8 at breakaway, less than both
    mujoco.mj_step(model, data, nstep=1000)
    assert abs(data.qvel[0]) < 1e-4
    data.ctrl[0] = 20.0  # 8 more than the 12 that both keep at speed
    mujoco.mj_step(model, data, nstep=300)
    before = data.qvel[0]
    mujoco.mj_step(model, data, nstep=100)
    assert (data.qvel[0] - before) / 0.1 == pytest.approx(8.0 / 0.04, rel=0.02)


def test_load_dependent_friction_reads_what_the_transmission_carries() -> None:
    """A horizontal pendulum held still: the load is its weight's torque."""
    law = friction("load_dependent", {"coulomb": 0.1, "load": 0.2, "viscous": 0.0})
    model = attach(spec(PENDULUM), {"swing": law})
    data = mujoco.MjData(model)
    data.qpos[0] = np.pi / 2.0
    mujoco.mj_forward(model, data)
    weight = float(data.qfrc_bias[0])
    reader = read_friction(model)
    assert data.userdata[reader.load][0] == pytest.approx(weight, rel=1e-9)
    mujoco.mj_step(model, data, nstep=40)
    expected = np.sign(data.qvel[0]) * (0.1 + 0.2 * abs(data.userdata[reader.load][0]))
    assert torques(model, data)["swing"] == pytest.approx(expected, rel=1e-9)


@pytest.mark.parametrize("includes_rotor", [False, True])
def test_a_rotor_is_no_load_of_its_own_transmission_unless_it_is_said_to_be(*, includes_rotor: bool) -> None:
    """A bare rotor J under a torque u: J·q̈ = u − F_c, or with its own torque as a load (1 + μ)·J·q̈ = u − F_c."""
    values = {"coulomb": 1.0, "load": 0.25, "viscous": 0.0}
    law = friction("load_dependent", values, load_includes_rotor=includes_rotor)
    model = attach(spec(ROTOR), {"rotor": law})
    data = mujoco.MjData(model)
    data.ctrl[0] = 3.0
    mujoco.mj_step(model, data, nstep=100)
    before = data.qvel[0]
    mujoco.mj_step(model, data, nstep=100)
    share = 1.25 if includes_rotor else 1.0
    assert (data.qvel[0] - before) / 0.1 == pytest.approx((3.0 - 1.0) / (0.01 * share), rel=1e-6)


def test_temperature_is_an_input_of_the_simulation() -> None:
    values = {"coulomb": 1.0, "viscous": 2.0, "coulomb_per_kelvin": 0.0, "viscous_decay": 0.02}
    model = attach(spec(ROTOR), {"rotor": friction("temperature_dependent", values)})
    data = mujoco.MjData(model)
    data.ctrl[0] = 5.0
    mujoco.mj_step(model, data, nstep=500)
    assert data.qvel[0] == pytest.approx(4.0 / 2.0, rel=1e-3)
    data.userdata[read_friction(model).warmth] = 20.0
    mujoco.mj_step(model, data, nstep=500)
    assert data.qvel[0] == pytest.approx(4.0 / (2.0 * np.exp(-0.4)), rel=1e-3)


def test_forces_from_outside_reach_the_balance() -> None:
    model = attach(spec(PENDULUM), {"swing": lugre(coulomb=20.0, static=20.0)})
    data = mujoco.MjData(model)
    data.xfrc_applied[1, 0] = 10.0  # at the centre, 0.25 m below the hinge
    mujoco.mj_step(model, data, nstep=2000)
    assert torques(model, data)["swing"] == pytest.approx(-10.0 * 0.25, rel=1e-2)
    assert abs(data.qvel[0]) < 1e-9
