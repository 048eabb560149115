"""drive.coupling: one joint's motion, friction or effort enters another's effort through the transmission."""

from __future__ import annotations

from dataclasses import replace
from typing import ClassVar, final

import numpy as np
from numpy.typing import NDArray

from mjfriction.diagnose.causes.cause import JointCause, Quantity, Site, column
from mjfriction.identify.doubt import CLEAR, heard, near_turns
from mjfriction.identify.gap import Gap
from mjfriction.identify.regression import Columns
from mjfriction.parameter import Parameter
from mjfriction.record.log import Floats
from mjfriction.robot.common_drives import with_common_drive, without_rotor
from mjfriction.robot.effort import shared_effort
from mjfriction.robot.robot import Robot
from mjfriction.robot.rubbing import direction
from mjfriction.robot.schema import CommonDrive, Coupling

COULOMB = Parameter("coulomb", "{force}", "dry friction that the other joint's direction of motion brings")
VISCOUS = Parameter("viscous", "{force}·s/{length}", "damping that the other joint's velocity brings")
CARRIED = Parameter("inertia", "{force}·s²/{length}", "inertia that the other joint's acceleration brings")
INERTIA = Parameter("inertia", "{force}·s²/{length}", "inertia of the rotor that both joints turn", lower=0.0)
EFFORT = Parameter("effort", "1", "share of the other joint's effort")
RATIOS = (0.25, 4.0)  # search range: how far a shared drive turns with the first joint per turn with the other
RATIO = Parameter("ratio", "1", "turns with the first joint of the two on the arm, once with the other", *RATIOS)
NEARLY = 0.02  # difference up to which two ratios count as equal; within it of 1, the drive turns equally with both
MOST_SHARED = 0.9  # largest share of another joint's effort, in size
SPEEDS = (0.1, 0.9)  # quantiles of a speed, slow and fast, at which the sign of friction is checked

# Share of friction at one speed that it may have, with the opposite sign, at another: a level of zero is fitted a
# little off.
OTHER_WAY = 0.2
LITTLE = 0.2  # share of the acceleration's effect below which the friction beside it may have any sign


class _Coupling(JointCause):
    """An effect of another joint."""

    name = "drive.coupling"

    def sites(self, gap: Gap) -> list[Site]:
        """Every examined joint, paired with every other joint that moves."""
        moving = [j for j in range(len(gap.robot.joints)) if gap.motion.moving[j]]
        return [Site(i, other=j) for i in gap.examined for j in moving if j != i]

    def source(self, gap: Gap, site: Site) -> int:
        """Return the other joint."""
        assert site.other is not None, "sites names another joint"
        return site.other

    def from_name(self, gap: Gap, site: Site) -> str:
        """Return the other joint's name."""
        return gap.robot.joints[self.source(gap, site)]


class _SharedMotion(_Coupling):
    """What the other joint's motion ``brings``: a part that follows its direction, one its velocity, and so on."""

    brings: ClassVar[tuple[Parameter, ...]]

    def courses(self, gap: Gap, site: Site) -> list[Floats]:
        """Return direction, velocity and acceleration of the other joint, (n,) each, as many as it brings."""
        motion, other = gap.motion, self.source(gap, site)
        courses = [gap.forward(other), motion.velocity[:, other], motion.acceleration[:, other]]
        return courses[: len(self.brings)]

    def samples(self, gap: Gap, site: Site) -> Floats:
        """The other joint's direction, velocity and acceleration, as many as it brings, (n, strengths)."""
        return np.column_stack(self.courses(gap, site))

    def known_where(self, gap: Gap, site: Site) -> dict[int, NDArray[np.bool_]]:
        """Where the other joint moves: while it rests, its motion does not show how much of its friction it holds."""
        return {site.joint: gap.clear[:, self.source(gap, site)]}

    def quantities(self, gap: Gap, site: Site) -> tuple[Quantity, ...]:
        """The coefficient of each of them, per metre or radian of the other joint."""
        length = "m" if gap.body.sliding[self.source(gap, site)] else "rad"
        return tuple(Quantity(replace(own, unit=own.unit.replace("{length}", length))) for own in self.brings)

    def admissible(self, gap: Gap, site: Site, strengths: Floats) -> bool:
        """The friction has one sign relative to the other joint's motion, slow and fast, within :data:`OTHER_WAY`."""
        speeds = np.quantile(np.abs(gap.motion.velocity[:, self.source(gap, site)]), SPEEDS)
        less, more = sorted(strengths[0] + strengths[1] * speeds, key=abs)
        return bool(less * more > -OTHER_WAY * more**2)

    def extend(self, robot: Robot, site: Site, strengths: Floats) -> Robot:
        """State the coupling."""
        own = zip(self.brings, strengths.tolist(), strict=True)
        return _coupled(robot, site, **{parameter.name: strength for parameter, strength in own})

    def evidence(self, gap: Gap, site: Site, strengths: Floats) -> str:
        """Name the other joint and what it brings."""
        unit = "N" if gap.body.sliding[site.joint] else "N·m"
        usual = [1.0, *(float(np.sqrt(np.mean(np.square(course)))) for course in self.courses(gap, site)[1:])]
        words = ("with its direction", "at its usual speed", "at its usual acceleration")
        parts = [f"{one * by:+.3g} {unit} {word}" for one, by, word in zip(strengths, usual, words, strict=False)]
        return f"its effort follows the motion of {self.from_name(gap, site)}: {', '.join(parts[:-1])} and {parts[-1]}"


