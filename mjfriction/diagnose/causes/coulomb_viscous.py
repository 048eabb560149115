"""friction.coulomb_viscous: the stated Coulomb or viscous level is off."""

from __future__ import annotations

from typing import final

import numpy as np

from mjfriction.diagnose.causes.cause import JointCause, Quantity, Site
from mjfriction.identify.gap import Gap
from mjfriction.laws.coulomb_viscous import COULOMB_VISCOUS
from mjfriction.record.log import Floats
from mjfriction.robot.friction import raised_levels, stated_levels
from mjfriction.robot.robot import Robot


@final
class CoulombViscous(JointCause):
    """ΔF_c·sgn v + ΔF_v·v.

    The competition refits both levels of every joint in any case; whether they are off by enough to be a finding is
    judged at the end (:mod:`~mjfriction.diagnose.settle.stated`).
    """

    name = "friction.coulomb_viscous"

    def samples(self, gap: Gap, site: Site) -> Floats:
        """Direction and velocity, (n, 2)."""
        return np.column_stack([gap.forward(site.joint), gap.motion.velocity[:, site.joint]])

    def quantities(self, gap: Gap, site: Site) -> tuple[Quantity, ...]:
        """The levels themselves, stated plus change."""
        coulomb, viscous = stated_levels(gap.robot.table.joint[site.joint])
        return (
            Quantity(COULOMB_VISCOUS.parameter("coulomb"), shift=coulomb),
            Quantity(COULOMB_VISCOUS.parameter("viscous"), shift=viscous),
        )

    def extend(self, robot: Robot, site: Site, strengths: Floats) -> Robot:
        """Change the levels of the joint's friction."""
        joint = robot.joints[site.joint]
        return raised_levels(robot, joint, float(strengths[0]), float(strengths[1]))

    def evidence(self, gap: Gap, site: Site, strengths: Floats) -> str:
        """Compare friction at the joint's usual speed, stated and fitted."""
        speed = float(np.sqrt(np.mean(np.square(gap.motion.velocity[:, site.joint]))))
        coulomb, viscous = stated_levels(gap.robot.table.joint[site.joint])
        before = coulomb + viscous * speed
        after = before + float(strengths[0]) + float(strengths[1]) * speed
        unit = "N" if gap.body.sliding[site.joint] else "N·m"
        rate = "m/s" if gap.body.sliding[site.joint] else "rad/s"
        return f"at {speed:.3g} {rate}, friction is {after:.3g} {unit} where {before:.3g} {unit} is stated"
