"""A trajectory: the wanted motion of the joints, as a table."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import pyarrow as pa
from scipy.interpolate import CubicSpline

from mjfriction.errors import LogError
from mjfriction.record.log import (
    HEAD_PRESSURE,
    POSITION,
    PUSH,
    ROD_PRESSURE,
    SUPPLY_PRESSURE,
    TEMPERATURE,
    VOLTAGE,
    Floats,
)
from mjfriction.record.readers import read_table

AHEAD = (*(f"{name}." for name in (TEMPERATURE, HEAD_PRESSURE, ROD_PRESSURE, VOLTAGE, PUSH)), SUPPLY_PRESSURE)


@dataclass(frozen=True)
class Trajectory:
    """Positions of joints over time, (n, joints), smooth in between; ``ambient`` are columns that pass into the log.

    Joints that it does not name stay at zero, except those with a ``voltage.<joint>`` column: that voltage goes
    directly to the valve of a cylinder.  ``supply_pressure`` is the supply of the valves.  ``push.<joint>`` is an
    external push on the joint (N·m or N); it does not pass into the log, because no sensor measures it.
    """

    joints: tuple[str, ...]
    time: Floats
    position: Floats
    ambient: dict[str, Floats] = field(default_factory=dict)

    def at(self, time: Floats) -> tuple[Floats, Floats, Floats]:
        """Return position, velocity and acceleration (m, joints) at given times, by cubic splines."""
        if not self.joints:
            return (np.empty((time.size, 0)),) * 3
        spline = CubicSpline(self.time, self.position, axis=0, bc_type="clamped")
        return spline(time), spline(time, 1), spline(time, 2)

    def table(self) -> pa.Table:
        """Return the trajectory as a table: ``time``, ``position.<joint>``, and the ambient columns."""
        columns = {"time": self.time}
        columns |= {f"{POSITION}.{name}": self.position[:, i] for i, name in enumerate(self.joints)}
        return pa.table({**columns, **self.ambient})


def read_trajectory(path: Path | str) -> Trajectory:
    """Read a trajectory table, CSV or Parquet, of ``time`` and ``position.<joint>``; a log will do too.

    For a joint moved by a cylinder, ``voltage.<joint>`` of its valve may replace ``position.<joint>``.

    Raises :class:`LogError` for a table that has no such columns or whose time does not increase.
    """
    table = read_table(Path(path))
    names = table.schema.names
    joints = tuple(name.removeprefix("position.") for name in names if name.startswith("position."))
    volts = any(name.startswith(f"{VOLTAGE}.") for name in names)
    if "time" not in names or not (joints or volts):
        raise LogError(f"{path}: a trajectory has 'time' and 'position.<joint>' columns. Found: {', '.join(names)}")

    def column(name: str) -> Floats:
        try:
            return np.asarray(table[name].to_numpy(), dtype=np.float64)
        except (TypeError, ValueError):
            raise LogError(f"{path}: column '{name}' holds what is not a number") from None

    time = column("time")
    if time.size < 4 or np.any(np.diff(time) <= 0.0) or not np.all(np.isfinite(time)):
        raise LogError(f"{path}: a trajectory needs at least 4 rows whose time increases")
    position = np.column_stack([column(f"position.{joint}") for joint in joints] or [np.empty((time.size, 0))])
    if not np.all(np.isfinite(position)):
        raise LogError(f"{path}: positions of a trajectory must all be numbers; fill or drop the rows that are not")
    return Trajectory(joints, time, position, {name: column(name) for name in names if name.startswith(AHEAD)})
