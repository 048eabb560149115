"""Friction that varies along a run: levels that change with time, and the surroundings that laws read."""

from __future__ import annotations

import numpy as np

from mjfriction.laws.ambient import ROOM_TEMPERATURE
from mjfriction.laws.coulomb_viscous import COULOMB_VISCOUS
from mjfriction.laws.friction import Friction
from mjfriction.laws.law import Floats
from mjfriction.laws.pressed_seals import PRESSED_SEALS
from mjfriction.plant.trajectory import Trajectory
from mjfriction.record.log import HEAD_PRESSURE, PUSH, ROD_PRESSURE, TEMPERATURE
from mjfriction.robot.friction import raised_levels, with_term
from mjfriction.robot.robot import Robot
from mjfriction.robot.rubbing import warmed
from mjfriction.robot.schema import Joint
from mjfriction.robot.simulation import robot_laws
from mjfriction.sim.closed_loop import Around

REFRESH = 0.1  # s between updates


def varies(joint: Joint) -> bool:
    """Return whether a joint's friction varies with running time, events or temperature."""
    return (
        joint.warm_up is not None
        or bool(joint.events)
        or any(joint.thermal.model_dump(exclude={"reference_temperature"}).values())
    )


def with_room_to_vary(robot: Robot) -> Robot:
    """Return the robot with room for varying levels: a Coulomb-viscous law of zero level where no law can take them.

    So every step has the same laws and only their levels differ.
    """
    for joint in filter(varies, robot.table.joint):
        raised = raised_levels(robot, joint.name, 1.0, 1.0).joint(joint.name)
        if len(raised.friction or ()) > len(joint.friction or ()):
            robot = with_term(robot, joint.name, COULOMB_VISCOUS.name, {"coulomb": 0.0, "viscous": 0.0})
    return robot


class Varying:
    """Friction laws whose levels change with temperature, running time and events, updated several times a second."""

    def __init__(self, robot: Robot, surrounding: Surrounding, time: Floats, step: float) -> None:
        self.robot, self.surrounding, self.time = robot, surrounding, time
        moments = [event.time for joint in robot.table.joint for event in joint.events]
        every = max(1, round(REFRESH / step))
        self.steps = {*range(0, time.size, every), *np.searchsorted(time, moments).tolist()}

    def __call__(self, k: int) -> dict[str, list[Friction]] | None:
        """Return the laws from step ``k`` on, None where they are not updated."""
        if k not in self.steps:
            return None
        robot = self.robot
        for i, joint in enumerate(self.robot.table.joint):
            if varies(joint):
                robot = raised_levels(robot, joint.name, *self._change(joint, k, self.surrounding.warmth[k, i]))
        return robot_laws(robot)

    def _change(self, joint: Joint, k: int, warmth: float) -> tuple[float, float]:
        now = self.time[k]
        change = np.zeros(2)
        if joint.warm_up is not None:
            share = float(warmed(np.array([now - joint.warm_up.begin]), joint.warm_up.time_constant)[0])
            change += share * np.array([joint.warm_up.coulomb, joint.warm_up.viscous])
        for event in joint.events:
            if now >= event.time:
                change += [event.coulomb, event.viscous]
        thermal = joint.thermal
        warmer = ROOM_TEMPERATURE + warmth - thermal.reference_temperature
        change += warmer * np.array([thermal.coulomb_per_kelvin, thermal.viscous_per_kelvin])
        return float(change[0]), float(change[1])


class Surrounding:
    """The surroundings of the joints along a trajectory: what laws read, and the external push.

    Cylinders write their own pressures into it.
    """

    def __init__(self, robot: Robot, trajectory: Trajectory, time: Floats) -> None:
        def along(quantity: str, otherwise: float) -> Floats:
            out = np.full((time.size, len(robot.joints)), otherwise)
            for i, name in enumerate(robot.joints):
                values = trajectory.ambient.get(f"{quantity}.{name}")
                if values is not None:
                    out[:, i] = np.interp(time, trajectory.time, values)
            return out

        self.warmth = along(TEMPERATURE, ROOM_TEMPERATURE) - ROOM_TEMPERATURE
        self.pressure_head = along(HEAD_PRESSURE, 0.0)
        self.pressure_rod = along(ROD_PRESSURE, 0.0)
        self.push = along(PUSH, 0.0)

    def __call__(self, k: int) -> Around:
        """Return the surroundings of the joints at step ``k``."""
        return Around(self.warmth[k], self.pressure_head[k], self.pressure_rod[k], self.push[k])


def with_pressed_seals(robot: Robot) -> Robot:
    """Return the robot with its pressure-dependent friction written as the law that reads chamber pressures."""
    for joint in robot.table.joint:
        pressed = joint.pressure_friction.model_dump()
        if any(pressed.values()):
            values = {"coulomb": 0.0, "viscous": 0.0, **pressed}
            robot = with_term(robot, joint.name, PRESSED_SEALS.name, values)
    return robot
