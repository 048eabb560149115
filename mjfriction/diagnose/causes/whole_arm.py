"""Causes that all joints feel in one consistent way: a mass at the flange (body.payload), a tilted base
(body.gravity_direction).
"""

from __future__ import annotations

from abc import abstractmethod
from typing import final

import numpy as np

from mjfriction.body.model import Body
from mjfriction.body.regressor import gravity_torques, tip_link, tip_mass_torques
from mjfriction.diagnose.causes.cause import Cause, Quantity, Site
from mjfriction.identify.gap import Gap
from mjfriction.identify.regression import Columns
from mjfriction.parameter import Parameter
from mjfriction.record.log import Floats
from mjfriction.robot.robot import Robot
from mjfriction.robot.schema import Payload as PayloadTable

FARTHEST = 1.0  # m; a payload's centre lies nearer to the flange
STEEPEST = 0.7  # of gravity, across its stated direction


class _WholeArm(Cause):
    """A change that enters every joint; its site is the joint where it shows most."""

    whole_arm = True
    of_body = True
    covariate = "position"
    curved = True

    @abstractmethod
    def torques(self, gap: Gap) -> Floats:
        """Return effort per unit strength at every joint, (n, joints, strengths)."""

    def columns(self, gap: Gap, site: Site) -> Columns:
        """The effort at every examined joint, through the chain."""

        def made() -> Columns:
            torques = self.torques(gap)
            return {joint: gap.reported(joint, torques[:, joint]) for joint in gap.examined}

        return gap.kept.recall(self.name, made)

    def felt_most(self, gap: Gap) -> list[Site]:
        """Return the site at the joint whose effort the cause moves most, relative to its noise."""
        columns = self.columns(gap, Site(0))
        felt = {
            joint: float(np.mean(np.square(values))) / max(float(gap.noise_floor[joint]), 1e-12) ** 2
            for joint, values in columns.items()
        }
        most = max(felt, key=lambda joint: felt[joint])
        return [Site(most)] if felt[most] > 0.0 else []


@final
class Payload(_WholeArm):
    """A mass at the flange: m and its first moment m·c."""

    name = "body.payload"

    def sites(self, gap: Gap) -> list[Site]:
        """The whole arm, unless a payload is stated on another link already."""
        stated, body = gap.robot.table.payload, gap.body
        elsewhere = stated is not None and body.link_holding(stated.parent) != body.link_holding(tip_link(body))
        return [] if elsewhere else self.felt_most(gap)

    def torques(self, gap: Gap) -> Floats:
        """Torques per mass and first moment."""
        motion = gap.motion
        return tip_mass_torques(gap.body, motion.position, motion.velocity, motion.acceleration)

    def quantities(self, gap: Gap, site: Site) -> tuple[Quantity, ...]:
        """Mass and first moments, stated plus change."""
        mass, moment = _stated(gap.robot, gap.body)
        first = Parameter("mass", "kg", "mass held at the flange", lower=0.0)
        rest = [Parameter(f"moment_{axis}", "kg·m", f"its first moment along {axis} of the flange") for axis in "xyz"]
        shifts = [mass, *moment]
        return tuple(Quantity(parameter, shift=shift) for parameter, shift in zip([first, *rest], shifts, strict=True))

    def admissible(self, gap: Gap, site: Site, strengths: Floats) -> bool:
        """A payload has mass, and its centre near the flange."""
        mass, moment = _stated(gap.robot, gap.body)
        total = mass + strengths[0]
        return bool(total > 0.0 and np.linalg.norm(moment + strengths[1:]) < FARTHEST * total)

    def extend(self, robot: Robot, site: Site, strengths: Floats) -> Robot:
        """Put the payload into the robot, or change the one that is there."""
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
class GravityDirection(_WholeArm):
    """Gravity across its stated direction: the base is tilted."""

    name = "body.gravity_direction"

    def sites(self, gap: Gap) -> list[Site]:
        """The whole arm."""
        return self.felt_most(gap)

    def torques(self, gap: Gap) -> Floats:
        """Torques per m/s² along the two directions across gravity."""
        return gravity_torques(gap.body, gap.motion.position, _across(gap.body.gravity))

    def quantities(self, gap: Gap, site: Site) -> tuple[Quantity, ...]:
        """Gravity along the two directions, in which none is stated."""
        words = [", ".join(f"{part:.3g}" for part in direction) for direction in _across(gap.body.gravity)]
        return tuple(
            Quantity(Parameter(f"gravity_across_{i}", "m/s²", f"gravity along ({word}) of the base"))
            for i, word in enumerate(words, start=1)
        )

    def admissible(self, gap: Gap, site: Site, strengths: Floats) -> bool:
        """Past some forty degrees it is another mounting, not a tilt."""
        return bool(np.linalg.norm(strengths) < STEEPEST * np.linalg.norm(gap.body.gravity))

    def extend(self, robot: Robot, site: Site, strengths: Floats) -> Robot:
        """Turn the robot's gravity, keeping its size."""
        stated = np.asarray(robot.body().gravity)
        size = float(np.linalg.norm(stated))
        across = np.asarray(strengths @ _across(stated))
        along = float(np.sqrt(max(size**2 - float(np.sum(np.square(across))), 0.0))) / size
        gravity = tuple((along * stated + across).tolist())
        return Robot(robot.table.model_copy(update={"gravity": gravity}), robot.folder)

    def evidence(self, gap: Gap, site: Site, strengths: Floats) -> str:
        """Give the angle."""
        angle = np.degrees(np.arcsin(min(1.0, float(np.linalg.norm(strengths) / np.linalg.norm(gap.body.gravity)))))
        return f"all joints feel gravity {angle:.3g} degrees off its stated direction: the base is tilted"


def _stated(robot: Robot, body: Body) -> tuple[float, Floats]:
    # Mass and first moment about the tip link's frame.
    payload = robot.table.payload
    if payload is None:
        return 0.0, np.zeros(3)
    return payload.mass, payload.mass * body.on_link(payload.parent, np.array(payload.com), tip_link(body))


def _across(gravity: Floats) -> Floats:
    down = gravity / np.linalg.norm(gravity)
    seed = np.eye(3)[int(np.argmin(np.abs(down)))]
    first = seed - (seed @ down) * down
    first /= np.linalg.norm(first)
    return np.stack([first, np.cross(down, first)])