@final
class SharedFriction(_SharedMotion):
    """C·sgn vₖ + V·vₖ of the other joint k."""

    brings = (COULOMB, VISCOUS)


@final
class SharedMotion(_SharedMotion):
    """C·sgn vₖ + V·vₖ + I·aₖ of the other joint k, as from a rotor that also turns with it."""

    brings = (COULOMB, VISCOUS, CARRIED)

    def admissible(self, gap: Gap, site: Site, strengths: Floats) -> bool:
        """The same; friction that is small beside the effect of the other joint's acceleration may have any sign."""
        rubs, turns, carries = (
            abs(one) * float(np.sqrt(np.mean(np.square(course))))
            for one, course in zip(strengths, self.courses(gap, site), strict=True)
        )
        return rubs + turns < LITTLE * carries or super().admissible(gap, site, strengths)


class SharedEffort(_Coupling):
    """A share of the other joint's effort."""

    def samples(self, gap: Gap, site: Site) -> Floats:
        """The other joint's effort, as its drive reported it or else as predicted, (n, 1)."""
        other = self.source(gap, site)
        return column(shared_effort(gap.robot, gap.motion, other, gap.known.effort.total[:, other]))

    def quantities(self, gap: Gap, site: Site) -> tuple[Quantity, ...]:
        """The share, which has a unit between a force and a torque."""
        sliding = gap.body.sliding
        if sliding[site.joint] == sliding[self.source(gap, site)]:
            return (Quantity(EFFORT),)
        return (Quantity(replace(EFFORT, unit="N/(N·m)" if sliding[site.joint] else "N·m/N")),)

    def admissible(self, gap: Gap, site: Site, strengths: Floats) -> bool:
        """Less than the whole."""
        return bool(abs(strengths[0]) < MOST_SHARED)

    def extend(self, robot: Robot, site: Site, strengths: Floats) -> Robot:
        """State the coupling."""
        return _coupled(robot, site, effort=float(strengths[0]))

    def evidence(self, gap: Gap, site: Site, strengths: Floats) -> str:
        """Name the other joint and the share."""
        return f"it carries {100 * strengths[0]:.3g} % of the effort of {self.from_name(gap, site)}"


@final
class LeaningEffort(SharedEffort):
    """A share of the effort of a drive that turns with both joints: tried beside that drive and reported with it."""

    first_order = 1


