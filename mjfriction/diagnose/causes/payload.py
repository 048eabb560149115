"""body.payload: a mass at the flange, throughout or in some of several logs only."""

from __future__ import annotations

import math
from typing import final

import numpy as np

from mjfriction.body.model import Body
from mjfriction.body.regressor import tip_link, tip_mass, tip_mass_torques
from mjfriction.diagnose.causes.cause import Quantity, Site
from mjfriction.diagnose.causes.links import LEAST_ALONE, LEAST_MOVED, LEAST_MOVED_ALONE, LEAST_NOTED
from mjfriction.diagnose.causes.whole_arm import WholeArm
from mjfriction.identify.gap import Gap
from mjfriction.identify.regression import Columns
from mjfriction.parameter import Parameter
from mjfriction.record.log import Floats
from mjfriction.robot.body_tables import Payload as PayloadTable
from mjfriction.robot.body_tables import TakenUp
from mjfriction.robot.links_torque import is_held
from mjfriction.robot.robot import Robot

FARTHEST = 1.0  # m; a payload's centre lies nearer to the flange
MOSTLY = 0.5  # fraction of the stated mass above which what is held counts as another payload, below as put down
NOTHING = 0.05  # fraction of the mass put down by which the remaining mass may be negative
HELD = (
    Parameter("mass", "kg", "mass held at the flange", lower=0.0),
    *(Parameter(f"moment_{axis}", "kg·m", f"its first moment along {axis} of the flange") for axis in "xyz"),
)
BESIDES = (
    Parameter("mass", "kg", "mass held at the flange beyond that in the other logs"),
    *(Parameter(f"moment_{axis}", "kg·m", f"first moment along {axis} of the flange beyond it") for axis in "xyz"),
)


@final
class Payload(WholeArm):
    """A mass at the flange: m and its first moment m·c."""

    name = "body.payload"

    def sites(self, gap: Gap) -> list[Site]:
        """The whole arm, unless a payload is already stated on another link."""
        return [] if _elsewhere(gap) else self.felt_most(gap, Site(0))

    def torques(self, gap: Gap) -> Floats:
        """Torques per mass and first moment."""
        motion = gap.motion
        return tip_mass_torques(gap.body, motion.position, motion.velocity, motion.acceleration)

    def quantities(self, gap: Gap, site: Site) -> tuple[Quantity, ...]:
        """Mass and first moments, stated plus change."""
        mass, moment = _stated(gap.robot, gap.body)
        shifts = [mass, *moment]
        return tuple(Quantity(parameter, shift=shift) for parameter, shift in zip(HELD, shifts, strict=True))

    def admissible(self, gap: Gap, site: Site, strengths: Floats) -> bool:
        """A payload has mass, and its centre near the flange."""
        mass, moment = _stated(gap.robot, gap.body)
        total = mass + strengths[0]
        return bool(total > 0.0 and np.linalg.norm(moment + strengths[1:]) < FARTHEST * total)

    def noteworthy(self, gap: Gap, site: Site, strengths: Floats) -> bool:
        """More than the last link's own mass and centre are off where everything else is stated exactly."""
        mass, centre = tip_mass(gap.body)
        held, moment = _stated(gap.robot, gap.body)
        link = mass - held
        alone = (link, (mass * centre - moment) / link) if link > 0.0 else (mass, centre)
        return _beyond(alone, strengths, LEAST_ALONE, LEAST_MOVED_ALONE)

    def usual(self, gap: Gap, site: Site, strengths: Floats) -> bool:
        """No more than the mass and centre of the last link, with its stated payload, are usually off."""
        return not _beyond(tip_mass(gap.body), strengths, LEAST_NOTED, LEAST_MOVED)

    def extend(self, robot: Robot, site: Site, strengths: Floats) -> Robot:
        """State the payload, or change the stated one."""
        body = robot.body()
        mass, moment = _stated(robot, body)
        total = float(mass + strengths[0])
        com = (moment + strengths[1:]) / total
        payload = PayloadTable(mass=total, com=(float(com[0]), float(com[1]), float(com[2])), parent=tip_link(body))
        return Robot(robot.table.model_copy(update={"payload": payload}), robot.folder)

    def evidence(self, gap: Gap, site: Site, strengths: Floats) -> str:
        """Give mass and centre."""
        mass, moment = _stated(gap.robot, gap.body)
        total = mass + strengths[0]
        centre = ", ".join(f"{value:.3g}" for value in (moment + strengths[1:]) / total)
        return (
            f"all joints need what a mass of {total:.3g} kg at the flange needs, its centre at ({centre}) m of "
            f"{tip_link(gap.body)}, where {mass:.3g} kg are stated"
        )


