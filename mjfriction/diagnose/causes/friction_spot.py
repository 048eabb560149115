"""friction.position at one place of the stroke: a worn tooth, a dent in a rail, a bearing that grinds there."""

from __future__ import annotations

from collections.abc import Sequence
from typing import final

import numpy as np

from mjfriction.diagnose.causes.cause import JointCause, Quantity, Site, column
from mjfriction.diagnose.causes.passed import passed_often
from mjfriction.diagnose.causes.waves import PositionFriction
from mjfriction.identify.gap import Gap
from mjfriction.identify.regression import Columns
from mjfriction.parameter import Parameter
from mjfriction.record.log import Floats
from mjfriction.robot.friction import with_friction_spot
from mjfriction.robot.robot import Robot
from mjfriction.robot.spots import spots_along
from mjfriction.robot.table import Spot

CENTRE = Parameter("position", "{length}", "what the sensor reads where friction is another")
WIDTH = Parameter("width", "{length}", "how far from there the change has fallen to three fifths", lower=1e-9)
HEIGHT = Parameter("coulomb", "{force}", "how much higher the friction level is there")
WIDTHS = (0.03, 0.06, 0.12, 0.18)  # widths to try, as fractions of the stroke
NARROWEST, WIDEST = 0.02, 0.2  # range of the width, as fractions of the stroke; a wider spot is almost a level


@final
class FrictionSpot(JointCause):
    """C·exp(−½((q − position)/width)²)·sgn v."""

    name = PositionFriction.name
    shape_parameters = (CENTRE, WIDTH)
    relative_shape = False
    covariate = "position"
    picture = "turned"
    of_unevenness = True
    least_of_friction = PositionFriction.least_of_friction
    first_order = PositionFriction.times  # counted apart from waves

    def sites(self, gap: Gap) -> list[Site]:
        """Every examined joint, with spots of a few widths, spaced by their width, where the joint passes often."""
        out = []
        for site in super().sites(gap):
            position = gap.motion.position[:, site.joint]
            low, stroke = float(np.min(position)), float(np.ptp(position))
            for share in WIDTHS:
                width = share * stroke
                centres = np.arange(low, low + stroke + 0.5 * width, width).tolist()
                shaped = [Site(site.joint, (centre, width)) for centre in centres]
                out += [own for own in shaped if self.own_shape(gap, own)]
        return out

    def shape_bounds(self, gap: Gap, site: Site) -> list[tuple[float, float]]:
        """A centre within the stroke, and a width that is a fraction of it."""
        position = gap.motion.position[:, site.joint]
        stroke = float(np.ptp(position))
        return [(float(np.min(position)), float(np.max(position))), (NARROWEST * stroke, WIDEST * stroke)]

    def shape_steps(self, gap: Gap, site: Site) -> tuple[float, ...]:
        """A third of the width, for centre and width."""
        return (site.shape[1] / 3.0, site.shape[1] / 3.0)

    def own_shape(self, gap: Gap, site: Site) -> bool:
        """A spot whose centre is within its width of a place that the joint passes often."""
        return passed_often(gap, site)

    def apart(self, gap: Gap, site: Site, other: Site) -> bool:
        """A spot can be told from a wave, but not from another cause with as many shape parameters."""
        return len(other.shape) != len(site.shape)

    def samples(self, gap: Gap, site: Site) -> Floats:
        """The spot times the direction of motion, (n, 1)."""
        return column(_bump(gap.motion.position[:, site.joint], site) * gap.forward(site.joint))

    def screening(self, gap: Gap, sites: Sequence[Site], every: int) -> Columns:
        """The spots at the rows, without filtering.

        In the filtered rows, a spot that is passed in less than one row is really lower and wider.
        """
        joint = sites[0].joint
        position, forward = (gap.at_rows(name)[::every, joint] for name in ("position", "forward"))
        return {joint: np.stack([column(_bump(position, site) * forward) for site in sites], axis=1)}

    def quantities(self, gap: Gap, site: Site) -> tuple[Quantity, ...]:
        """How much higher the level is."""
        return (Quantity(HEIGHT),)

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


def _bump(position: Floats, site: Site) -> Floats:
    centre, width = site.shape
    return spots_along([Spot(position=centre, width=width, coulomb=1.0)], position)
