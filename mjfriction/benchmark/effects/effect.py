"""A hidden effect: it turns a robot into one with a property that its robot file does not state.

An effect is drawn at a place, with its shape.  Its strength is one number, which the case scales until the effect
stands out of the noise as much as requested.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from mjfriction.laws.law import Floats
from mjfriction.robot.friction import stated_levels
from mjfriction.robot.robot import Robot
from mjfriction.robot.schema import Joint
from mjfriction.robot.table import Wave

Change = Callable[[Robot, float], Robot]

OUTSIDE_NAME = "outside."  # prefix of the names of effects that match no cause of the table


@dataclass(frozen=True)
class Effect:
    """One hidden effect.

    ``cause`` is its name and ``joint`` its joint (None for the whole arm).  ``change`` applies it to a robot at a
    strength; ``begin`` is the first strength to try and ``most`` the largest allowed.  ``ambient`` are the columns that
    it adds to the log.  ``push`` (n,) is the push of an effect outside all causes on its joint, along the log's motion
    at strength 1.  ``of_stated`` is by how much strength 1 changes a value that robot files state, relative to it; 0
    where it adds something that they do not state.
    """

    cause: str
    joint: str | None
    change: Change
    begin: float
    most: float
    ambient: Mapping[str, Floats]
    push: Floats | None = None
    of_stated: float = 0.0


@dataclass(frozen=True)
class Place:
    """Where an effect is drawn: the robot, a joint of it, that joint's stroke, centre and usual speed, the time (n,)
    and the joint's ``course`` (n,).
    """

    robot: Robot
    joint: str
    centre: float
    stroke: float
    speed: float
    time: Floats
    course: Floats

    @property
    def coulomb(self) -> float:
        """The joint's Coulomb level."""
        return stated_levels(self.robot.joint(self.joint))[0]

    @property
    def viscous(self) -> float:
        """The joint's damping."""
        return stated_levels(self.robot.joint(self.joint))[1]


def on_joint(
    cause: str,
    place: Place,
    change: Change,
    begin: float,
    most: float,
    ambient: Mapping[str, Floats] | None = None,
    of_stated: float = 0.0,
) -> Effect:
    """Return an effect on the place's own joint."""
    return Effect(cause, place.joint, change, begin, most, ambient or {}, of_stated=of_stated)


def updated(robot: Robot, joint: str, **changes: object) -> Robot:
    """Return the robot with some keys of a joint's table replaced."""
    table: Joint = robot.joint(joint)
    return robot.with_joint(table.model_copy(update=changes))


def sign(rng: np.random.Generator) -> float:
    """Draw −1 or 1."""
    return float(rng.choice([-1.0, 1.0]))


def wave_along(rng: np.random.Generator, place: Place, most: float) -> Callable[[float], Wave]:
    """Draw a wave over the stroke, of up to ``most`` periods: a function of its amplitude per Coulomb level."""
    wavenumber = 2.0 * np.pi * rng.uniform(1.7, most) / place.stroke
    phase = rng.uniform(0.0, 2.0 * np.pi)

    def wave(a: float) -> Wave:
        level = a * place.coulomb
        return Wave(wavenumber=wavenumber, cosine=level * np.cos(phase), sine=level * np.sin(phase))

    return wave
