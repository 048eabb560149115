"""friction.position at one place of the stroke: a worn tooth, a dent in a rail, a bearing that grinds there."""

from __future__ import annotations

from typing import final

from mjfriction.diagnose.causes.cause import Site
from mjfriction.diagnose.causes.friction_at_place import FrictionAtPlace
from mjfriction.diagnose.causes.waves import PositionFriction
from mjfriction.identify.gap import Gap
from mjfriction.parameter import Parameter
from mjfriction.record.log import Floats
from mjfriction.robot.friction import with_friction_spot
from mjfriction.robot.robot import Robot
from mjfriction.robot.spots import spots_along
from mjfriction.robot.table import Spot

CENTRE = Parameter("position", "{length}", "what the sensor reads where friction is another")
WIDTH = Parameter("width", "{length}", "how far from there the change has fallen to three fifths", lower=1e-9)
NARROWEST, WIDEST = 0.02, 0.2  # range of the width, as fractions of the stroke; a wider spot is almost a level


@final
class FrictionSpot(FrictionAtPlace):
    """C·exp(−½((q − position)/width)²)·sgn v."""

    shape_parameters = (CENTRE, WIDTH)
    first_order = PositionFriction.times  # counted apart from waves
    widths = (0.03, 0.06, 0.12, 0.18)
    width_range = (NARROWEST, WIDEST)

    def height(self, position: Floats, site: Site) -> Floats:
        """The spot, 1 high."""
        centre, width = site.shape
        return spots_along([Spot(position=centre, width=width, coulomb=1.0)], position)

    def spacing(self, width: float) -> float:
        """The width."""
        return width

    def extend(self, robot: Robot, site: Site, strengths: Floats) -> Robot:
        """Add a spot to the joint's friction level, at the joint's position rather than the sensor's reading."""
        name = robot.joints[site.joint]
        offset = robot.joint(name).position_sensor.offset
        spot = Spot(position=site.shape[0] - offset, width=site.shape[1], coulomb=float(strengths[0]))
        return with_friction_spot(robot, name, spot)

    def evidence(self, gap: Gap, site: Site, strengths: Floats) -> str:
        """Give the spot's position and size."""
        force, length = ("N", "m") if gap.body.sliding[site.joint] else ("N·m", "rad")
        more = "higher" if strengths[0] > 0.0 else "lower"
        return (
            f"within {2.0 * site.shape[1]:.2g} {length} of {site.shape[0]:.4g} {length} the friction level is up to "
            f"{abs(strengths[0]):.3g} {force} {more}, against the motion in both directions"
        )
