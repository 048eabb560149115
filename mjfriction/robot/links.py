"""Change a robot's links: their masses, inertias and centres of mass."""

from __future__ import annotations

from collections.abc import Sequence

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
