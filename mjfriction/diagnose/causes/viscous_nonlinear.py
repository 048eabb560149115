"""friction.viscous_nonlinear: the viscous curve bends, by a quadratic term."""

from __future__ import annotations

from typing import final

import numpy as np

from mjfriction.diagnose.causes.cause import JointCause, Quantity, Site, column
from mjfriction.identify.gap import Gap
from mjfriction.laws.quadratic_viscous import QUADRATIC_VISCOUS
from mjfriction.record.log import Floats
from mjfriction.robot.friction import with_term
from mjfriction.robot.robot import Robot


@final
class ViscousNonlinear(JointCause):
    """F_q·v·|v|."""

    name = "friction.viscous_nonlinear"

    def samples(self, gap: Gap, site: Site) -> Floats:
        """The signed square of velocity, (n, 1)."""
        velocity = gap.motion.velocity[:, site.joint]
        return column(velocity * np.abs(velocity))

    def quantities(self, gap: Gap, site: Site) -> tuple[Quantity, ...]:
        """The quadratic coefficient."""
        return (Quantity(QUADRATIC_VISCOUS.parameter("quadratic")),)

    def extend(self, robot: Robot, site: Site, strengths: Floats) -> Robot:
        """Add a law that holds only the quadratic term."""
        joint = robot.joints[site.joint]
        parameters = {"coulomb": 0.0, "viscous": 0.0, "quadratic": float(strengths[0])}
        return with_term(robot, joint, QUADRATIC_VISCOUS.name, parameters)

    def evidence(self, gap: Gap, site: Site, strengths: Floats) -> str:
        """Say which way the damping bends and how much that is at top speed."""
        speed = float(gap.motion.top_speed[site.joint])
        sliding = gap.body.sliding[site.joint]
        bend = "grows faster" if strengths[0] > 0.0 else "grows more slowly"
        return (
            f"friction {bend} than speed: at {speed:.3g} {'m/s' if sliding else 'rad/s'} the bend makes "
            f"{strengths[0] * speed * speed:+.3g} {'N' if sliding else 'N·m'}"
        )
