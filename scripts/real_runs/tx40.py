"""A Stäubli TX40, whose wrist motor 6 turns with joints 5 and 6, with the friction published for it."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet

from mjfriction.record.log import Log
from mjfriction.record.readers.table import log_from_table
from mjfriction.robot.files import read_robot
from mjfriction.robot.robot import Robot

JOINTS = tuple(f"joint_{i}" for i in range(1, 7))
RATIO = np.array([32.0, 32.0, 45.0, -48.0, 45.0, 32.0])
ZERO = np.array([-np.pi, -np.pi / 2.0, np.pi / 2.0, 0.0, 0.0, np.pi])
COULOMB = (7.14, 8.26, 6.34, 2.48, 3.03, 0.282)
VISCOUS = (8.05, 5.53, 1.97, 1.11, 1.86, 0.65)
ROTOR = (0.362, 0.362, 0.0988, 0.0313, 0.0468, 0.0105)  # kg·m² at the joint


def tx40_log(data: Path) -> Log:
    """Return the log on the joints' side: motor 6 turns with joints 5 and 6."""
    table = pyarrow.parquet.read_table(data / "tx40/motor_side.parquet")
    turns = np.diag(RATIO)
    turns[5, 4] = RATIO[5]
    motor = np.column_stack([table[f"motor_position.{joint}"].to_numpy() for joint in JOINTS])
    torque = np.column_stack([table[f"motor_torque.{joint}"].to_numpy() for joint in JOINTS])
    position, effort = np.linalg.solve(turns, motor.T).T + ZERO, torque @ turns
    columns = {"time": table["time"].to_numpy()}
    columns |= {f"position.{joint}": position[:, i] for i, joint in enumerate(JOINTS)}
    columns |= {f"effort.{joint}": effort[:, i] for i, joint in enumerate(JOINTS)}
    return log_from_table(pa.table(columns), "tx40")


def tx40(data: Path, folder: Path, rotors: Sequence[float] = ROTOR) -> Robot:
    """Return the arm as published, its file in ``folder``."""
    lines = ['name = "tx40"', f'model = "{data / "tx40/tx40.urdf"}"']
    for i, joint in enumerate(JOINTS):
        lines += ["[[joint]]", f'name = "{joint}"']
        rotor = rotors[i] / RATIO[i] ** 2
        lines += [f"actuator = {{ gear_ratio = {RATIO[i]}, torque_constant = 1.0, rotor_inertia = {rotor} }}"]
        parameters = f"{{ coulomb = {COULOMB[i]}, viscous = {VISCOUS[i]} }}"
        lines += [f'friction = {{ law = "coulomb_viscous", parameters = {parameters} }}']
    path = folder / "robot.toml"
    path.write_text("\n".join(lines), encoding="utf-8")
    return read_robot(path)
