"""A UR10 along an exciting motion, with a model wrong everywhere: the part that is fitted and the held-out part."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from pyarrow import parquet

from mjfriction.identify.measure import measure_gap
from mjfriction.record.log import Floats, Log
from mjfriction.record.readers.table import log_from_table
from mjfriction.robot.predict import predict_log
from mjfriction.robot.robot import Robot

FITTED = 0.6  # share of the log that is fitted
STRUCTURES = {"shoulder_pan_joint": "saturating_viscous", "shoulder_lift_joint": "load_dependent"}
BASE_PARAMETERS = (15.2, 6.2, 5.4, 11.6, 12.6, 32.4)
"""Errors (%) on the rest of base parameters with Coulomb and viscous friction, as others fitted them to this part."""
STRIBECK_VELOCITIES = np.geomspace(0.02, 0.8, 30)


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


@dataclass(frozen=True)
class AsReported:
    """Friction of one joint fitted to its effort as it was reported, ignoring the filter that it went through.

    ``plain`` and ``stribeck`` are the errors (%) with Coulomb-viscous friction alone and with a Stribeck curve;
    ``coulomb`` is that curve's level and ``excess`` its excess near rest (N·m).
    """

    plain: float
    stribeck: float
    coulomb: float
    excess: float


def stribeck_as_reported(log: Log, robot: Robot, joint: int) -> AsReported:
    """Fit both laws at a joint, together with the effort of the robot's links and rotors and an inertia."""
    gap = measure_gap(log, robot)
    velocity, effort = gap.motion.velocity[:, joint], gap.motion.torque[:, joint] * gap.per_reported[joint]
    known = [gap.known.effort.rigid[:, joint], gap.motion.acceleration[:, joint], np.sign(velocity), velocity]

    def fitted(*more: Floats) -> tuple[float, Floats]:
        columns = np.column_stack([*known, *more])
        strengths = np.linalg.lstsq(columns, effort, rcond=None)[0]
        return float(100.0 * np.linalg.norm(effort - columns @ strengths) / np.linalg.norm(effort)), strengths

    plain, _ = fitted()
    curves = [np.sign(velocity) * np.exp(-np.square(velocity / own)) for own in STRIBECK_VELOCITIES]
    error, strengths = min((fitted(curve) for curve in curves), key=lambda entry: entry[0])
    return AsReported(plain, error, float(strengths[2]), float(strengths[-1]))
