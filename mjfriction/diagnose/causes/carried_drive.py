"""drive.coupling: a joint's own drive also turns with its neighbour, and so does the friction stated for the joint."""

from __future__ import annotations

from collections.abc import Sequence
from typing import ClassVar, final

import numpy as np

from mjfriction.diagnose.causes.cause import Site
from mjfriction.diagnose.causes.coupling import (
    COULOMB,
    INERTIA,
    SPEEDS,
    VISCOUS,
    DifferenceAddedRotor,
    DifferenceDrive,
    DifferenceRotor,
    SharedDrive,
    SumAddedRotor,
    SumDrive,
    SumRotor,
)
from mjfriction.identify.gap import Gap
from mjfriction.identify.regression import Columns
from mjfriction.parameter import Parameter
from mjfriction.record.log import Floats
from mjfriction.robot.common_drives import with_drive_turned_too
from mjfriction.robot.friction import stated_levels
from mjfriction.robot.robot import Robot

RATIOS = (0.06, 1.5)  # search range: how far a joint's drive turns with the neighbour per turn with its own joint
RATIO = Parameter("ratio", "1", "turns with the neighbour, once with the joint whose drive it is", *RATIOS)
TRIED = (0.12, 0.25, 0.5, 1.0)
WHOLE = 1.2  # share of the stated values that the drive may take; above 1 because these are a little off


class CarriedDrive(SharedDrive):
    """C·(sgn u − sgn v) + V·(u − v) at the joint whose drive it is, u = v + ratio·vₖ, and ratio·(C·sgn u + V·u) at its
    neighbour k.

    C and V are the part of the joint's stated friction that turns with the drive.  The site's joint is the neighbour;
    the drive belongs to the ``other`` joint.
    """

    shape_parameters = (RATIO,)
    besides: ClassVar[tuple[type[SharedDrive], ...]]  # drives that turn the same way, whose friction no joint states

    def told_at(self, site: Site) -> int:
        """The joint whose drive it is."""
        assert site.other is not None, "sites names another joint"
        return site.other

    def bounds_beside_stated_levels(self, gap: Gap, site: Site) -> list[tuple[float, float]]:
        """None: the ratio is searched with free levels too."""
        return []

    def shape_bounds(self, gap: Gap, site: Site) -> list[tuple[float, float]]:
        """From a drive that hardly turns with the neighbour to one that turns with it more than with its own joint."""
        return [RATIOS]

    def sites(self, gap: Gap) -> list[Site]:
        """Joints next to one of the same kind that has a stated Coulomb level, on either side, with ratios to try."""
        slides, joints = gap.body.sliding, gap.robot.table.joint
        return [
            Site(joint, (ratio,), other=own)
            for joint in gap.examined
            for own in (joint - 1, joint + 1)
            if own in gap.examined and slides[own] == slides[joint] and stated_levels(joints[own])[0] > 0.0
            for ratio in TRIED
        ]

    def admissible(self, gap: Gap, site: Site, strengths: Floats) -> bool:
        """The drive takes no more friction than the joint states, slow or fast, and none that would drive it."""
        own = self.told_at(site)
        stated = np.array(stated_levels(gap.robot.table.joint[own]))
        slow, fast = np.quantile(np.abs(gap.motion.velocity[:, own]), SPEEDS)
        taken, least = strengths[:2], super().admissible(gap, site, strengths)
        return least and all(taken @ (1.0, speed) <= WHOLE * stated @ (1.0, speed) for speed in (slow, fast))

    def at_drive(self, gap: Gap, site: Site, joint: int) -> Floats:
        """The drive's effort per unit strength, less the own joint's part that is stated already, (n, strengths)."""
        takes = super().at_drive(gap, site, joint)
        if joint == site.other:
            takes = takes - np.column_stack([gap.forward(joint), gap.motion.velocity[:, joint]])
        return takes

    def screening(self, gap: Gap, sites: Sequence[Site], every: int) -> Columns:
        """The columns at the joint and at both of its neighbours, zero at a neighbour that a site does not involve."""
        blocks = [{joint: own[::every] for joint, own in self.columns(gap, site).items()} for site in sites]
        none = np.zeros_like(blocks[0][sites[0].joint])
        felt = sorted({joint for block in blocks for joint in block})
        return {joint: np.stack([block.get(joint, none) for block in blocks], axis=1) for joint in felt}

    def extend(self, robot: Robot, site: Site, strengths: Floats) -> Robot:
        """State the drive, and lower the joint's own friction and rotor inertia by as much."""
        return with_drive_turned_too(robot, robot.joints[self.told_at(site)], self.drive(robot, site, strengths))

    def evidence(self, gap: Gap, site: Site, strengths: Floats) -> str:
        """Name the joints and the share of the friction."""
        own, names = self.told_at(site), gap.robot.joints
        usual = 1.0, float(np.sqrt(np.mean(np.square(gap.motion.velocity[:, own]))))
        share = min(1.0, float(strengths[:2] @ usual / (np.array(stated_levels(gap.robot.table.joint[own])) @ usual)))
        return (
            f"its drive turns with {self.ratio(site):+.3g} times the velocity of {names[site.joint]} besides its own, "
            f"and with it {100.0 * share:.0f} % of the friction stated of {names[own]} at its usual speed: both joints "
            "feel it"
        )


class _CarriedRotor(CarriedDrive):
    """In addition I·ratio·aₖ at the joint, and ratio·I·(a + ratio·aₖ) at its neighbour: the stated rotor turns too."""

    takes = (COULOMB, VISCOUS, INERTIA)

    def at_drive(self, gap: Gap, site: Site, joint: int) -> Floats:
        """The effort per unit of the friction's strengths and of the inertia, (n, 3)."""
        hard, own, ratio = gap.motion.acceleration, self.told_at(site), self.ratio(site)
        turns = ratio * hard[:, site.joint] + (0.0 if joint == own else hard[:, own])
        return np.column_stack([super().at_drive(gap, site, joint), turns])

    def admissible(self, gap: Gap, site: Site, strengths: Floats) -> bool:
        """The drive also takes no more inertia than the joint's rotor states."""
        stated = gap.robot.table.joint[self.told_at(site)].actuator.reflected_inertia
        return bool(0.0 <= strengths[2] <= WHOLE * stated) and super().admissible(gap, site, strengths)


@final
class SumCarriedRotor(_CarriedRotor):
    """The drive turns with v + ratio·vₖ, and its rotor with it."""

    way = 1.0
    besides = (SumRotor, SumAddedRotor)


@final
class DifferenceCarriedRotor(_CarriedRotor):
    """The drive turns with v − ratio·vₖ, and its rotor with it."""

    way = -1.0
    besides = (DifferenceRotor, DifferenceAddedRotor)


@final
class SumCarried(CarriedDrive):
    """The drive turns with v + ratio·vₖ."""

    way = 1.0
    besides = (SumDrive,)
    fuller = (SumCarriedRotor,)


@final
class DifferenceCarried(CarriedDrive):
    """The drive turns with v − ratio·vₖ."""

    way = -1.0
    besides = (DifferenceDrive,)
    fuller = (DifferenceCarriedRotor,)
