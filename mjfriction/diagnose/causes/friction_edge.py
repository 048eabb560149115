"""friction.position on one side of a place: the dry half of a screw, a rail that was lubricated in part only.

These causes do not compete: an edge rises in the place of waves and spots that only approximate it.
"""

from __future__ import annotations

from typing import ClassVar, Literal, final

from mjfriction.diagnose.causes.cause import Site
from mjfriction.diagnose.causes.friction_at_place import FrictionAtPlace
from mjfriction.identify.gap import Gap
from mjfriction.parameter import Parameter
from mjfriction.record.log import Floats
from mjfriction.robot.edges import edges_along
from mjfriction.robot.friction import with_friction_edge
from mjfriction.robot.robot import Robot
from mjfriction.robot.table import Edge

PLACE = Parameter("position", "{length}", "what the sensor reads where friction changes")
WIDTH = Parameter("width", "{length}", "how far on both sides of there two thirds of the change take place", lower=1e-9)
SHARPEST, WIDEST = 0.005, 0.2  # range of the width, as fractions of the stroke
SPACING = 0.04  # distance of the places that are tried, as a fraction of the stroke


class _FrictionEdge(FrictionAtPlace):
    """C·Φ(±(q − position)/width)·sgn v, with the normal distribution Φ."""

    shape_parameters = (PLACE, WIDTH)
    widths = (0.01, 0.04, 0.12)
    width_range = (SHARPEST, WIDEST)
    side: ClassVar[Literal["above", "below"]]

    def height(self, position: Floats, site: Site) -> Floats:
        """The edge, 1 high."""
        place, width = site.shape
        return edges_along([Edge(position=place, width=width, coulomb=1.0, side=self.side)], position)

    def spacing(self, width: float) -> float:
        """The same for all widths: a sharp edge shows far from its place."""
        return SPACING

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


@final
class FrictionAbove(_FrictionEdge):
    """An edge above which friction is another: C·Φ((q − position)/width)·sgn v."""

    side = "above"


@final
class FrictionBelow(_FrictionEdge):
    """An edge below which friction is another: C·Φ((position − q)/width)·sgn v."""

    side = "below"
