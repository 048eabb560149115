"""Bodies, gravity and springs that differ from what is stated."""

from __future__ import annotations

import numpy as np

from mjfriction.benchmark.effects.effect import Effect, Place, on_joint, updated
from mjfriction.body.regressor import tip_link
from mjfriction.robot.body_tables import Payload
from mjfriction.robot.links import scaled_link
from mjfriction.robot.robot import Robot
from mjfriction.robot.schema import Spring


def payload(rng: np.random.Generator, place: Place) -> Effect:
    """A mass at the flange."""
    com = tuple(float(x) for x in rng.uniform([-0.06, -0.06, 0.0], [0.06, 0.06, 0.12]))
    parent = tip_link(place.robot.body())

    def change(robot: Robot, a: float) -> Robot:
        held = Payload(mass=a, com=com, parent=parent)
        return Robot(robot.table.model_copy(update={"payload": held}), robot.folder)

    return Effect("body.payload", None, change, 0.5, 8.0, {})


def link_inertia(rng: np.random.Generator, place: Place) -> Effect:
    """A link that is heavier or lighter than stated."""
    way = 1.0 if rng.random() < 0.6 else -0.7

    def change(robot: Robot, a: float) -> Robot:
        return scaled_link(robot, place.joint, max(0.2, 1.0 + way * a))

    return Effect("body.link_inertia", None, change, 0.3, 1.5, {}, of_stated=abs(way))


def gravity_direction(rng: np.random.Generator, place: Place) -> Effect:
    """A tilted base."""
    turn = rng.uniform(0.0, 2.0 * np.pi)
    stated = place.robot.body().gravity
    size = float(np.linalg.norm(stated))

    def change(robot: Robot, a: float) -> Robot:
        gravity = (size * np.sin(a) * np.cos(turn), size * np.sin(a) * np.sin(turn), -size * np.cos(a))
        return Robot(robot.table.model_copy(update={"gravity": tuple(map(float, gravity))}), robot.folder)

    return Effect("body.gravity_direction", None, change, 0.04, 0.4, {})


def spring(rng: np.random.Generator, place: Place) -> Effect:
    """A balancer, hose or cable."""
    rest = place.centre + place.stroke * rng.uniform(-0.4, 0.4)

    def change(robot: Robot, a: float) -> Robot:
        stiffness = a * place.coulomb / place.stroke
        return updated(robot, place.joint, spring=Spring(stiffness=stiffness, preload=-stiffness * rest))

    return on_joint("body.spring", place, change, 0.5, 10.0)
