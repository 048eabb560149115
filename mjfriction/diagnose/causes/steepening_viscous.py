"""friction.viscous_nonlinear: friction that grows with a power of speed, higher than the square or below one."""

from __future__ import annotations

from typing import ClassVar, final

import numpy as np

from mjfriction.diagnose.causes.cause import JointCause, Quantity, Site, column
from mjfriction.identify.gap import Gap
from mjfriction.laws.power_viscous import POWER_VISCOUS
from mjfriction.record.log import Floats
from mjfriction.robot.friction import with_term
from mjfriction.robot.robot import Robot

POWERS = (2.2, 4.0)  # range of the power; below it a quadratic term does as well
GRID = (2.5, 3.0, 3.5)
# The same for powers below one; a lower one is like a level, a higher one like damping.
ROOTS, ROOT_GRID = (0.2, 0.9), (0.35, 0.5, 0.65)


class SteepeningViscous(JointCause):
    """F_p·|v|^n·sgn v with F_p > 0 and a power n above two."""

    name = "friction.viscous_nonlinear"
    shape_parameters = (POWER_VISCOUS.parameter("power"),)
    powers: ClassVar[tuple[float, float]] = POWERS
    grid: ClassVar[tuple[float, ...]] = GRID

    def sites(self, gap: Gap) -> list[Site]:
        """Every examined joint, with some powers."""
        return [site.shaped((power,)) for site in super().sites(gap) for power in self.grid]

    def shape_bounds(self, gap: Gap, site: Site) -> list[tuple[float, float]]:
        """The range of the power."""
        return [self.powers]

    def samples(self, gap: Gap, site: Site) -> Floats:
        """The power of speed times the direction of motion, (n, 1)."""
        speed = np.abs(gap.motion.velocity[:, site.joint])
        return column(gap.forward(site.joint) * speed ** site.shape[0])

    def quantities(self, gap: Gap, site: Site) -> tuple[Quantity, ...]:
        """The coefficient."""
        return (Quantity(POWER_VISCOUS.parameter("power_coefficient")),)

    def admissible(self, gap: Gap, site: Site, strengths: Floats) -> bool:
        """It opposes the motion."""
        return bool(strengths[0] > 0.0)

    def extend(self, robot: Robot, site: Site, strengths: Floats) -> Robot:
        """Add a law that holds only that power."""
        parameters = {"coulomb": 0.0, "power_coefficient": float(strengths[0]), "power": site.shape[0]}
        return with_term(robot, robot.joints[site.joint], POWER_VISCOUS.name, parameters)

    def evidence(self, gap: Gap, site: Site, strengths: Floats) -> str:
        """Give the power, and the friction that it adds at top speed."""
        speed, sliding = float(gap.motion.top_speed[site.joint]), gap.body.sliding[site.joint]
        return (
            f"friction grows with the power {site.shape[0]:.3g} of speed besides: at {speed:.3g} "
            f"{'m/s' if sliding else 'rad/s'} that makes {strengths[0] * speed ** site.shape[0]:+.3g} "
            f"{'N' if sliding else 'N·m'}"
        )


@final
class RootViscous(SteepeningViscous):
    """F_p·|v|^n·sgn v with F_p > 0 and a power n below one, as greases and harmonic drives have it.

    Beside refitted levels it cannot be identified, because level and damping make up for most of it.
    """

    powers, grid = ROOTS, ROOT_GRID
