"""sensor.encoder_offset: the joint's zero is off."""

from __future__ import annotations

from typing import final

import numpy as np

from mjfriction.diagnose.causes.cause import Quantity, Site
from mjfriction.diagnose.causes.moved_link import MovedLink, changed
from mjfriction.identify.gap import Gap
from mjfriction.parameter import Parameter
from mjfriction.record.log import Floats
from mjfriction.robot.edges import edge_slopes_along
from mjfriction.robot.robot import Robot
from mjfriction.robot.rubbing import wave_slopes_along
from mjfriction.robot.spots import spot_slopes_along
from mjfriction.robot.spring import coefficients, spring_slope_along

OFFSET = Parameter("offset", "{length}", "what the sensor reads where the joint is at zero")
FARTHEST = 0.5  # rad or m, largest error of a zero


@final
class EncoderOffset(MovedLink):
    """The joint's zero is off: the sensor reads position + offset."""

    name = "sensor.encoder_offset"
    covariate = "position"
    curved = True
    of_body = True

    def shift(self, gap: Gap, site: Site) -> list[Floats]:
        """Ones, with zero derivatives."""
        one = np.ones_like(gap.motion.time)
        return [one, 0.0 * one, 0.0 * one]

    def _beside(self, gap: Gap, site: Site) -> Floats:
        # What is stated along the stroke shifts too.  The motor is taken to be where its link is.
        joint, position = gap.robot.table.joint[site.joint], gap.linked.position[:, site.joint]
        level = wave_slopes_along(joint.friction_waves, position)
        level += spot_slopes_along(joint.friction_spots, position) + edge_slopes_along(joint.friction_edges, position)
        springs = coefficients(joint.spring) + gap.body.spring[site.joint]
        along = spring_slope_along(springs, position) + wave_slopes_along(joint.cogging, position)
        return np.asarray(-along - gap.forward(site.joint) * level)

    def quantities(self, gap: Gap, site: Site) -> tuple[Quantity, ...]:
        """The offset, stated plus change."""
        return (Quantity(OFFSET, shift=gap.robot.table.joint[site.joint].position_sensor.offset),)

    def admissible(self, gap: Gap, site: Site, strengths: Floats) -> bool:
        """At most half a radian or metre either way."""
        return bool(abs(strengths[0]) < FARTHEST)

    def extend(self, robot: Robot, site: Site, strengths: Floats) -> Robot:
        """Change the sensor's offset."""
        sensor = robot.table.joint[site.joint].position_sensor
        moved = sensor.model_copy(update={"offset": sensor.offset + float(strengths[0])})
        return changed(robot, site, position_sensor=moved)

    def evidence(self, gap: Gap, site: Site, strengths: Floats) -> str:
        """Give the offset."""
        unit = "m" if gap.body.sliding[site.joint] else "rad"
        return (
            "gravity and inertia, as all joints feel them, are those of a pose in which the joint is "
            f"{-strengths[0]:+.4g} {unit} from where its sensor says"
        )
