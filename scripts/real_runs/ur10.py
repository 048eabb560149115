"""A UR10 along an exciting motion, its model wrong everywhere: the part that is fitted and the part that is not."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from pyarrow import parquet

from mjfriction.record.log import Floats, Log
from mjfriction.record.readers.table import log_from_table
from mjfriction.robot.predict import predict_log
from mjfriction.robot.robot import Robot

FITTED = 0.6  # of the log
STRUCTURES = {"shoulder_pan_joint": "saturating_viscous", "shoulder_lift_joint": "load_dependent"}
BASE_PARAMETERS = (15.2, 6.2, 5.4, 11.6, 12.6, 32.4)
"""Errors (%) on the rest of base parameters with Coulomb and viscous friction, as others fitted them to this part."""


def parts(data: Path) -> tuple[Log, Log]:
    """Return the first 60 % of the log, and the rest."""
    table = parquet.read_table(data / "ur10/exciting.parquet")
    part = int(FITTED * table.num_rows)
    return log_from_table(table.slice(0, part), "first"), log_from_table(table.slice(part), "rest")


def relative_errors(log: Log, robot: Robot) -> Floats:
    """Return 100·‖y − ŷ‖/‖y‖ of every joint's effort as it was reported, (joints,)."""
    predicted = predict_log(log, robot)
    pairs = [(log.columns[f"effort.{joint}"], predicted[f"effort.{joint}"]) for joint in robot.joints]
    return np.array([100.0 * np.linalg.norm(y - own) / np.linalg.norm(y) for y, own in pairs])
