"""drive.coupling: a joint's own drive turns with its neighbour too, and so does the friction that is stated of it."""

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
    DifferenceDrive,
    DifferenceRotor,
    SharedDrive,
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

RATIOS = (0.06, 1.5)  # by which a joint's drive turns with its neighbour, once with the joint
RATIO = Parameter("ratio", "1", "turns with the neighbour, once with the joint whose drive it is", *RATIOS)
TRIED = (0.12, 0.25, 0.5, 1.0)
WHOLE = 1.2  # of what is stated, that the drive may take of it: stated levels are a little off


class CarriedDrive(SharedDrive):
    """C·(sgn u − sgn v) + V·(u − v) at the joint whose drive it is, u = v + ratio·vₖ, and ratio·(C·sgn u + V·u) at its
    neighbour k: of the friction that is stated of the joint, C and V turn with the drive.

    The site is the neighbour's; the drive is the ``other``'s.
    """

    shape_parameters = (RATIO,)
    besides: ClassVar[type[SharedDrive]]  # that turns so too, but has friction that is stated of no joint

    def told_at(self, site: Site) -> int:
        """The joint whose drive it is."""
        assert site.other is not None, "sites names another joint"
        return site.other

    def bounds_beside_stated_levels(self, gap: Gap, site: Site) -> list[tuple[float, float]]:
        """None: the ratio is searched from the beginning."""
        return []

    def shape_bounds(self, gap: Gap, site: Site) -> list[tuple[float, float]]:
        """From a drive that hardly turns with the neighbour to one that turns with it more than with its own."""
        return [RATIOS]

    def sites(self, gap: Gap) -> list[Site]:
        """Joints next to one of their kind whose friction is stated, either way along the arm, with ratios to try."""
        slides, joints = gap.body.sliding, gap.robot.table.joint
        return [
            Site(joint, (ratio,), other=own)
            for joint in gap.examined
            for own in (joint - 1, joint + 1)
            if own in gap.examined and slides[own] == slides[joint] and stated_levels(joints[own])[0] > 0.0
            for ratio in TRIED
        ]

    def admissible(self, gap: Gap, site: Site, strengths: Floats) -> bool:
        """It takes no more friction than is stated of the joint, slow or fast, and none that drives it."""
        own = self.told_at(site)
        stated = np.array(stated_levels(gap.robot.table.joint[own]))
        slow, fast = np.quantile(np.abs(gap.motion.velocity[:, own]), SPEEDS)
        taken, least = strengths[:2], super().admissible(gap, site, strengths)
        return least and all(taken @ (1.0, speed) <= WHOLE * stated @ (1.0, speed) for speed in (slow, fast))

    def at_drive(self, gap: Gap, site: Site, joint: int) -> Floats:
        """Of what turns with the drive, the joint's own motion brought its part before, (n, strengths)."""
        takes = super().at_drive(gap, site, joint)
        if joint == site.other:
            takes = takes - np.column_stack([gap.forward(joint), gap.motion.velocity[:, joint]])
        return takes

    def screening(self, gap: Gap, sites: Sequence[Site], every: int) -> Columns:
        """The columns at the joint and at both of its neighbours, none where a site is the other one's."""
        blocks = [{joint: own[::every] for joint, own in self.columns(gap, site).items()} for site in sites]
        none = np.zeros_like(blocks[0][sites[0].joint])
        felt = sorted({joint for block in blocks for joint in block})
        return {joint: np.stack([block.get(joint, none) for block in blocks], axis=1) for joint in felt}

    def extend(self, robot: Robot, site: Site, strengths: Floats) -> Robot:
        """State the drive, and so much less friction and rotor of the joint's own."""
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
    """I·ratio·aₖ besides at the joint, and ratio·I·(a + ratio·aₖ) at its neighbour: the stated rotor turns so too."""

    takes = (COULOMB, VISCOUS, INERTIA)

    def at_drive(self, gap: Gap, site: Site, joint: int) -> Floats:
        """What the friction takes, and the inertia, (n, 3)."""
        hard, own, ratio = gap.motion.acceleration, self.told_at(site), self.ratio(site)
        turns = ratio * hard[:, site.joint] + (0.0 if joint == own else hard[:, own])
        return np.column_stack([super().at_drive(gap, site, joint), turns])

    def admissible(self, gap: Gap, site: Site, strengths: Floats) -> bool:
        """Nor more inertia than is stated of the joint's rotor."""
        stated = gap.robot.table.joint[self.told_at(site)].actuator.reflected_inertia
        return bool(0.0 <= strengths[2] <= WHOLE * stated) and super().admissible(gap, site, strengths)


@final
class SumCarriedRotor(_CarriedRotor):
    """The drive turns with v + ratio·vₖ, and its rotor with it."""

    way = 1.0
    besides = SumRotor


@final
class DifferenceCarriedRotor(_CarriedRotor):
    """The drive turns with v − ratio·vₖ, and its rotor with it."""

    way = -1.0
    besides = DifferenceRotor


@final
class SumCarried(CarriedDrive):
    """The drive turns with v + ratio·vₖ."""

    way = 1.0
    besides = SumDrive
    fuller = SumCarriedRotor


@final
class DifferenceCarried(CarriedDrive):
    """The drive turns with v − ratio·vₖ."""

    way = -1.0
    besides = DifferenceDrive
    fuller = DifferenceCarriedRotor
