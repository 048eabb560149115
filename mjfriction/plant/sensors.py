"""What a machine's sensors say of what it did: late, scaled, off, quantized, noisy, at uneven instants."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mjfriction.record.log import CURRENT, EFFORT, POSITION, VELOCITY, Floats
from mjfriction.robot.effort import effort_per_reported
from mjfriction.robot.robot import Robot


@dataclass(frozen=True)
class Recorder:
    """How a log is taken: ``rate`` (Hz), ``jitter`` of the instants (share of a step), whether velocity is measured,
    and ``quantity``, ``"effort"`` or ``"current"``.
    """

    rate: float = 1000.0
    jitter: float = 0.0
    velocity: bool = False
    quantity: str = EFFORT


def record(
    robot: Robot, recorder: Recorder, time: Floats, position: Floats, velocity: Floats, torque: Floats, seed: int
) -> dict[str, Floats]:
    """Return the columns of a log of a course: ``time`` (m,), the others (m, joints) on its finer grid.

    Position reads position + offset, the drive scale·torque(t − delay) + offset; then noise, then resolution.
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
        read = at(position[:, i], instants) + sensor.offset + sensor.noise * rng.standard_normal(instants.size)
        columns[f"{POSITION}.{joint.name}"] = _quantized(read, sensor.resolution)
        if recorder.velocity:
            noise = sensor.velocity_noise * rng.standard_normal(instants.size)
            columns[f"{VELOCITY}.{joint.name}"] = at(velocity[:, i], instants) + noise
        # The torque of a step is held through it: a reading is of the step its instant lies in.
        held = np.searchsorted(time, instants - drive.delay + 1e-9 * step, side="right") - 1
        reported = drive.scale * torque[np.clip(held, 0, time.size - 1), i] + drive.offset
        reported = _quantized(reported + drive.noise * rng.standard_normal(instants.size), drive.resolution)
        unit = effort_per_reported(joint, CURRENT if recorder.quantity == CURRENT else EFFORT, robot.name)
        columns[f"{recorder.quantity}.{joint.name}"] = reported / unit
    return columns


def _quantized(values: Floats, resolution: float) -> Floats:
    return np.round(values / resolution) * resolution if resolution > 0.0 else values
