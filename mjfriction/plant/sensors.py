"""A machine's sensor readings: delayed, scaled, offset, quantized, noisy, at uneven instants."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from scipy.signal import lfilter

from mjfriction.control.sensing import quantized
from mjfriction.plant.cylinder import Cylinder
from mjfriction.record.log import (
    CURRENT,
    EFFORT,
    HEAD_PRESSURE,
    POSITION,
    ROD_PRESSURE,
    SUPPLY_PRESSURE,
    VELOCITY,
    VOLTAGE,
    Floats,
)
from mjfriction.record.low_pass import low_passed
from mjfriction.robot.effort import effort_per_reported
from mjfriction.robot.robot import Robot
from mjfriction.robot.schema import Joint
from mjfriction.sim.closed_loop import Played


@dataclass(frozen=True)
class Recorder:
    """How a log is recorded.

    ``rate`` is in Hz, ``jitter`` of the instants is a fraction of a step, ``velocity`` says whether velocity is
    measured, and ``quantity`` is ``"effort"`` or ``"current"``.
    """

    rate: float = 1000.0
    jitter: float = 0.0
    velocity: bool = False
    quantity: str = EFFORT


def record(
    robot: Robot, recorder: Recorder, time: Floats, played: Played, cylinders: Mapping[str, Cylinder], seed: int
) -> dict[str, Floats]:
    """Return the columns of a log of what was played at instants ``time`` (n,), finer than the log's own.

    The position reading is position + offset.  The drive reports scale·torque(t − delay) + offset, low-passed where it
    has a bandwidth.  Then noise is added, then resolution applied.  A cylinder's effort is computed from its pressures
    as they are measured.
    """
    rng = np.random.default_rng([seed, 11])
    step = 1.0 / recorder.rate
    instants = np.arange(time[0], time[-1] + 0.5 * (time[1] - time[0]), step)
    if recorder.jitter > 0.0:
        instants = instants + step * np.clip(recorder.jitter * rng.standard_normal(instants.size), -0.45, 0.45)
        instants = np.clip(instants, time[0], time[-1])

    def at(values: Floats, when: Floats) -> Floats:
        return np.interp(when, time, values)

    columns = {"time": instants}
    for i, joint in enumerate(robot.table.joint):
        sensor, drive = joint.position_sensor, joint.effort_sensor
        read = at(played.position[:, i], instants) + sensor.offset + sensor.noise * rng.standard_normal(instants.size)
        read = quantized(read, sensor.resolution)
        columns[f"{POSITION}.{joint.name}"] = read
        if recorder.velocity:
            noise = sensor.velocity_noise * rng.standard_normal(instants.size)
            columns[f"{VELOCITY}.{joint.name}"] = noise + (
                _estimated(read, instants, sensor.velocity_bandwidth)
                if sensor.velocity_bandwidth is not None
                else at(played.velocity[:, i], instants)
            )
        if joint.hydraulics is not None:
            columns |= _of_cylinder(joint, cylinders[joint.name], time, instants, rng)
            continue
        # The torque is held through each step, so a reading belongs to the step that contains its instant.
        held = np.searchsorted(time, instants - drive.delay + 1e-9 * step, side="right") - 1
        torque = played.torque[:, i]
        if drive.bandwidth is not None:
            torque = low_passed(torque, 1.0 / float(time[1] - time[0]), drive.bandwidth)
        reported = drive.scale * torque[np.clip(held, 0, time.size - 1)] + drive.offset
        reported = quantized(reported + drive.noise * rng.standard_normal(instants.size), drive.resolution)
        unit = effort_per_reported(joint, CURRENT if recorder.quantity == CURRENT else EFFORT, robot.name)
        columns[f"{recorder.quantity}.{joint.name}"] = reported / unit
    return columns


def _of_cylinder(
    joint: Joint, cylinder: Cylinder, time: Floats, instants: Floats, rng: np.random.Generator
) -> dict[str, Floats]:
    of, drive = cylinder.of, joint.effort_sensor
    pressures = []
    for values in (cylinder.p1, cylinder.p2):
        read = np.interp(instants - drive.delay, time, values) + of.pressure_noise * rng.standard_normal(instants.size)
        pressures.append(quantized(read, of.pressure_resolution))
    return {
        f"{EFFORT}.{joint.name}": drive.scale * (of.head_area * pressures[0] - of.rod_area * pressures[1])
        + drive.offset,
        f"{HEAD_PRESSURE}.{joint.name}": pressures[0],
        f"{ROD_PRESSURE}.{joint.name}": pressures[1],
        f"flow_head.{joint.name}": np.interp(instants, time, cylinder.q1),
        f"flow_rod.{joint.name}": np.interp(instants, time, cylinder.q2),
        f"{VOLTAGE}.{joint.name}": np.interp(instants, time, cylinder.volts),
        SUPPLY_PRESSURE: np.interp(instants, time, cylinder.supply),
    }


def _estimated(position: Floats, instants: Floats, bandwidth: float) -> Floats:
    # As a drive does it: differences of the position readings, smoothed by a causal first-order low-pass.
    difference = np.diff(position, prepend=position[0]) / np.median(np.diff(instants))
    share = -np.expm1(-2.0 * np.pi * bandwidth * float(np.median(np.diff(instants))))
    return np.asarray(lfilter([share], [1.0, share - 1.0], difference))