class SharedDrive(_Coupling):
    """C·sgn u + V·u of a drive that turns with u = vₖ + ratio·v, felt by both joints.

    The part that each joint feels of its own motion looks like damping of its own.  Velocities therefore determine the
    ratio only as far as the stated dampings are right.
    """

    takes: ClassVar[tuple[Parameter, ...]] = (COULOMB, VISCOUS)
    way: ClassVar[float]  # the ratio's sign
    shape_parameters = (RATIO,)

    def ratio(self, site: Site) -> float:
        """Return how far the drive turns with the site's own joint per turn with the other; ±1 without a shape."""
        return self.way * (site.shape[0] if site.shape else 1.0)

    def bounds_beside_stated_levels(self, gap: Gap, site: Site) -> list[tuple[float, float]]:
        """The ratio: outside its range, the drive hardly turns with one of the two and is the other's alone."""
        return [RATIOS]

    def told_at(self, site: Site) -> int:
        """The joint that the drive turns with most."""
        return site.joint if site.other is None or abs(self.ratio(site)) > 1.0 - NEARLY else site.other

    def sites(self, gap: Gap) -> list[Site]:
        """Neighbouring joints of one kind whose efforts were both measured: metres and radians cannot be added.

        Where a drive is stated between the two, its stated ratio is tried as well.
        """
        slides = gap.body.sliding
        sites = [
            site
            for site in super().sites(gap)
            if site.other == site.joint + 1 and site.other in gap.examined and slides[site.other] == slides[site.joint]
        ]
        return [one for site in sites for one in (site, *(site.shaped((ratio,)) for ratio in self._stated(gap, site)))]

    def _stated(self, gap: Gap, site: Site) -> list[float]:
        # The sizes of the ratios of drives stated between the two, of this cause's sign and other than 1.
        table, name = gap.robot.table.joint[self.source(gap, site)], gap.robot.joints[site.joint]
        ratios = [self.way * own.ratio for own in table.common_drive if own.joint == name]
        return [ratio for ratio in ratios if ratio > 0.0 and abs(ratio - 1.0) > NEARLY]

    def admissible(self, gap: Gap, site: Site, strengths: Floats) -> bool:
        """The drive's friction, stated plus found, opposes its own motion, slow and fast."""
        other, ratio = self.source(gap, site), self.ratio(site)
        turn = self.turn(gap, site)
        name, joint = gap.robot.joints[site.joint], gap.robot.table.joint[other]
        stated = [own for own in joint.common_drive if own.joint == name and abs(own.ratio - ratio) < NEARLY]
        coulomb = strengths[0] + sum(own.coulomb for own in stated)
        viscous = strengths[1] + sum(own.viscous for own in stated)
        return all(coulomb + viscous * speed >= 0.0 for speed in np.quantile(np.abs(turn), SPEEDS))

    def at_drive(self, gap: Gap, site: Site, joint: int) -> Floats:
        """Return the drive's effort per unit of each strength, less what is already stated at one of the two joints,
        (n, strengths).
        """
        motion, other, ratio = gap.motion, self.source(gap, site), self.ratio(site)
        turn = self.turn(gap, site)
        sure = np.hypot(motion.sure_speed[:, other], ratio * motion.sure_speed[:, site.joint])
        return np.column_stack([2.0 * direction(turn, sure)[0] - 1.0, turn])

    def turn(self, gap: Gap, site: Site) -> Floats:
        """Return the velocity that the drive turns with, (n,)."""
        velocity = gap.motion.velocity
        return np.asarray(velocity[:, self.source(gap, site)] + self.ratio(site) * velocity[:, site.joint])

    def known_where(self, gap: Gap, site: Site) -> dict[int, NDArray[np.bool_]]:
        """Where the drive turns: both joints may move while it stands still, or turns about."""
        other, slow = self.source(gap, site), gap.doubt_speed
        slowly = float(np.hypot(slow[other], self.ratio(site) * slow[site.joint]))
        near = near_turns(gap.motion, self.turn(gap, site), slowly)

        def known(joint: int) -> NDArray[np.bool_]:
            late = gap.robot.table.joint[joint].effort_sensor.delay + float(gap.late[joint])
            return gap.chain.touched(heard(near, late, gap.motion)) < CLEAR

        return {joint: known(joint) for joint in (site.joint, other)}

    def samples(self, gap: Gap, site: Site) -> Floats:
        """The drive's effort per unit strength, as the site's joint feels it, (n, strengths)."""
        return self.ratio(site) * self.at_drive(gap, site, site.joint)

    def columns(self, gap: Gap, site: Site) -> Columns:
        """The drive's effort at both joints."""
        other = self.source(gap, site)
        return {
            site.joint: gap.reported(site.joint, self.samples(gap, site)),
            other: gap.reported(other, self.at_drive(gap, site, other)),
        }

    def quantities(self, gap: Gap, site: Site) -> tuple[Quantity, ...]:
        """The drive's coefficients."""
        return tuple(Quantity(own) for own in self.takes)

    def extend(self, robot: Robot, site: Site, strengths: Floats) -> Robot:
        """State the common drive at the joint whose motor it is."""
        assert site.other is not None, "sites names another joint"
        return with_common_drive(robot, robot.joints[site.other], self.drive(robot, site, strengths))

    def drive(self, robot: Robot, site: Site, strengths: Floats) -> CommonDrive:
        """Return the common drive as a robot file states it."""
        own = dict(zip((parameter.name for parameter in self.takes), strengths.tolist(), strict=True))
        return CommonDrive(joint=robot.joints[site.joint], ratio=self.ratio(site), **own)

    def evidence(self, gap: Gap, site: Site, strengths: Floats) -> str:
        """Give the friction at usual speed, and name the joints."""
        how = "sum" if self.way > 0.0 else "difference"
        unit = "N" if gap.body.sliding[site.joint] else "N·m"
        names = gap.robot.joints[site.joint], self.from_name(gap, site)
        of = " and ".join(f"that of {name}" for name in names)
        ratio = abs(self.ratio(site))
        if abs(ratio - 1.0) > NEARLY:
            of = f"{ratio:.3g} times {of}"
        speed = float(np.sqrt(np.mean(np.square(self.at_drive(gap, site, site.joint)[:, 1]))))
        rubs = strengths[0] + strengths[1] * speed
        return (
            f"at its usual speed friction of {rubs:.3g} {unit} turns with a velocity that is the {how} of {of}, and "
            "both joints feel it: they share a drive"
        )


