"""drive.coupling: one joint's motion, friction or effort enters another's effort through the transmission."""

from __future__ import annotations

from typing import ClassVar, final

import numpy as np

from mjfriction.diagnose.causes.cause import JointCause, Quantity, Site, column
from mjfriction.identify.gap import Gap
from mjfriction.identify.regression import Columns
from mjfriction.parameter import Parameter
from mjfriction.record.log import Floats
from mjfriction.robot.effort import shared_effort
from mjfriction.robot.robot import Robot
from mjfriction.robot.rubbing import direction
from mjfriction.robot.schema import CommonDrive, Coupling

COULOMB = Parameter("coulomb", "{force}", "dry friction that the other joint's direction of motion brings")
VISCOUS = Parameter("viscous", "{force}·s/{length}", "damping that the other joint's velocity brings")
EFFORT = Parameter("effort", "1", "share of the other joint's effort")
MOST_SHARED = 0.9  # of another joint's effort


class _Coupling(JointCause):
    """Something of another joint; ``ratio`` is nothing here, or how the common drive turns with it."""

    name = "drive.coupling"
    ratio: ClassVar[float] = 0.0

    def sites(self, gap: Gap) -> list[Site]:
        """Every examined joint with every other that moves."""
        moving = [j for j in range(len(gap.robot.joints)) if gap.motion.moving[j]]
        return [Site(i, other=j) for i in gap.examined for j in moving if j != i]

    def source(self, gap: Gap, site: Site) -> int:
        """Return the other joint."""
        assert site.other is not None, "sites names another joint"
        return site.other

    def from_name(self, gap: Gap, site: Site) -> str:
        """Return the other joint's name."""
        return gap.robot.joints[self.source(gap, site)]


@final
class SharedFriction(_Coupling):
    """C·sgn vₖ + V·vₖ of the other joint k."""

    def samples(self, gap: Gap, site: Site) -> Floats:
        """Direction and velocity of the other joint, (n, 2)."""
        other = self.source(gap, site)
        return np.column_stack([gap.forward(other), gap.motion.velocity[:, other]])

    def quantities(self, gap: Gap, site: Site) -> tuple[Quantity, ...]:
        """Level and damping."""
        return (Quantity(COULOMB), Quantity(VISCOUS))

    def extend(self, robot: Robot, site: Site, strengths: Floats) -> Robot:
        """State the coupling."""
        return _coupled(robot, site, coulomb=float(strengths[0]), viscous=float(strengths[1]))

    def evidence(self, gap: Gap, site: Site, strengths: Floats) -> str:
        """Name the other joint and what it brings."""
        unit = "N" if gap.body.sliding[site.joint] else "N·m"
        other = self.source(gap, site)
        speed = float(np.sqrt(np.mean(np.square(gap.motion.velocity[:, other]))))
        return (
            f"its effort follows the motion of {self.from_name(gap, site)}: {strengths[0]:+.3g} {unit} with its "
            f"direction and {strengths[1] * speed:+.3g} {unit} at its usual speed"
        )


@final
class SharedEffort(_Coupling):
    """A share of the other joint's effort."""

    def samples(self, gap: Gap, site: Site) -> Floats:
        """The other joint's effort, (n, 1)."""
        other = self.source(gap, site)
        return column(shared_effort(gap.robot, gap.motion, other, gap.known.effort.total[:, other]))

    def quantities(self, gap: Gap, site: Site) -> tuple[Quantity, ...]:
        """The share."""
        return (Quantity(EFFORT),)

    def admissible(self, gap: Gap, site: Site, strengths: Floats) -> bool:
        """Less than the whole."""
        return bool(abs(strengths[0]) < MOST_SHARED)

    def extend(self, robot: Robot, site: Site, strengths: Floats) -> Robot:
        """State the coupling."""
        return _coupled(robot, site, effort=float(strengths[0]))

    def evidence(self, gap: Gap, site: Site, strengths: Floats) -> str:
        """Name the other joint and the share."""
        return f"it carries {100 * strengths[0]:.3g} % of the effort of {self.from_name(gap, site)}"


class _CommonFriction(_Coupling):
    """C·sgn u + V·u of a drive that turns with u = vₖ + ratio·v, felt by both joints."""

    def _rub(self, gap: Gap, site: Site) -> Floats:
        motion, other = gap.motion, self.source(gap, site)
        turn = motion.velocity[:, other] + self.ratio * motion.velocity[:, site.joint]
        sure = np.hypot(motion.sure_speed[:, other], self.ratio * motion.sure_speed[:, site.joint])
        return np.column_stack([2.0 * direction(turn, sure)[0] - 1.0, turn])

    def sites(self, gap: Gap) -> list[Site]:
        """Neighbouring moving joints whose efforts were both measured."""
        pairs = super().sites(gap)
        return [site for site in pairs if site.other == site.joint + 1 and site.other in gap.examined]

    def samples(self, gap: Gap, site: Site) -> Floats:
        """The drive's friction as the site's joint feels it, (n, 2)."""
        return self.ratio * self._rub(gap, site)

    def columns(self, gap: Gap, site: Site) -> Columns:
        """The drive's friction at both joints."""
        rub, other = self._rub(gap, site), self.source(gap, site)
        return {site.joint: gap.reported(site.joint, self.ratio * rub), other: gap.reported(other, rub)}

    def quantities(self, gap: Gap, site: Site) -> tuple[Quantity, ...]:
        """Level and damping of the drive."""
        return (Quantity(COULOMB), Quantity(VISCOUS))

    def extend(self, robot: Robot, site: Site, strengths: Floats) -> Robot:
        """State the common drive at the joint whose motor it is."""
        assert site.other is not None, "sites names another joint"
        table = robot.table.joint[site.other]
        drive = CommonDrive(
            joint=robot.joints[site.joint], ratio=self.ratio, coulomb=float(strengths[0]), viscous=float(strengths[1])
        )
        return robot.with_joint(table.model_copy(update={"common_drive": (*table.common_drive, drive)}))

    def evidence(self, gap: Gap, site: Site, strengths: Floats) -> str:
        """Name the other joint."""
        how = "the sum" if self.ratio > 0.0 else "the difference"
        unit = "N" if gap.body.sliding[site.joint] else "N·m"
        return (
            f"friction of {strengths[0]:.3g} {unit} turns with {how} of its velocity and that of "
            f"{self.from_name(gap, site)}, and both joints feel it: they share a drive"
        )


@final
class SumDrive(_CommonFriction):
    """The drive turns with vₖ + v."""

    ratio = 1.0


@final
class DifferenceDrive(_CommonFriction):
    """The drive turns with vₖ − v."""

    ratio = -1.0


def _coupled(robot: Robot, site: Site, **strengths: float) -> Robot:
    assert site.other is not None, "sites names another joint"
    table = robot.table.joint[site.joint]
    own = Coupling(joint=robot.joints[site.other], **strengths)
    return robot.with_joint(table.model_copy(update={"coupling": (*table.coupling, own)}))
