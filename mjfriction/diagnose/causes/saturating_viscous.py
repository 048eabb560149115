"""friction.viscous_nonlinear: damping that levels off with speed, as grease thins."""

from __future__ import annotations

from typing import ClassVar, final

import numpy as np

from mjfriction.diagnose.causes.cause import JointCause, Quantity, Site, column
from mjfriction.identify.gap import Gap
from mjfriction.laws.saturating_viscous import SATURATING_VISCOUS
from mjfriction.parameter import Parameter
from mjfriction.record.log import Floats
from mjfriction.robot.friction import with_term
from mjfriction.robot.robot import Robot

# Range of the half velocity, as fractions of the top speed: a slower one is like a level, a faster one bends the curve
# as a quadratic term does.
HALF_VELOCITIES = (0.2, 1.5)
OFF_EDGE = 1.1
EXPONENTS = (0.4, 1.0, 3.0)  # a gentle bend, as of a root of speed; the usual one; and that of a hyperbolic tangent
EXPONENT_RANGE = (0.3, 8.0)
SLOWEST = 0.02  # the same as the first of HALF_VELOCITIES where levels are held: then what levels off early is no level
DOUBTED = 4.0  # least half velocity, in multiples of the speed below which the direction of friction is in doubt


class SaturatingViscous(JointCause):
    """F_v·v/(1 + |v|/v_h) with F_v ≥ 0."""

    name = "friction.viscous_nonlinear"
    shape_parameters: ClassVar[tuple[Parameter, ...]] = (SATURATING_VISCOUS.parameter("half_velocity"),)

    def sites(self, gap: Gap) -> list[Site]:
        """Every examined joint, with half velocities spaced logarithmically over what its motion can show."""
        out = []
        for site in super().sites(gap):
            slow, fast = self.shape_bounds(gap, site)[0]
            if fast > 1.5 * slow:
                out += [site.shaped((float(v),)) for v in np.geomspace(slow, fast, 5)]
        return out

    def shape_bounds(self, gap: Gap, site: Site) -> list[tuple[float, float]]:
        """The half velocities at which damping can be told from a level and from a quadratic term."""
        top = float(gap.motion.top_speed[site.joint])
        slow, fast = (share * top for share in HALF_VELOCITIES)
        return [(max(slow, DOUBTED * float(gap.doubt_speed[site.joint])), fast)]

    def own_shape(self, gap: Gap, site: Site) -> bool:
        """A half velocity above the lower bound: what levels off there is a level that rises from rest, not damping."""
        return bool(site.shape[0] > OFF_EDGE * self.shape_bounds(gap, site)[0][0])

    def curve(self, site: Site) -> tuple[float, float]:
        """Return the half velocity v_h and the exponent n."""
        return site.shape[0], 1.0

    def samples(self, gap: Gap, site: Site) -> Floats:
        """The direction of motion times |v|/(1 + (|v|/v_h)^n)^(1/n), (n, 1)."""
        speed, (half, exponent) = np.abs(gap.motion.velocity[:, site.joint]), self.curve(site)
        levelling = (1.0 + (speed / half) ** exponent) ** (-1.0 / exponent)
        return column(gap.forward(site.joint) * speed * levelling)

    def quantities(self, gap: Gap, site: Site) -> tuple[Quantity, ...]:
        """The damping near rest."""
        return (Quantity(SATURATING_VISCOUS.parameter("viscous")),)

    def admissible(self, gap: Gap, site: Site, strengths: Floats) -> bool:
        """Damping that levels off still opposes the motion."""
        return bool(strengths[0] > 0.0)

    def extend(self, robot: Robot, site: Site, strengths: Floats) -> Robot:
        """Add a law that holds only the damping that levels off."""
        half, exponent = self.curve(site)
        parameters = {"viscous": float(strengths[0]), "half_velocity": half, "saturation_exponent": exponent}
        return with_term(robot, robot.joints[site.joint], SATURATING_VISCOUS.name, {"coulomb": 0.0, **parameters})

    def evidence(self, gap: Gap, site: Site, strengths: Floats) -> str:
        """Say at which speed the damping has halved and where it levels off."""
        sliding = gap.body.sliding[site.joint]
        return (
            f"friction grows more slowly than speed: part of the damping has halved at {site.shape[0]:.3g} "
            f"{'m/s' if sliding else 'rad/s'}, and levels off at {strengths[0] * site.shape[0]:.3g} "
            f"{'N' if sliding else 'N·m'}"
        )


@final
class AbruptlySaturating(SaturatingViscous):
    """F_v·v/(1 + (|v|/v_h)^n)^(1/n) with F_v ≥ 0.

    Beside refitted levels the exponent n cannot be identified, because a level makes up for how abruptly damping levels
    off. With the levels as stated, it may explain by how much these seem to be off.
    """

    shape_parameters = tuple(SATURATING_VISCOUS.parameter(name) for name in ("half_velocity", "saturation_exponent"))

    def sites(self, gap: Gap) -> list[Site]:
        """Every examined joint, with half velocities spaced logarithmically, at three exponents."""
        out = []
        for site in JointCause.sites(self, gap):
            slow, fast = self.shape_bounds(gap, site)[0]
            if fast > 1.5 * slow:
                out += [site.shaped((float(v), n)) for n in EXPONENTS for v in np.geomspace(slow, fast, 8)]
        return out

    def shape_bounds(self, gap: Gap, site: Site) -> list[tuple[float, float]]:
        """From where the direction of friction is known to where the curve is hardly bent; the exponents."""
        slow, fast = (share * float(gap.motion.top_speed[site.joint]) for share in (SLOWEST, HALF_VELOCITIES[1]))
        return [(max(slow, float(gap.doubt_speed[site.joint])), fast), EXPONENT_RANGE]

    def own_shape(self, gap: Gap, site: Site) -> bool:
        """Every shape belongs: beside levels as stated there is nothing else that it could be."""
        return True

    def curve(self, site: Site) -> tuple[float, float]:
        """The shape."""
        half, exponent = site.shape
        return half, exponent

    def evidence(self, gap: Gap, site: Site, strengths: Floats) -> str:
        """Say where the ceiling is, and at which speed the line near rest would meet it."""
        sliding = gap.body.sliding[site.joint]
        force, length = ("N", "m/s") if sliding else ("N·m", "rad/s")
        speed, ceiling = site.shape[0], float(strengths[0]) * site.shape[0]
        return (
            f"friction grows more slowly than speed: part of it levels off at {ceiling:.3g} {force}, which it would "
            f"pass at {speed:.3g} {length}"
        )