class SharedRotor(SharedDrive):
    """C·sgn u + V·u + I·u̇: the rotor turns with both joints too.

    Where the robot file states a rotor at a joint, the inertia that follows this joint's own acceleration counts as
    stated already: only the effect of the other joint's acceleration is new there.  A drive besides those of both
    joints ``adds`` its rotor instead.
    """

    takes = (COULOMB, VISCOUS, INERTIA)
    adds: ClassVar[bool] = False

    def at_drive(self, gap: Gap, site: Site, joint: int) -> Floats:
        """The effort per unit of the friction's strengths and of the inertia, (n, 3)."""
        hard, other = gap.motion.acceleration, self.source(gap, site)
        ratio = self.ratio(site)
        takes = hard[:, other] + ratio * hard[:, site.joint]
        if gap.robot.table.joint[joint].actuator.rotor_inertia > 0.0 and not self.adds:
            takes = takes - (1.0 if joint == other else ratio) * hard[:, joint]
        return np.column_stack([super().at_drive(gap, site, joint), takes])

    def admissible(self, gap: Gap, site: Site, strengths: Floats) -> bool:
        """The drive's rotor also has no negative inertia."""
        return bool(strengths[2] >= 0.0) and super().admissible(gap, site, strengths)

    def extend(self, robot: Robot, site: Site, strengths: Floats) -> Robot:
        """State the common drive at the joint whose motor it is, and take an inertia that both joints' rotors state
        from these.
        """
        assert site.other is not None, "sites names another joint"
        if not self.adds:
            for joint, ratio in ((site.joint, self.ratio(site)), (site.other, 1.0)):
                robot = without_rotor(robot, robot.joints[joint], ratio**2 * float(strengths[2]))
        return super().extend(robot, site, strengths)


@final
class SumRotor(SharedRotor):
    """The drive turns with vₖ + ratio·v, and its rotor with it."""

    way = 1.0


@final
class DifferenceRotor(SharedRotor):
    """The drive turns with vₖ − ratio·v, and its rotor with it."""

    way = -1.0


@final
class SumAddedRotor(SharedRotor):
    """The drive turns with vₖ + ratio·v, and a rotor besides those of both joints with it."""

    way = 1.0
    adds = True


@final
class DifferenceAddedRotor(SharedRotor):
    """The drive turns with vₖ − ratio·v, and a rotor besides those of both joints with it."""

    way = -1.0
    adds = True


@final
class SumDrive(SharedDrive):
    """The drive turns with vₖ + ratio·v."""

    way = 1.0
    fuller = (SumRotor, SumAddedRotor)


@final
class DifferenceDrive(SharedDrive):
    """The drive turns with vₖ − ratio·v."""

    way = -1.0
    fuller = (DifferenceRotor, DifferenceAddedRotor)


def _coupled(robot: Robot, site: Site, **strengths: float) -> Robot:
    assert site.other is not None, "sites names another joint"
    table = robot.table.joint[site.joint]
    own = Coupling(joint=robot.joints[site.other], **strengths)
    return robot.with_joint(table.model_copy(update={"coupling": (*table.coupling, own)}))
