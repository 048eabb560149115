"""friction.asymmetry: the speed-dependent part of friction differs between the directions."""

from __future__ import annotations

from typing import final

import numpy as np

from mjfriction.diagnose.causes.cause import JointCause, Quantity, Site, column
from mjfriction.identify.gap import Gap
from mjfriction.parameter import Parameter
from mjfriction.record.log import Floats
from mjfriction.robot.friction import with_asymmetric_damping
from mjfriction.robot.robot import Robot

ASYMMETRY = Parameter(
    "viscous_asymmetry", "{force}·s/{length}", "half the difference of the damping in the two directions"
)


@final
class Asymmetry(JointCause):
    """F_a·|v|: the damping is F_v + F_a forward and F_v − F_a backward.

    A difference of the Coulomb levels is a constant, the same change as ``drive.offset``, and is reported as that.
    """

    name = "friction.asymmetry"
    kin = ("drive.offset",)

    def samples(self, gap: Gap, site: Site) -> Floats:
        """The speed, (n, 1)."""
        return column(np.abs(gap.motion.velocity[:, site.joint]))

    def quantities(self, gap: Gap, site: Site) -> tuple[Quantity, ...]:
        """Half the difference of the two dampings."""
        return (Quantity(ASYMMETRY),)

    def extend(self, robot: Robot, site: Site, strengths: Floats) -> Robot:
        """Give each direction its own damping."""
        joint = robot.joints[site.joint]
        return with_asymmetric_damping(robot, joint, float(strengths[0]))

    def evidence(self, gap: Gap, site: Site, strengths: Floats) -> str:
        """Say in which direction the joint is damped more, and by how much at top speed."""
        speed = float(gap.motion.top_speed[site.joint])
        sliding = gap.body.sliding[site.joint]
        more = "positive" if strengths[0] > 0.0 else "negative"
        return (
            f"at {speed:.3g} {'m/s' if sliding else 'rad/s'} moving in the {more} direction costs "
            f"{2.0 * abs(strengths[0]) * speed:.3g} {'N' if sliding else 'N·m'} more than in the other, "
            "and the difference grows with speed"
        )
