"""A log: the recording of a real or simulated machine."""

from __future__ import annotations

import difflib
import itertools
import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mjfriction.errors import LogError, suggestion
from mjfriction.record.fault import Fault
from mjfriction.record.span import EVER, Span

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]

POSITION, VELOCITY, EFFORT, CURRENT = "position", "velocity", "effort", "current"
SUPPLY_PRESSURE = "supply_pressure"
TEMPERATURE, HEAD_PRESSURE, ROD_PRESSURE, VOLTAGE = "temperature", "pressure_head", "pressure_rod", "voltage"
PUSH = "push"
HELD_MASS = "held_mass"
JOINED = " + "  # separates the sources of logs that were joined
MEASURED = (POSITION, VELOCITY, EFFORT, CURRENT, TEMPERATURE, HEAD_PRESSURE, ROD_PRESSURE)
KNOWN = (*MEASURED, "position_ref", "velocity_ref")
OF_JOINTS = (*KNOWN, VOLTAGE, PUSH)
OF_MACHINE = (SUPPLY_PRESSURE, HELD_MASS)
# Words that mark a column as a set point, not a measurement.
SET_WORDS = {"ref", "reference", "target", "desired", "des", "cmd", "command", "commanded", "setpoint", "error", "goal"}
LIKE = 0.8  # similarity to a known quantity; a column's name at least so similar is taken as misspelt


@dataclass(frozen=True, repr=False)
class Log:
    """A table of samples over time, in SI units.

    ``time`` and ``segment`` have shape (n,); time increases within a segment.  ``columns`` holds every numeric column
    under its full name (``position.elbow_joint``), each of shape (n,).  ``joints`` are the joints that have a
    position column, in the order of the file.  ``faults`` are those of the recording that were found and repaired;
    ``unusable`` marks samples of a column, (n,), that were recorded but carry no information.  Where rows were left
    out, ``recorded`` (m,) is the time of every row of the file and ``kept`` (m,) marks the n that remain.  ``joined``
    are the names of several logs that were joined, each with the time at which it begins here.
    """

    source: str
    time: Floats
    segment: Integers
    joints: tuple[str, ...]
    columns: Mapping[str, Floats]
    faults: tuple[Fault, ...] = ()
    unusable: Mapping[str, NDArray[np.bool_]] = field(default_factory=dict)
    recorded: Floats | None = None
    kept: NDArray[np.bool_] | None = None
    joined: tuple[tuple[str, float], ...] = ()

    def __repr__(self) -> str:
        """The file, its number of rows, its length, and its joints."""
        seconds = float(self.time[-1] - self.time[0]) if self.time.size else 0.0
        return f"<Log '{self.source}': {self.time.size} rows over {seconds:.4g} s; {', '.join(self.joints)}>"

    @property
    def name(self) -> str:
        """The file's name, without its folder; all of them where logs were joined."""
        return JOINED.join(Path(source).name for source in self.source.split(JOINED))

    @property
    def logs(self) -> tuple[tuple[str, Span], ...]:
        """The name and the time span of each log that was joined; the whole time for a single log."""
        if len(self.joined) < 2:
            return ((self.name, EVER),)
        spans = itertools.pairwise([*(begin for _, begin in self.joined), math.inf])
        return tuple((name, span) for (name, _), span in zip(self.joined, spans, strict=True))

    def channel(self, quantity: str, joint: str) -> Floats | None:
        """Return a joint's column (``position``, ``velocity``, ``effort``, ``current``, …), or None if not recorded."""
        return self.columns.get(f"{quantity}.{joint}")

    def as_recorded(self, values: Floats) -> Floats:
        """Return values (n,) at every row of the file, (m,), NaN at those that were left out."""
        if self.kept is None:
            return values
        out = np.full(self.kept.size, np.nan)
        out[self.kept] = values
        return out

    def holding(self, mass: float) -> Log:
        """Return the log with a constant held mass (kg): the robot carried it all the time.

        Raises :class:`LogError` for a mass below zero.
        """
        if not mass >= 0.0:
            raise LogError(f"{self.source}: held mass {mass:g}; a mass is 0 kg or more")
        return replace(self, columns={**self.columns, HELD_MASS: np.full(self.time.size, mass)})

    def torque_quantity(self, joint: str) -> str | None:
        """Return ``"effort"`` or ``"current"``, whichever the log measured on the joint (effort first), or None."""
        for quantity in (EFFORT, CURRENT):
            if f"{quantity}.{joint}" in self.columns:
                return quantity
        return None


def check_joints(log: Log, robot_name: str, robot_joints: tuple[str, ...]) -> None:
    """Raise :class:`LogError` unless the log has all of the robot's joints, and one at least has effort or current.

    Joints that the robot lacks, such as a gripper's, are ignored; misspelt quantities and joints are errors.
    """
    unknown = [joint for joint in log.joints if joint not in robot_joints]
    listed = ", ".join(robot_joints)
    if unknown and len(unknown) == len(log.joints):
        raise LogError(
            f"{log.source}: this looks like a log of another robot: it has joints {', '.join(log.joints)}, "
            f"robot '{robot_name}' has {listed}; give the robot file that belongs to the log, or say with --map which "
            "column is which joint's"
        )
    missing = [joint for joint in robot_joints if joint not in log.joints]
    if missing:
        foreign = [f"{POSITION}.{joint}" for joint in unknown]
        foreign += [name for name in log.columns if name.partition(".")[0] not in OF_JOINTS]
        raise LogError(
            f"{log.source}: column 'position.{missing[0]}' is missing"
            f"{suggestion(f'position.{missing[0]}', foreign)} Found positions of {', '.join(log.joints)}. Every "
            f"joint that robot '{robot_name}' lists must be recorded, for its pose sets the load of the others; a "
            "joint taken out of the robot file is held where the model has it"
        )
    if not any(log.torque_quantity(joint) for joint in robot_joints):
        raise LogError(
            f"{log.source}: no 'effort.<joint>' or 'current.<joint>' column; one joint at least must have what its "
            f"drive measured. Found: {', '.join(log.columns)}"
        )
    for name in log.columns:
        quantity, dot, joint = name.partition(".")
        meant = _misspelt(log, quantity, joint) if dot and joint in robot_joints else None
        if meant is not None:
            raise LogError(
                f"{log.source}: column '{name}' is not of the format, and would be left out; did you mean '{meant}'?"
            )
        if dot and quantity in (VELOCITY, EFFORT, CURRENT) and joint not in (*robot_joints, *log.joints):
            raise LogError(
                f"{log.source}: column '{name}': robot '{robot_name}' has no joint "
                f"'{joint}'{suggestion(joint, robot_joints)} Its joints are {listed}"
            )


def _misspelt(log: Log, quantity: str, joint: str) -> str | None:
    # The measurement that the log lacks and that an unknown column was probably meant to be.  Set points are none, and
    # a log with an effort needs no current.
    if quantity in OF_JOINTS or SET_WORDS & set(quantity.split("_")):
        return None
    for meant in difflib.get_close_matches(quantity, MEASURED, n=1, cutoff=LIKE):
        torque = meant in (EFFORT, CURRENT) and log.torque_quantity(joint) is not None
        if f"{meant}.{joint}" not in log.columns and not torque:
            return f"{meant}.{joint}"
    return None
