"""Drives of a machine with cylinders: oil pushes its hydraulic joints, motors push the others."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from mjfriction.body.inverse import inverse_dynamics
from mjfriction.control.course import Course
from mjfriction.control.sensing import ValveSensing
from mjfriction.control.servo import Control, ServoDrives
from mjfriction.control.valve import valve_drive
from mjfriction.laws.law import Floats
from mjfriction.plant.cylinder import Cylinder, speed_per_volt
from mjfriction.plant.trajectory import Trajectory
from mjfriction.plant.varying import Surrounding
from mjfriction.record.log import SUPPLY_PRESSURE, VOLTAGE
from mjfriction.robot.robot import Robot
from mjfriction.robot.schema import Hydraulics

Voltage = Callable[[int, float, float, float], float]
"""(step, position, pressure of the head's chamber, of the rod's) → volts at the valve."""


class OilDrives:
    """Drives of a robot with cylinders, besides those of ``servo``: a function of the step, position and velocity.

    ``cylinders`` are by the names of their joints; their pressures are written into the surroundings of the friction
    laws.
    """

    def __init__(
        self,
        robot: Robot,
        model: Robot,
        servo: ServoDrives,
        control: Control,
        trajectory: Trajectory,
        time: Floats,
        surrounding: Surrounding,
    ) -> None:
        self.servo, self.surrounding = servo, surrounding
        course = servo.course
        start = course.position[:1]
        loads = inverse_dynamics(robot.body(), start, 0.0 * start, 0.0 * start)[0]
        self.at: list[tuple[int, Cylinder]] = []
        for i, joint in enumerate(robot.table.joint):
            of = joint.hydraulics
            if of is None:
                continue
            voltage = _given(trajectory, joint.name, time)
            if voltage is None and control.valve is not None:
                voltage = valve_drive(model, i, control.valve, course, servo.step, servo.estimates[:, i])
            voltage = voltage or _at_its_speed(of, course, i, control.bandwidth)
            if control.sensed:
                voltage = ValveSensing(joint.position_sensor, of, (control.seed, i), voltage)
            supply = _supply(trajectory, of, time)
            self.at.append((i, Cylinder(of, voltage, supply, servo.step, float(start[0, i]), float(loads[i]))))
        self.cylinders = {robot.joints[i]: cylinder for i, cylinder in self.at}

    def __call__(self, k: int, position: Floats, velocity: Floats) -> Floats:
        """Return the drive torques on the joints through step ``k``, (joints,), N·m or N."""
        torque = self.servo(k, position, velocity).copy()
        for i, cylinder in self.at:
            torque[i] = cylinder.force(k, float(position[i]), float(velocity[i]))
            self.surrounding.pressure_head[k, i] = cylinder.p1[k]
            self.surrounding.pressure_rod[k, i] = cylinder.p2[k]
        return torque


def _supply(trajectory: Trajectory, of: Hydraulics, time: Floats) -> Floats:
    given = trajectory.ambient.get(SUPPLY_PRESSURE)
    return np.full(time.size, of.supply_pressure) if given is None else np.interp(time, trajectory.time, given)


def _given(trajectory: Trajectory, joint: str, time: Floats) -> Voltage | None:
    column = None if joint in trajectory.joints else trajectory.ambient.get(f"{VOLTAGE}.{joint}")
    if column is None:
        return None
    volts = np.interp(time, trajectory.time, column)
    return lambda k, *_: float(volts[k])


def _at_its_speed(of: Hydraulics, course: Course, joint: int, bandwidth: float) -> Voltage:
    # Ask the valve for the wanted speed as if the piston had no load, plus a speed proportional to the position error.
    out, back = speed_per_volt(of)
    place, speed, gain = course.position[:, joint], course.velocity[:, joint], 2.0 * np.pi * bandwidth

    def voltage(k: int, position: float, *_: float) -> float:
        wanted = float(speed[k] + gain * (place[k] - position))
        return wanted / (out if wanted > 0.0 else back)

    return voltage
