"""A Dynamixel XL330 with a pendulum, recorded by the authors of BAM, and simulated with identified friction."""

from __future__ import annotations

import json
from pathlib import Path

import mujoco
import numpy as np
import pyarrow as pa
from scipy.signal import savgol_filter

import mjfriction as mjf
from mjfriction.record.log import Log
from mjfriction.record.readers.table import log_from_table
from mjfriction.robot.robot import Robot

TORQUE_CONSTANT, RESISTANCE, FULL_PWM = 0.3867, 4.017, 885.0  # of the XL330, as published
GAIN_DIVISOR = 256.0
COUNTS = 4096.0 / (2.0 * np.pi)
STEP = 1e-3  # s
PUBLISHED = 0.048  # rad; error of the published model whose friction grows with the load
COULOMB_VISCOUS = 0.086  # rad; error of the published model with Coulomb-viscous friction
XL330_URDF = """<robot name="pendulum"><link name="base"/><link name="arm"><inertial><origin xyz="0 0 -0.1"/>
<mass value="0.49"/><inertia ixx="1e-6" iyy="1e-6" izz="1e-6" ixy="0" ixz="0" iyz="0"/></inertial></link>
<joint name="hinge" type="continuous"><parent link="base"/><child link="arm"/><axis xyz="0 1 0"/></joint></robot>"""
XL330_ROBOT = f"""name = "xl330"
model = "pendulum.urdf"
[[joint]]
name = "hinge"
actuator = {{ gear_ratio = 1.0, torque_constant = {TORQUE_CONSTANT}, rotor_inertia = 0.00181 }}
position_sensor = {{ offset = -0.0309 }}
friction = {{ law = "coulomb_viscous", parameters = {{ coulomb = 0.0128, viscous = 0.00366 }} }}
"""


def xl330(folder: Path) -> Robot:
    """Return the XL330 with its pendulum and the published Coulomb-viscous friction, its files in ``folder``."""
    (folder / "pendulum.urdf").write_text(XL330_URDF, encoding="utf-8")
    (folder / "robot.toml").write_text(XL330_ROBOT, encoding="utf-8")
    return mjf.read_robot(folder / "robot.toml")


def xl330_log(path: Path) -> Log:
    """Return the powered part of a run, its torque from the logged PWM's voltage and the published motor constants."""
    entries = [entry for entry in json.loads(path.read_text(encoding="utf-8"))["entries"] if entry["torque_enable"]]
    course = {name: np.array([entry[name] for entry in entries], dtype=float) for name in entries[0]}
    time, position, load = course["timestamp"], course["position"], course["load"]
    load = np.where(load > 2**15, load - 2**16, load)  # logged as unsigned
    speed = savgol_filter(np.gradient(position, time), 9, 2)
    effort = TORQUE_CONSTANT * (load / FULL_PWM * course["input_volts"] - TORQUE_CONSTANT * speed) / RESISTANCE
    segment = np.cumsum(np.append(0, np.diff(time) > 0.05))
    columns = {"time": time, "segment": segment, "position.hinge": position, "effort.hinge": effort}
    return log_from_table(pa.table(columns), path.name)


def xl330_error(robot: Robot, path: Path) -> float:
    """Return the mean absolute position error (rad) of a run simulated with a robot's friction, under the drive's P
    control of the voltage.
    """
    run = json.loads(path.read_text(encoding="utf-8"))
    course = {name: np.array([entry[name] for entry in run["entries"]], dtype=float) for name in run["entries"][0]}
    model = mjf.attach(mjf.robot_spec(robot), mjf.robot_laws(robot))
    model.opt.timestep = STEP
    state = mujoco.MjData(model)
    offset = robot.joint("hinge").position_sensor.offset
    time = course["timestamp"]
    state.qpos[0], now = course["position"][0] - offset, time[0]
    went = np.empty(time.size)

    def torque(k: int) -> float:
        if not course["torque_enable"][k]:
            return 0.0  # the bridge is open: no current, and no braking by it
        counts = (course["goal_position"][k] - state.qpos[0] - offset) * COUNTS
        duty = np.clip(counts * run["kp"] / GAIN_DIVISOR, -FULL_PWM, FULL_PWM) / FULL_PWM
        volts = duty * course["input_volts"][k] - TORQUE_CONSTANT * state.qvel[0]
        return float(TORQUE_CONSTANT * volts / RESISTANCE)

    with mjf.friction_active():
        for k in range(time.size):
            while now < time[k] - 1e-9:
                state.qfrc_applied[0] = torque(k - 1)
                mujoco.mj_step(model, state)
                now += STEP
            went[k] = state.qpos[0] + offset
    return float(np.mean(np.abs(went - course["position"])))
