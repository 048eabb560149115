"""Error of friction in MuJoCo against the same law at very small steps: ours, explicit injection, native elements.

Two cases: one rotor with the NS12's joint-1 bristles under PD control, and a six-axis arm (UR5) with laws of that
stiffness under computed torque and PD.  Controllers run at 1 kHz whatever the step.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import mujoco
import numpy as np

from mjfriction.laws.ambient import ambient
from mjfriction.laws.catalog import LAWS
from mjfriction.laws.friction import friction
from mjfriction.robot.robot import resolve_model
from mjfriction.sim.attach import attach
from mjfriction.sim.callback import friction_active
from mjfriction.sim.export import Native, exact_native, put_on

CONTROL_PERIOD = 1e-3
STEPS = (1e-4, 5e-4, 1e-3, 2e-3, 5e-3)
NS12_JOINT_1 = {
    "coulomb": 0.4623,  # τ_s + (π/2)·τ_sc
    "static": 1.5237,
    "stribeck_velocity": 0.1,  # 1/δ
    "stribeck_exponent": 2.0,  # the exponent that the native element has
    "bristle_stiffness": 765500.0,
    "bristle_damping": 1456.0,
    "viscous": 0.0027,
}
ROTOR = """
<mujoco>
  <option gravity="0 0 0"/>
  <worldbody><body><joint name="rotor" axis="0 0 1" armature="0.01"/><geom size=".01" mass="1e-9"/></body></worldbody>
  <actuator><motor name="motor" joint="rotor"/></actuator>
</mujoco>
"""
RATIO = 100.0
MOTORS = {  # levels of the six motors, N·m: the NS12's table scaled to a UR5
    "shoulder_pan_joint": 0.10,
    "shoulder_lift_joint": 0.10,
    "elbow_joint": 0.08,
    "wrist_1_joint": 0.02,
    "wrist_2_joint": 0.02,
    "wrist_3_joint": 0.02,
}

Control = Callable[[mujoco.MjModel, mujoco.MjData, float], np.ndarray]


@dataclass(frozen=True)
class Case:
    """A model without friction, its laws by joint, its controller, and how long it runs."""

    spec: mujoco.MjSpec
    laws: dict[str, dict[str, float]]
    control: Control
    seconds: float
    reference_step: float


def rotor_case() -> Case:
    def control(_model: mujoco.MjModel, data: mujoco.MjData, t: float) -> np.ndarray:
        w = np.pi
        wanted, speed = 0.5 * np.sin(w * t), 0.5 * w * np.cos(w * t)
        return 100.0 * (wanted - data.qpos[:1]) + 2.0 * (speed - data.qvel[:1])

    return Case(mujoco.MjSpec.from_string(ROTOR), {"rotor": NS12_JOINT_1}, control, 4.0, 2e-6)


def motor_law(level: float) -> dict[str, float]:
    """Return the joint-side LuGre law of a motor level behind the gear."""
    share = level / NS12_JOINT_1["static"] * RATIO**2
    law = {**NS12_JOINT_1, "stribeck_velocity": 0.1 / RATIO * 10.0}
    for name in ("bristle_stiffness", "bristle_damping", "viscous"):
        law[name] = NS12_JOINT_1[name] * share
    law["static"], law["coulomb"] = level * RATIO, level * RATIO * 0.6
    return law


def six_axis_case() -> Case:
    path = resolve_model("package://example-robot-data/ur_description/urdf/ur5_robot.urdf", Path())
    text = re.sub(r"<(visual|collision)>.*?</\1>", "", path.read_text("utf-8"), flags=re.DOTALL)
    spec = mujoco.MjSpec.from_string(text)
    laws = {name: motor_law(level) for name, level in MOTORS.items()}
    for joint in spec.joints:
        joint.armature = (5e-5 if "wrist" not in joint.name else 5e-6) * RATIO**2
        spec.add_actuator(name=joint.name, trntype=mujoco.mjtTrn.mjTRN_JOINT, target=joint.name).set_to_motor()
    phase, rate = np.arange(6) * 0.7, np.linspace(1.5, 3.0, 6)
    middle = np.array([0.0, -1.2, 1.0, 0.3, 0.5, 0.0])
    model = spec.compile()
    plan = mujoco.MjData(model)

    def control(_model: mujoco.MjModel, data: mujoco.MjData, t: float) -> np.ndarray:
        wanted = middle + 0.4 * np.sin(rate * t + phase)
        speed, push = 0.4 * rate * np.cos(rate * t + phase), -0.4 * rate**2 * np.sin(rate * t + phase)
        plan.qpos[:], plan.qvel[:] = wanted, speed
        plan.qacc[:] = push
        mujoco.mj_inverse(model, plan)
        inertia = np.diag(np.array([spec_joint.armature for spec_joint in spec.joints]) + 0.3)
        return plan.qfrc_inverse + inertia @ (400.0 * (wanted - data.qpos) + 40.0 * (speed - data.qvel))

    return Case(spec, laws, control, 3.0, 2e-5)


def ours(case: Case) -> mujoco.MjModel:
    """Return the model with the laws attached."""
    return attach(case.spec, {name: friction("lugre", law) for name, law in case.laws.items()})


def native(case: Case, element: Callable[[dict[str, float]], Native]) -> mujoco.MjModel:
    """Return the model with MuJoCo's own elements on every joint, under the integrator where they are most stable."""
    spec = case.spec.copy()
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    for name, law in case.laws.items():
        put_on(spec, name, element(law))
    return spec.compile()


