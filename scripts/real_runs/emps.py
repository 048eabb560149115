"""The prismatic axis EMPS (Janot, Gautier, Brunot 2019): its two runs predicted in force and simulated open loop."""

from __future__ import annotations

import mujoco
import numpy as np
from scipy.signal import decimate

import mjfriction as mjf
from mjfriction.record.log import Log
from mjfriction.robot.predict import predict_log
from mjfriction.robot.robot import Robot

RUNS = ("estimation", "pulses")
STEP = 1e-3  # s


def force_error(log: Log, robot: Robot) -> float:
    """Return 100·‖y − ŷ‖/‖y‖ of the force, decimated by ten as the data set's authors do."""
    measured, predicted = (decimate(values["effort.axis"], 10) for values in (log.columns, predict_log(log, robot)))
    return float(100.0 * np.linalg.norm(measured - predicted) / np.linalg.norm(measured))


def open_loop_error(robot: Robot, log: Log) -> float:
    """Return the RMS position error (m) of the axis under its measured force, simulated from the first sample on."""
    model = mjf.attach(mjf.robot_spec(robot), mjf.robot_laws(robot))
    model.opt.timestep = STEP
    data = mujoco.MjData(model)
    position = log.columns["position.axis"]
    force = log.columns["effort.axis"] - robot.joint("axis").effort_sensor.offset
    data.qpos[0] = position[0]
    missed = np.empty(position.size)
    with mjf.friction_active():
        for i in range(position.size):
            missed[i] = data.qpos[0] - position[i]
            data.qfrc_applied[0] = force[i]
            mujoco.mj_step(model, data)
    return float(np.sqrt(np.mean(np.square(missed))))
