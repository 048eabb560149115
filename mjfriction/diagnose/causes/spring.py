"""body.spring: a torque that goes with position, from a balancer, a hose or a cable."""

from __future__ import annotations

from typing import final

import numpy as np

from mjfriction.diagnose.causes.cause import JointCause, Quantity, Site
from mjfriction.identify.gap import Gap
from mjfriction.parameter import Parameter
from mjfriction.record.log import Floats
from mjfriction.robot.robot import Robot
from mjfriction.robot.schema import Spring as SpringTable

STIFFNESS = Parameter("stiffness", "{force}/{length}", "torque per position")
PRELOAD = Parameter("preload", "{force}", "torque at position zero")


@final
class Spring(JointCause):
    """k·q + b."""

    name = "body.spring"
    covariate = "position"
    contains = ("drive.offset",)

    def samples(self, gap: Gap, site: Site) -> Floats:
        """Position and one, (n, 2)."""
        position = gap.motion.position[:, site.joint]
        return np.column_stack([position, np.ones_like(position)])

    def quantities(self, gap: Gap, site: Site) -> tuple[Quantity, ...]:
        """Stiffness and preload, stated plus change."""
        stated = gap.robot.table.joint[site.joint].spring
        return (Quantity(STIFFNESS, shift=stated.stiffness), Quantity(PRELOAD, shift=stated.preload))

    def extend(self, robot: Robot, site: Site, strengths: Floats) -> Robot:
        """Add to the joint's spring."""
        joint = robot.joints[site.joint]
        table = robot.joint(joint)
        spring = SpringTable(
            stiffness=table.spring.stiffness + float(strengths[0]), preload=table.spring.preload + float(strengths[1])
        )
        return robot.with_joint(table.model_copy(update={"spring": spring}))

    def evidence(self, gap: Gap, site: Site, strengths: Floats) -> str:
        """Give the torque over the stroke that was travelled."""
        sliding = gap.body.sliding[site.joint]
        low, high = np.quantile(gap.motion.position[:, site.joint], [0.02, 0.98])
        ends = [strengths[1] + strengths[0] * end for end in (low, high)]
        force, length = ("N", "m") if sliding else ("N·m", "rad")
        return (
            f"a torque that follows position alone goes from {ends[0]:+.3g} to {ends[1]:+.3g} {force} between "
            f"{low:.3g} and {high:.3g} {length}, whichever way the joint moves"
        )
