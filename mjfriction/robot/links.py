"""Change a robot's links: their masses, inertias and centres of mass."""

from __future__ import annotations

from collections.abc import Sequence

from mjfriction.body.inertia import RigidLink, link_of, pseudo_inertias
from mjfriction.robot.body_tables import LinkInertia, no_body_has
from mjfriction.robot.robot import Robot

Shift = tuple[float, float, float]
UNMOVED: Shift = (0.0, 0.0, 0.0)


def link_scale(robot: Robot, link: str) -> float:
    """Return the stated factor on the mass and inertia of the link that a joint moves."""
    return robot.table.link_scale.get(link, 1.0)


def link_shift(robot: Robot, link: str) -> Shift:
    """Return the stated displacement (m) of a link's centre of mass."""
    return robot.table.link_shift.get(link, UNMOVED)


def scaled_link(robot: Robot, link: str, factor: float) -> Robot:
    """Return the robot with a link's mass and inertia multiplied, on top of what is stated."""
    scale = {**robot.table.link_scale, link: link_scale(robot, link) * factor}
    return Robot(robot.table.model_copy(update={"link_scale": scale}), robot.folder)


def shifted_link(robot: Robot, link: str, by: Sequence[float]) -> Robot:
    """Return the robot with a link's centre of mass moved by three lengths (m), on top of what is stated."""
    x, y, z = (float(a + b) for a, b in zip(link_shift(robot, link), by, strict=True))
    shift = {**robot.table.link_shift, link: (x, y, z)}
    return Robot(robot.table.model_copy(update={"link_shift": shift}), robot.folder)


def moments_of_a_body(robot: Robot, link: str) -> bool:
    """Return whether a body can have the stated moments of inertia of a link; rounded ones may be of none."""
    return not no_body_has(_as_stated(robot, link).inertia)


def with_moments(robot: Robot, link: str, factor: float) -> Robot:
    """Return the robot with a link's moments of inertia about its centre multiplied, and its mass kept.

    The link, without a payload, is then stated in full.
    """
    own, table = _as_stated(robot, link), robot.table
    xx, yy, zz, xy, xz, yz = (factor * value for value in own.inertia)
    stated = LinkInertia(mass=own.mass, com=own.com, inertia=(xx, yy, zz, xy, xz, yz))
    changed = {
        "link_inertia": {**table.link_inertia, link: stated},
        "link_scale": {name: value for name, value in table.link_scale.items() if name != link},
        "link_shift": {name: value for name, value in table.link_shift.items() if name != link},
    }
    return Robot(table.model_copy(update=changed), robot.folder)


def _as_stated(robot: Robot, link: str) -> RigidLink:
    body = Robot(robot.table.model_copy(update={"payload": None}), robot.folder).body()
    return link_of(pseudo_inertias(body.model)[body.links.index(link)])
