"""friction.load: the Coulomb level grows with the transmitted load."""

from __future__ import annotations

from typing import final

import numpy as np

from mjfriction.diagnose.causes.cause import JointCause, Quantity, Site, column
from mjfriction.identify.gap import Gap
from mjfriction.laws.load_dependent import LOAD_DEPENDENT
from mjfriction.record.log import Floats
from mjfriction.robot.friction import stated_load, with_term
from mjfriction.robot.robot import Robot


@final
class Load(JointCause):
    """μ·|τ_load|·sgn v, the load being what links, gravity and rotor need."""

    name = "friction.load"
    covariate = "load"

    def samples(self, gap: Gap, site: Site) -> Floats:
        """The size of the load in the direction of motion, (n, 1)."""
        return column(gap.forward(site.joint) * np.abs(gap.known.effort.rigid[:, site.joint]))

    def quantities(self, gap: Gap, site: Site) -> tuple[Quantity, ...]:
        """The coefficient, stated plus change."""
        return (Quantity(LOAD_DEPENDENT.parameter("load"), shift=stated_load(gap.robot.table.joint[site.joint])),)

    def admissible(self, gap: Gap, site: Site, strengths: Floats) -> bool:
        """Load presses gears together; it never lowers their friction below what is stated without it."""
        return bool(stated_load(gap.robot.table.joint[site.joint]) + strengths[0] > 0.0)

    def extend(self, robot: Robot, site: Site, strengths: Floats) -> Robot:
        """Add a law that holds only the load's part, or move the one there is."""
        joint = robot.joints[site.joint]
        return with_term(
            robot, joint, LOAD_DEPENDENT.name, {"coulomb": 0.0, "load": float(strengths[0]), "viscous": 0.0}
        )

    def evidence(self, gap: Gap, site: Site, strengths: Floats) -> str:
        """Say what the load adds between light and heavy."""
        unit = "N" if gap.body.sliding[site.joint] else "N·m"
        light, heavy = np.quantile(np.abs(gap.known.effort.rigid[:, site.joint]), [0.05, 0.95])
        return (
            f"friction rises by {strengths[0] * (heavy - light):.3g} {unit} as the load goes from {light:.3g} to "
            f"{heavy:.3g} {unit}, in both directions of motion"
        )
