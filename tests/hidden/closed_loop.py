"""A UR5 in closed loop, simulated by stock MuJoCo alone, with friction that may fade with speed.

Its joints stick and break loose as the drives pull over, which motions prescribed by formula do not show.
"""

from __future__ import annotations

import tomllib
from pathlib import Path

import mujoco
import numpy as np
import pyarrow as pa

from tests.hidden.machine import UR5, mujoco_model

ROOT = Path(__file__).resolve().parents[2]
UR5_TOML = ROOT / "robots/ur5/robot.toml"
STEP, RATE, SECONDS, RAMP = 5e-4, 250, 30.0, 2.0
ENCODER = 2.0 * np.pi / 2**17
EFFORT_NOISE = 0.1  # of each joint's Coulomb level
HOME = np.array([0.0, -1.2, 1.4, -0.4, 1.2, 0.0])


def arm(robot: dict, model_file: Path) -> mujoco.MjModel:
    """Return the UR5 with its rotors and with MuJoCo's own dry friction and damping at the stated levels."""
    model = mujoco_model(model_file)
    model.opt.timestep = STEP
    for i, joint in enumerate(robot["joint"]):
        drive, levels = joint["actuator"], joint["friction"]["parameters"]
        model.dof_armature[i] = drive["rotor_inertia"] * drive["gear_ratio"] ** 2
        model.dof_frictionloss[i], model.dof_damping[i] = levels["coulomb"], levels["viscous"]
        model.dof_solref[i], model.dof_solimp[i] = (0.004, 1.0), (0.99, 0.9999, 0.001, 0.5, 2.0)
    return model


def reference(rng: np.random.Generator, joints: int):
    frequency = rng.uniform(0.1, 0.5, (joints, 4)) * 2.0 * np.pi
    amplitude = rng.uniform(0.4, 1.0, (joints, 4)) * 0.6 / (1.0 + 0.5 * frequency)
    phase = rng.uniform(0.0, 2.0 * np.pi, (joints, 4))

    def at(t: float):
        angle = frequency * t + phase
        fade = min(1.0, t / RAMP) ** 3  # from rest, so that the loop starts quietly
        q = fade * np.sum(amplitude * np.sin(angle), axis=1)
        v = fade * np.sum(amplitude * frequency * np.cos(angle), axis=1)
        a = -fade * np.sum(amplitude * frequency**2 * np.sin(angle), axis=1)
        return q + HOME, v, a

    return at


def record_closed_loop(
    seed: int, *, fading: int | None = None, excess: float = 0.0, over: float = 1.0, seconds: float = SECONDS
) -> pa.Table:
    """Return a log of the arm under computed torque, PD and feedforward of the stated friction.

    The dry friction of joint ``fading`` is higher by ``excess`` N·m near rest, fading over ``over`` rad/s.
    """
    robot = tomllib.loads(UR5_TOML.read_text(encoding="utf-8"))
    rng = np.random.default_rng(seed)
    model = arm(robot, UR5)
    data = mujoco.MjData(model)
    names = [joint["name"] for joint in robot["joint"]]
    follow = reference(rng, len(names))
    coulomb = model.dof_frictionloss.copy()
    data.qpos[:] = follow(0.0)[0]
    mujoco.mj_forward(model, data)
    mass = np.empty((model.nv, model.nv))
    positions, efforts = [], []
    every = round(1.0 / (RATE * STEP))
    for k in range(int(seconds / STEP)):
        q, v, a = follow(k * STEP)
        mujoco.mj_fullM(model, data, mass)
        wanted = a + 900.0 * (q - data.qpos) + 60.0 * (v - data.qvel)
        torque = mass @ wanted + data.qfrc_bias + coulomb * np.tanh(v / 0.02) + model.dof_damping * v
        if fading is not None:
            left = np.exp(-((data.qvel[fading] / over) ** 2))
            model.dof_frictionloss[fading] = coulomb[fading] + excess * left
        data.qfrc_applied[:] = torque
        if k % every == 0:
            positions.append(data.qpos.copy())
            efforts.append(torque)
        mujoco.mj_step(model, data)
    position = np.round(np.array(positions) / ENCODER) * ENCODER
    effort = np.array(efforts) + EFFORT_NOISE * coulomb * rng.normal(size=(len(efforts), len(names)))
    columns = {"time": np.arange(len(position)) / RATE}
    columns |= {f"position.{name}": position[:, i] for i, name in enumerate(names)}
    columns |= {f"effort.{name}": effort[:, i].astype(np.float32) for i, name in enumerate(names)}
    return pa.table(columns)
