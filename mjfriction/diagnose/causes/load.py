"""friction.load: the Coulomb level grows with the transmitted load."""

from __future__ import annotations

from typing import ClassVar, final

import numpy as np

from mjfriction.diagnose.causes.cause import SHIFTS, JointCause, Quantity, Site, column
from mjfriction.identify.gap import Gap
from mjfriction.laws.geared_load import GEARED_LOAD
from mjfriction.laws.load_dependent import LOAD_DEPENDENT
from mjfriction.record.log import Floats
from mjfriction.robot.friction import with_term
from mjfriction.robot.load_friction import stated_load, stated_loads, with_less_load, with_more_load
from mjfriction.robot.robot import Robot

BELOW = 0.1  # fraction of the larger coefficient by which the smaller one may be negative
LEAST_ROTOR = 0.05  # least rotor torque, as a fraction of the links' load, for the two kinds of load to differ


class _Load(JointCause):
    """μ·|τ_load|·sgn v."""

    name = "friction.load"
    covariate = "load"
    includes_rotor: ClassVar[bool]

    def load(self, gap: Gap, joint: int) -> Floats:
        """Return the load of a joint, (n,)."""
        effort = gap.known.effort
        return (effort.rigid if self.includes_rotor else effort.load)[:, joint]

    def samples(self, gap: Gap, site: Site) -> Floats:
        """The size of the load times the direction of motion, (n, 1)."""
        return column(gap.forward(site.joint) * np.abs(self.load(gap, site.joint)))

    def quantities(self, gap: Gap, site: Site) -> tuple[Quantity, ...]:
        """The coefficient, stated plus change."""
        return (Quantity(LOAD_DEPENDENT.parameter("load"), shift=self._stated(gap, site)),)

    def admissible(self, gap: Gap, site: Site, strengths: Floats) -> bool:
        """The total coefficient is positive: load presses gears together and never lowers their friction."""
        return bool(self._stated(gap, site) + strengths[0] > 0.0)

    def level_shifts(self, gap: Gap, site: Site, strengths: Floats) -> Floats:
        """At loads from zero to the largest in the log, by the mean of driving and braking."""
        most = float(np.max(np.abs(self.load(gap, site.joint))))
        return np.outer(np.linspace(0.0, most, SHIFTS), [float(np.mean(strengths)), 0.0])

    def _stated(self, gap: Gap, site: Site) -> float:
        return stated_load(gap.robot.table.joint[site.joint], includes_rotor=self.includes_rotor)

    def extend(self, robot: Robot, site: Site, strengths: Floats) -> Robot:
        """Add a law with the load-dependent part only or, where the change is negative, lower the stated laws."""
        parameters = {"coulomb": 0.0, "load": float(strengths[0]), "viscous": 0.0}
        joint = robot.joints[site.joint]
        if strengths[0] < 0.0:
            return with_less_load(robot, joint, -float(strengths[0]), includes_rotor=self.includes_rotor)
        return with_term(robot, joint, LOAD_DEPENDENT.name, parameters, load_includes_rotor=self.includes_rotor)

    def evidence(self, gap: Gap, site: Site, strengths: Floats) -> str:
        """Say how much friction rises from light to heavy load."""
        unit = "N" if gap.body.sliding[site.joint] else "N·m"
        light, heavy = np.quantile(np.abs(self.load(gap, site.joint)), [0.05, 0.95])
        return (
            f"friction rises by {strengths[0] * (heavy - light):.3g} {unit} as the load"
            f"{', its rotor included,' if self.includes_rotor else ''} goes from {light:.3g} to {heavy:.3g} {unit}, in "
            "both directions of motion"
        )


class _GearedLoad(_Load):
    """μ_d·|τ|·sgn v where the drive works against the load, τ·v > 0, and μ_b·|τ|·sgn v where the load drives it.

    The mean of the two acts like plain load friction.  Half of their difference is a factor on the load, as a torque
    constant would be that is off together with friction levels that are off in the opposite direction.
    """

    def samples(self, gap: Gap, site: Site) -> Floats:
        """The size of the load times the direction of motion, where it is driven and where it drives, (n, 2)."""
        forward, load = gap.forward(site.joint), self.load(gap, site.joint)
        driving = load * forward > 0.0
        whole = forward * np.abs(load)
        return np.column_stack([np.where(driving, whole, 0.0), np.where(driving, 0.0, whole)])

    def quantities(self, gap: Gap, site: Site) -> tuple[Quantity, ...]:
        """Both coefficients, stated plus change."""
        ways = zip(("driving", "braking"), self._both(gap, site), strict=True)
        return tuple(Quantity(GEARED_LOAD.parameter(f"load_{way}"), shift=stated) for way, stated in ways)

    def admissible(self, gap: Gap, site: Site, strengths: Floats) -> bool:
        """Neither total coefficient makes friction drive the joint, within :data:`BELOW`; the larger is positive."""
        less, more = np.sort(self._both(gap, site) + strengths)
        return bool(more > 0.0 and less > -BELOW * more)

    def extend(self, robot: Robot, site: Site, strengths: Floats) -> Robot:
        """Replace the stated load friction by a law with both coefficients."""
        joint, (driving, braking) = robot.joints[site.joint], strengths.tolist()
        return with_more_load(robot, joint, (driving, braking), includes_rotor=self.includes_rotor)

    def _both(self, gap: Gap, site: Site) -> Floats:
        return np.array(stated_loads(gap.robot.table.joint[site.joint], includes_rotor=self.includes_rotor))

    def evidence(self, gap: Gap, site: Site, strengths: Floats) -> str:
        """Say how much friction a heavy load adds, driven and driving."""
        unit = "N" if gap.body.sliding[site.joint] else "N·m"
        heavy = float(np.quantile(np.abs(self.load(gap, site.joint)), 0.95))
        driving, braking = (strengths * heavy).tolist()
        return (
            f"under a load of {heavy:.3g} {unit}{', its rotor included,' if self.includes_rotor else ''} friction "
            f"rises by {driving:.3g} {unit} where the drive works against it, and by {braking:.3g} {unit} where the "
            "load drives"
        )


@final
class GearedLoad(_GearedLoad):
    """Friction grows with the load that passes through the transmission to the links."""

    includes_rotor = False


@final
class GearedDriveLoad(_GearedLoad):
    """Friction grows with everything that the drive moves, its own rotor included."""

    includes_rotor = True


@final
class Load(_Load):
    """Friction grows with the load that passes through the transmission to the links."""

    includes_rotor = False
    geared = GearedLoad


@final
class DriveLoad(_Load):
    """Friction grows with everything that the drive moves, its own rotor included: not all contacts lie behind the
    rotor.
    """

    includes_rotor = True
    geared = GearedDriveLoad

    def sites(self, gap: Gap) -> list[Site]:
        """Every examined joint whose rotor takes enough torque for the two kinds of load to differ."""
        effort = gap.known.effort
        rotor, load = (np.sqrt(np.mean(np.square(own), axis=0)) for own in (effort.rotor, effort.load))
        return [site for site in super().sites(gap) if rotor[site.joint] > LEAST_ROTOR * load[site.joint]]
