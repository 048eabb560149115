"""A Dynamixel XL330 with a pendulum (Rhoban's logs): friction that grows with the load."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pyarrow as pa
from scipy.signal import savgol_filter

from mjfriction.diagnose.diagnosis import diagnose_log
from mjfriction.record.log import Log
from mjfriction.record.merge import merge_logs
from mjfriction.record.readers.table import log_from_table
from mjfriction.robot.files import read_robot

TORQUE_CONSTANT, RESISTANCE, FULL_PWM = 0.3867, 4.017, 885.0
URDF = """<robot name="pendulum"><link name="base"/><link name="arm"><inertial><origin xyz="0 0 -0.1"/>
<mass value="0.49"/><inertia ixx="1e-6" iyy="1e-6" izz="1e-6" ixy="0" ixz="0" iyz="0"/></inertial></link>
<joint name="hinge" type="continuous"><parent link="base"/><child link="arm"/><axis xyz="0 1 0"/></joint></robot>"""
ROBOT = f"""name = "xl330"
model = "pendulum.urdf"
[[joint]]
name = "hinge"
actuator = {{ gear_ratio = 1.0, torque_constant = {TORQUE_CONSTANT}, rotor_inertia = 0.00181 }}
position_sensor = {{ offset = -0.0309 }}
friction = {{ law = "coulomb_viscous", parameters = {{ coulomb = 0.0128, viscous = 0.00366 }} }}
"""


def driven(path: Path) -> Log:
    """The powered part of a run; the torque from the published motor's voltage, which the logged PWM sets."""
    entries = [entry for entry in json.loads(path.read_text())["entries"] if entry["torque_enable"]]
    course = {name: np.array([entry[name] for entry in entries], dtype=float) for name in entries[0]}
    time, position, load = course["timestamp"], course["position"], course["load"]
    load = np.where(load > 2**15, load - 2**16, load)  # logged as unsigned
    speed = savgol_filter(np.gradient(position, time), 9, 2)
    effort = TORQUE_CONSTANT * (load / FULL_PWM * course["input_volts"] - TORQUE_CONSTANT * speed) / RESISTANCE
    segment = np.cumsum(np.append(0, np.diff(time) > 0.05))
    columns = {"time": time, "segment": segment, "position.hinge": position, "effort.hinge": effort}
    return log_from_table(pa.table(columns), path.name)


def test_friction_grows_with_the_load(data: Path, tmp_path: Path) -> None:
    (tmp_path / "pendulum.urdf").write_text(URDF)
    (tmp_path / "robot.toml").write_text(ROBOT)
    logs = [driven(path) for path in sorted((data / "xl330").glob("*.json"))]
    diagnosis = diagnose_log(merge_logs(logs), read_robot(tmp_path / "robot.toml"))
    (finding,) = diagnosis.findings
    assert (finding.cause, finding.joint) == ("friction.load", "hinge")
    assert finding.gain.low > 0.3
