"""Masses that an arm picks up and puts down along a run."""

from __future__ import annotations

import numpy as np

from mjfriction.laws.law import Floats
from mjfriction.robot.links_torque import is_held
from mjfriction.robot.robot import Robot
from mjfriction.robot.simulation import taken_up_bodies


class HeldMasses:
    """The masses that a robot picks up, returned at each step where one of them changes."""

    def __init__(self, robot: Robot, time: Floats) -> None:
        self.masses = {
            name: load.mass * is_held(load.begin, load.end, time) for name, load in taken_up_bodies(robot).items()
        }
        changes = [np.flatnonzero(np.diff(mass)) + 1 for mass in self.masses.values()]
        self.steps = {0, *np.concatenate(changes).tolist()}

    def __call__(self, k: int) -> dict[str, float] | None:
        """Return the bodies' masses (kg) from step ``k`` on, None where they do not change."""
        return {name: float(mass[k]) for name, mass in self.masses.items()} if k in self.steps else None