def native_lugre(case: Case) -> mujoco.MjModel:
    """Return the model with MuJoCo's LuGre element; under Euler it is unstable."""

    def element(law: dict[str, float]) -> Native:
        found = exact_native(friction("lugre", law))
        assert found is not None
        return found

    return native(case, element)


def native_frictionloss(case: Case) -> mujoco.MjModel:
    """Return the model with MuJoCo's dry friction and damping, with the solver as stiff as possible."""
    return native(case, lambda law: Native(damping=(law["viscous"], 0.0, 0.0), frictionloss=law["coulomb"]))


def run(case: Case, model: mujoco.MjModel, h: float) -> np.ndarray:
    """Return the positions at every 10 ms, (samples, joints); NaN from where the run broke down."""
    model.opt.timestep = h
    data = mujoco.MjData(model)
    data.qpos[:] = home(case)
    every, sample = max(1, round(CONTROL_PERIOD / h)), round(1e-2 / h)
    out = np.full((round(case.seconds / 1e-2), model.nv), np.nan)
    for k in range(0, round(case.seconds / h), every):
        held = case.control(model, data, k * h)
        data.ctrl[: held.size] = held
        mujoco.mj_step(model, data, nstep=every)
        if any(warning.number for warning in data.warning):
            return out
        if (k + every) % sample == 0:
            out[(k + every) // sample - 1] = data.qpos
    return out


def home(case: Case) -> np.ndarray:
    """Return where the case begins: on its path."""
    if "rotor" in case.laws:
        return np.zeros(1)
    return np.array([0.0, -1.2, 1.0, 0.3, 0.5, 0.0]) + 0.4 * np.sin(np.arange(6) * 0.7)


def run_explicit(case: Case, h: float) -> np.ndarray:
    """Return what :func:`run` does, with each law stepped at the present velocity and added as a force, as by hand."""
    model = case.spec.compile()
    model.opt.timestep = h
    data = mujoco.MjData(model)
    data.qpos[:] = home(case)
    law, room = LAWS["lugre"], ambient(1)[0]
    packed = [law.pack(case.laws[model.joint(i).name]) for i in range(model.nv)]
    states = [np.zeros(1) for _ in packed]
    every, sample = max(1, round(CONTROL_PERIOD / h)), round(1e-2 / h)
    out = np.full((round(case.seconds / 1e-2), model.nv), np.nan)
    for k in range(round(case.seconds / h)):
        if k % every == 0:
            held = case.control(model, data, k * h)
        data.ctrl[: held.size] = held
        for i, p in enumerate(packed):
            torque, _ = law.advance(float(data.qvel[i]), room, states[i].copy(), h, p, states[i])
            data.qfrc_applied[i] = -torque
        mujoco.mj_step(model, data)
        if any(warning.number for warning in data.warning) or np.max(np.abs(data.qvel)) > 1e3:
            return out
        if (k + 1) % sample == 0:
            out[(k + 1) // sample - 1] = data.qpos
    return out


def error(positions: np.ndarray, reference: np.ndarray) -> np.ndarray:
    """Return the RMS position error of every joint, inf where the run broke down."""
    rms = np.sqrt(np.mean((positions - reference) ** 2, axis=0))
    return np.where(np.isfinite(rms), rms, np.inf)


def reference(case: Case) -> np.ndarray:
    """Return the positions at the case's very small step."""
    with friction_active():
        return run(case, ours(case), case.reference_step)


def table(case: Case, steps: tuple[float, ...] = STEPS) -> dict[str, list[np.ndarray]]:
    """Return the RMS errors of every method at every step."""
    truth = reference(case)
    with friction_active():
        own = [error(run(case, ours(case), h), truth) for h in steps]
    return {
        "the law's step, added explicitly": [error(run_explicit(case, h), truth) for h in steps],
        "native dcmotor lugre": [error(run(case, native_lugre(case), h), truth) for h in steps],
        "native frictionloss + damping": [error(run(case, native_frictionloss(case), h), truth) for h in steps],
        "mjfriction": own,
    }


if __name__ == "__main__":
    for name, case in (("rotor", rotor_case()), ("six axes", six_axis_case())):
        print(name)
        for way, errors in table(case).items():
            print(f"  {way:<32}", *(f"{np.max(e):.2g}" for e in errors))
