"""A controller's readings of its machine: positions as the sensors report them, and velocity estimated from them."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from mjfriction.laws.law import Floats
from mjfriction.robot.robot import Robot
from mjfriction.robot.schema import Hydraulics, PositionSensor

USUAL_BANDWIDTH = 200.0  # Hz, low-pass on the differences of positions, where the robot file states none


def quantized(values: Floats, resolution: Floats | float) -> Floats:
    """Return values rounded to the nearest multiple of a resolution, or unchanged where that is 0."""
    coarse = np.where(np.asarray(resolution) > 0.0, resolution, 1.0)
    return np.where(np.asarray(resolution) > 0.0, np.round(values / coarse) * coarse, values)


class Sensing:
    """Readings of all joints: a function of true position and velocity, (joints,) each.

    Positions get the sensor's offset and noise and are then rounded to its resolution; velocities are differences of
    readings through a first-order low-pass.
    """

    def __init__(self, robot: Robot, seed: int, step: float) -> None:
        sensors = [joint.position_sensor for joint in robot.table.joint]
        self.noise = np.array([sensor.noise for sensor in sensors])
        self.offset = np.array([sensor.offset for sensor in sensors])
        self.resolution = np.array([sensor.resolution for sensor in sensors])
        bandwidth = np.array([sensor.velocity_bandwidth or USUAL_BANDWIDTH for sensor in sensors])
        self.share, self.step = -np.expm1(-2.0 * np.pi * bandwidth * step), step
        self.rng = np.random.default_rng([seed, 41])
        self.last: Floats | None = None
        self.velocity = np.zeros(len(sensors))

    def __call__(self, position: Floats, velocity: Floats) -> tuple[Floats, Floats]:
        """Return the next readings of position and velocity."""
        read = position + self.offset + self.noise * self.rng.standard_normal(position.size)
        read = quantized(read, self.resolution)
        if self.last is None:
            self.velocity = velocity.copy()
        else:
            self.velocity = self.velocity + self.share * ((read - self.last) / self.step - self.velocity)
        self.last = read
        return read, self.velocity


class ValveSensing:
    """Readings for the controller of a valve, which gets position and pressures as the sensors report them."""

    def __init__(
        self,
        sensor: PositionSensor,
        of: Hydraulics,
        seed: Sequence[int],
        voltage: Callable[[int, float, float, float], float],
    ) -> None:
        self.noise = np.array([sensor.noise, of.pressure_noise, of.pressure_noise])
        self.resolution = np.array([sensor.resolution, of.pressure_resolution, of.pressure_resolution])
        self.offset = np.array([sensor.offset, 0.0, 0.0])
        self.rng, self.voltage = np.random.default_rng([*seed, 43]), voltage

    def __call__(self, k: int, *true: float) -> float:
        """Return the voltage that the controller demands at step ``k``, V."""
        read = np.array(true) + self.offset + self.noise * self.rng.standard_normal(3)
        position, head, rod = quantized(read, self.resolution).tolist()
        return self.voltage(k, position, head, rod)
