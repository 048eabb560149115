"""body.payload: a mass held at the flange throughout."""

from __future__ import annotations

from typing import final

import numpy as np

from mjfriction.body.model import Body
from mjfriction.body.regressor import tip_link, tip_mass, tip_mass_torques
from mjfriction.diagnose.causes.cause import Quantity, Site
from mjfriction.diagnose.causes.links import LEAST_ALONE, LEAST_MOVED, LEAST_MOVED_ALONE, LEAST_NOTED
from mjfriction.diagnose.causes.whole_arm import WholeArm
from mjfriction.identify.gap import Gap
from mjfriction.parameter import Parameter
from mjfriction.record.log import Floats
from mjfriction.robot.body_tables import Payload as PayloadTable
from mjfriction.robot.robot import Robot

FARTHEST = 1.0  # m; a payload's centre lies nearer to the flange
HELD = (
    Parameter("mass", "kg", "mass held at the flange", lower=0.0),
    *(Parameter(f"moment_{axis}", "kg·m", f"its first moment along {axis} of the flange") for axis in "xyz"),
)


@final
class Payload(WholeArm):
    """A mass at the flange: m and its first moment m·c."""

    name = "body.payload"

    def sites(self, gap: Gap) -> list[Site]:
        """The whole arm, unless a payload is already stated on another link."""
        return [] if held_elsewhere(gap) else self.felt_most(gap, Site(0))

    def torques(self, gap: Gap) -> Floats:
        """Torques per mass and first moment."""
        return torques_about(gap, None)

    def quantities(self, gap: Gap, site: Site) -> tuple[Quantity, ...]:
        """Mass and first moments, stated plus change."""
        mass, moment = stated_payload(gap.robot, gap.body)
        shifts = [mass, *moment]
        return tuple(Quantity(parameter, shift=shift) for parameter, shift in zip(HELD, shifts, strict=True))

    def admissible(self, gap: Gap, site: Site, strengths: Floats) -> bool:
        """A payload has mass, and its centre near the flange."""
        mass, moment = stated_payload(gap.robot, gap.body)
        total = mass + strengths[0]
        return bool(total > 0.0 and np.linalg.norm(moment + strengths[1:]) < FARTHEST * total)

    def noteworthy(self, gap: Gap, site: Site, strengths: Floats) -> bool:
        """More than the last link's own mass and centre are off where everything else is stated exactly."""
        mass, centre = tip_mass(gap.body)
        held, moment = stated_payload(gap.robot, gap.body)
        link = mass - held
        alone = (link, (mass * centre - moment) / link) if link > 0.0 else (mass, centre)
        return _beyond(alone, strengths, LEAST_ALONE, LEAST_MOVED_ALONE)

    def usual(self, gap: Gap, site: Site, strengths: Floats) -> bool:
        """No more than the mass and centre of the last link, with its stated payload, are usually off."""
        return not _beyond(tip_mass(gap.body), strengths, LEAST_NOTED, LEAST_MOVED)

    def extend(self, robot: Robot, site: Site, strengths: Floats) -> Robot:
        """State the payload, or change the stated one."""
        body = robot.body()
        mass, moment = stated_payload(robot, body)
        total = float(mass + strengths[0])
        com = (moment + strengths[1:]) / total
        payload = PayloadTable(mass=total, com=(float(com[0]), float(com[1]), float(com[2])), parent=tip_link(body))
        return Robot(robot.table.model_copy(update={"payload": payload}), robot.folder)

    def evidence(self, gap: Gap, site: Site, strengths: Floats) -> str:
        """Give mass and centre."""
        mass, moment = stated_payload(gap.robot, gap.body)
        total = mass + strengths[0]
        centre = ", ".join(f"{value:.3g}" for value in (moment + strengths[1:]) / total)
        return (
            f"all joints need what a mass of {total:.3g} kg at the flange needs, its centre at ({centre}) m of "
            f"{tip_link(gap.body)}, where {mass:.3g} kg are stated"
        )


def torques_about(gap: Gap, centre: Floats | None) -> Floats:
    """Return torques per mass and first moment of a load at the flange, (n, joints, 4), with the moments of inertia
    that it has at a ``centre`` (3,) from there, m, or at that of the last link if none is given.
    """
    motion = gap.motion
    return tip_mass_torques(gap.body, motion.position, motion.velocity, motion.acceleration, about=centre)


def held_elsewhere(gap: Gap) -> bool:
    """Return whether a payload is stated on another link than the last."""
    stated, body = gap.robot.table.payload, gap.body
    return stated is not None and body.link_holding(stated.parent) != body.link_holding(tip_link(body))


def _beyond(link: tuple[float, Floats], strengths: Floats, heavier: float, farther: float) -> bool:
    # Whether the load, added to a link (mass and centre), changes its mass by more than the share ``heavier``, or moves
    # its centre by more than ``farther`` m.
    mass, centre = link
    if mass + strengths[0] <= 0.0:
        return True
    moved = (mass * centre + strengths[1:]) / (mass + strengths[0]) - centre
    return bool(abs(strengths[0]) > heavier * mass or np.linalg.norm(moved) > farther)


def stated_payload(robot: Robot, body: Body) -> tuple[float, Floats]:
    """Return the stated payload's mass, kg, and its first moment about the tip link's frame (3,), kg·m."""
    payload = robot.table.payload
    if payload is None:
        return 0.0, np.zeros(3)
    return payload.mass, payload.mass * body.on_link(payload.parent, np.array(payload.com), tip_link(body))
