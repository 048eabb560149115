"""friction.position on one side of a place: the dry half of a screw, a rail that was lubricated in part only.

These causes do not compete: an edge rises in the place of waves and spots that only approximate it.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import ClassVar, Literal, final

import numpy as np

from mjfriction.diagnose.causes.cause import JointCause, Quantity, Site, column
from mjfriction.diagnose.causes.passed import passed_often
from mjfriction.diagnose.causes.waves import PositionFriction
from mjfriction.identify.gap import Gap
from mjfriction.identify.regression import Columns
from mjfriction.parameter import Parameter
from mjfriction.record.log import Floats
from mjfriction.robot.edges import edges_along
from mjfriction.robot.friction import with_friction_edge
from mjfriction.robot.robot import Robot
from mjfriction.robot.table import Edge

PLACE = Parameter("position", "{length}", "what the sensor reads where friction changes")
WIDTH = Parameter("width", "{length}", "how far on both sides of there two thirds of the change take place", lower=1e-9)
HEIGHT = Parameter("coulomb", "{force}", "how much higher the friction level is on that side")
WIDTHS = (0.01, 0.04, 0.12)  # widths to try, as fractions of the stroke
SHARPEST, WIDEST = 0.005, 0.2  # range of the width, as fractions of the stroke
STEPS = 24  # number of places along the stroke to try


class _FrictionEdge(JointCause):
    """C·Φ(±(q − position)/width)·sgn v, with the normal distribution Φ."""

    name = PositionFriction.name
    shape_parameters = (PLACE, WIDTH)
    relative_shape = False
    covariate = "position"
    picture = "turned"
    of_unevenness = True
    least_of_friction = PositionFriction.least_of_friction
    side: ClassVar[Literal["above", "below"]]

    def sites(self, gap: Gap) -> list[Site]:
        """Every examined joint, with edges of a few widths, where the joint passes often."""
        out = []
        for site in super().sites(gap):
            position = gap.motion.position[:, site.joint]
            places = np.linspace(np.min(position), np.max(position), STEPS + 2)[1:-1].tolist()
            widths = (np.ptp(position) * np.array(WIDTHS)).tolist()
            shaped = [Site(site.joint, (place, width)) for width in widths for place in places]
            out += [own for own in shaped if self.own_shape(gap, own)]
        return out

    def shape_bounds(self, gap: Gap, site: Site) -> list[tuple[float, float]]:
        """A place within the stroke, and a width that is a fraction of it."""
        position = gap.motion.position[:, site.joint]
        stroke = float(np.ptp(position))
        return [(float(np.min(position)), float(np.max(position))), (SHARPEST * stroke, WIDEST * stroke)]

    def shape_steps(self, gap: Gap, site: Site) -> tuple[float, ...]:
        """A third of the distance of the places that are tried, and of the width."""
        return (float(np.ptp(gap.motion.position[:, site.joint])) / (3.0 * STEPS), site.shape[1] / 3.0)

    def own_shape(self, gap: Gap, site: Site) -> bool:
        """An edge within its width of a place that the joint passes often."""
        return passed_often(gap, site)

    def apart(self, gap: Gap, site: Site, other: Site) -> bool:
        """An edge can be told from a wave, but not from another cause with as many shape parameters."""
        return len(other.shape) != len(site.shape)

    def samples(self, gap: Gap, site: Site) -> Floats:
        """The edge times the direction of motion, (n, 1)."""
        return column(self._height(gap.motion.position[:, site.joint], site) * gap.forward(site.joint))

    def screening(self, gap: Gap, sites: Sequence[Site], every: int) -> Columns:
        """The edges at the rows, without filtering."""
        joint = sites[0].joint
        position, forward = (gap.at_rows(name)[::every, joint] for name in ("position", "forward"))
        heights = [column(self._height(position, site) * forward) for site in sites]
        return {joint: np.stack(heights, axis=1)}

    def quantities(self, gap: Gap, site: Site) -> tuple[Quantity, ...]:
        """How much higher the level is."""
        return (Quantity(HEIGHT),)

    def extend(self, robot: Robot, site: Site, strengths: Floats) -> Robot:
        """Add an edge to the joint's friction level, at the joint's position rather than the sensor's reading."""
        name = robot.joints[site.joint]
        offset = robot.joint(name).position_sensor.offset
        place, width = site.shape
        edge = Edge(position=place - offset, width=width, coulomb=float(strengths[0]), side=self.side)
        return with_friction_edge(robot, name, edge)

    def evidence(self, gap: Gap, site: Site, strengths: Floats) -> str:
        """Give the place, and how much higher friction is on its side."""
        force, length = ("N", "m") if gap.body.sliding[site.joint] else ("N·m", "rad")
        more = "higher" if strengths[0] > 0.0 else "lower"
        return (
            f"{self.side} {site.shape[0]:.4g} {length} the friction level is {abs(strengths[0]):.3g} {force} {more}, "
            "against the motion in both directions"
        )

    def _height(self, position: Floats, site: Site) -> Floats:
        place, width = site.shape
        return edges_along([Edge(position=place, width=width, coulomb=1.0, side=self.side)], position)


@final
class FrictionAbove(_FrictionEdge):
    """An edge above which friction is another: C·Φ((q − position)/width)·sgn v."""

    side = "above"


@final
class FrictionBelow(_FrictionEdge):
    """An edge below which friction is another: C·Φ((position − q)/width)·sgn v."""

    side = "below"