@final
class PayloadForAWhile(WholeArm):
    """A mass at the flange in some of several logs only, more or less than is stated: m and its first moment m·c."""

    name = "body.payload"
    covariate = "time"
    times = 2  # e.g. another payload in several logs, and yet another in one of them
    first_order = 1

    def sites(self, gap: Gap) -> list[Site]:
        """From each log on, up to each log, and in each log alone, unless a payload is stated on another link."""
        spans = [span for _, span in gap.log.logs]
        if len(spans) < 2 or _elsewhere(gap):
            return []
        first = spans[0][0]
        whiles = {(first, end) for _, end in spans} | {(begin, math.inf) for begin, _ in spans} | set(spans)
        whiles.remove((first, math.inf))
        return [own for begin, end in sorted(whiles) for own in self.felt_most(gap, Site(0, begin=begin, end=end))]

    def torques(self, gap: Gap) -> Floats:
        """Torques per mass and first moment, as if held throughout."""
        return Payload().torques(gap)

    def columns(self, gap: Gap, site: Site) -> Columns:
        """The effort in those logs only; no filter leaks from one log into the next."""
        held = is_held(site.begin, site.end, gap.chain.time)
        return {joint: values * held[:, None] for joint, values in super().columns(gap, site).items()}

    def quantities(self, gap: Gap, site: Site) -> tuple[Quantity, ...]:
        """Mass and first moments beyond those in the other logs."""
        return tuple(Quantity(parameter) for parameter in BESIDES)

    def admissible(self, gap: Gap, site: Site, strengths: Floats) -> bool:
        """The payload has mass, or nothing is left of the stated one, and its centre is near the flange."""
        mass, moment = _stated(gap.robot, gap.body)
        total, nothing = mass + strengths[0], NOTHING * abs(strengths[0])
        near = np.linalg.norm(moment + strengths[1:]) < FARTHEST * max(total, nothing)
        return bool(total >= -nothing and near)

    def noteworthy(self, gap: Gap, site: Site, strengths: Floats) -> bool:
        """As for a payload that is held throughout."""
        return Payload().noteworthy(gap, site, strengths)

    def extend(self, robot: Robot, site: Site, strengths: Floats) -> Robot:
        """Let the robot put down the stated payload in that interval and take up another, or add the change alone."""
        body = robot.body()
        mass, moment = _stated(robot, body)
        change, total = float(strengths[0]), mass + float(strengths[0])
        if mass > 0.0 and total > MOSTLY * mass:
            held = [(-mass, moment / mass), (total, (moment + strengths[1:]) / total)]
        else:  # nothing is stated, or too little of it is left to have a definite centre
            held = [(change, strengths[1:] / change)]
        loads = [
            TakenUp(
                mass=own,
                com=(float(centre[0]), float(centre[1]), float(centre[2])),
                parent=tip_link(body),
                begin=site.begin,
                end=None if math.isinf(site.end) else site.end,
            )
            for own, centre in held
        ]
        return Robot(robot.table.model_copy(update={"taken_up": (*robot.table.taken_up, *loads)}), robot.folder)

    def evidence(self, gap: Gap, site: Site, strengths: Floats) -> str:
        """Name the logs, and give what differs in them."""
        logs = " and ".join(name for name, begin in gap.log.joined if site.begin <= begin < site.end)
        moment = ", ".join(f"{value:+.3g}" for value in strengths[1:])
        return (
            f"in {logs} alone all joints need what {strengths[0]:+.3g} kg at the flange need besides, with a first "
            f"moment of ({moment}) kg·m about {tip_link(gap.body)}: what it held there is another payload"
        )


def _elsewhere(gap: Gap) -> bool:
    # Whether a payload is stated on another link than the last.
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


def _stated(robot: Robot, body: Body) -> tuple[float, Floats]:
    # Mass and first moment about the tip link's frame.
    payload = robot.table.payload
    if payload is None:
        return 0.0, np.zeros(3)
    return payload.mass, payload.mass * body.on_link(payload.parent, np.array(payload.com), tip_link(body))
