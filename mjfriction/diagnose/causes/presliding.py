"""friction.presliding: after a reversal friction builds up over some travel instead of at once."""

from __future__ import annotations

from abc import abstractmethod
from typing import ClassVar, final

import numpy as np

from mjfriction.diagnose.causes.cause import JointCause, Quantity, Site, column
from mjfriction.identify.doubt import DOUBT_PERIODS, YIELDING
from mjfriction.identify.gap import Gap
from mjfriction.identify.regression import Columns
from mjfriction.laws.ambient import ambient
from mjfriction.laws.dahl import DAHL
from mjfriction.laws.law import Law
from mjfriction.laws.lugre import LUGRE
from mjfriction.laws.maxwell_slip import MAXWELL_SLIP
from mjfriction.laws.rules import Values
from mjfriction.parameter import Parameter
from mjfriction.record.log import Floats
from mjfriction.robot.friction import raised_levels, stated_levels, stribeck_excess, with_term
from mjfriction.robot.robot import Robot

LEVEL = Parameter("presliding_level", "{force}", "part of the Coulomb level that builds up over a travel", lower=0.0)
DAMPING = LUGRE.parameter("bristle_damping")
TRAVEL = Parameter("presliding_travel", "{length}", "travel over which 63 % of the change builds up", lower=1e-9)
SLIPS = (0.25, 0.75, 2.0)  # distances after which the elements slip, in multiples of the travel
LEVELS = tuple(
    Parameter(
        f"presliding_level_{i + 1}", "{force}", f"level of the element that slips after {slip:g} travels", lower=0.0
    )
    for i, slip in enumerate(SLIPS)
)
LEAST_ELEMENT = 0.05  # fraction of the whole level by which noise may make an element of zero negative
# Shortest travel, in multiples of the travel over which a reversal is blurred: a faster build-up cannot be seen.
SHORTEST = 2.0
LONGEST = 0.2  # longest travel, as a fraction of the stroke
# The same for elements: the last of them still slips within seven tenths of the stroke, and is no spring.
LONGEST_OF_ELEMENTS = 0.35
SHAPES = 8
LEAST_PART = 0.1  # least part of the joint's level that builds up: a contact yields under all of it, not under a trace
# Multiple of the joint's level that may build up: stated levels are off, and near rest there may be more friction.
MOST_OF_LEVEL = 3.0
LEAST_LEVEL = 0.1  # floor for that level, as a fraction of the joint's RMS effort, where none is stated


def _usual_effort(gap: Gap, joint: int) -> float:
    return float(np.sqrt(np.mean(np.square(gap.measured[:, joint]))))


def _dahl(level: float, travel: float) -> dict[str, float]:
    return {"coulomb": level, "bristle_stiffness": level / travel, "shape_exponent": 1.0, "viscous": 0.0}


def _elements(levels: Floats, travel: float) -> dict[str, float | list[float]]:
    stiffness, held = levels / (np.array(SLIPS) * travel), levels > 0.0
    return {"viscous": 0.0, "stiffness": stiffness[held].tolist(), "level": levels[held].tolist()}


class Bristle(JointCause):
    """A part E of the Coulomb level follows a bristle instead of the direction of motion: E·(z − sgn v), where
    dz/dx = (1 − z·sgn v)/x₀.
    """

    name = "friction.presliding"
    picture = "travel"
    everywhere = True
    least_of_friction = 0.0  # not needed: admissible() asks more of the level that builds up
    shape_parameters = (TRAVEL,)
    longest: ClassVar[float] = LONGEST

    def sites(self, gap: Gap) -> list[Site]:
        """Every examined joint that reverses, with travels spaced logarithmically over what its motion can show."""
        out = []
        for site in super().sites(gap):
            low, high = self.shape_bounds(gap, site)[0]
            turns = np.ptp(np.sign(gap.forward(site.joint))) > 1.0
            if turns and high > 2.0 * low:
                out += [site.shaped((float(travel),)) for travel in np.geomspace(low, high, SHAPES)]
        return out

    def shape_bounds(self, gap: Gap, site: Site) -> list[tuple[float, float]]:
        """From a multiple of the travel over which a reversal is blurred to a fraction of the stroke."""
        motion, joint = gap.motion, site.joint
        blurred = gap.doubt_speed[joint] * DOUBT_PERIODS / motion.cutoff
        return [(SHORTEST * blurred, self.longest * float(np.ptp(motion.position[:, joint])))]

    def followed(self, gap: Gap, site: Site, law: Law, values: Values) -> Floats:
        """Return the friction of a law along the motion of the site's joint, which begins each piece at rest, (n,)."""
        motion, joint = gap.motion, site.joint

        def made() -> Columns:
            packed, friction = law.pack(values), np.empty_like(motion.time)
            for own in motion.pieces:
                velocity = motion.velocity[own, joint]
                friction[own] = law.follow(velocity, ambient(velocity.size), 1.0 / motion.rate, packed)[0]
            return {joint: friction}

        return gap.kept.recall(f"bristle {law.name} {joint} {site.shape}", made)[joint]

    def admissible(self, gap: Gap, site: Site, strengths: Floats) -> bool:
        """The level that builds up opposes the motion, and is neither a trace of the joint's level nor far above it."""
        stated, builds_up = gap.robot.table.joint[site.joint], self.taken_level(strengths)
        there = max(stated_levels(stated)[0] + stribeck_excess(stated), LEAST_LEVEL * _usual_effort(gap, site.joint))
        return bool(LEAST_PART * there < builds_up < MOST_OF_LEVEL * there)

    def taken_level(self, strengths: Floats) -> float:
        """The whole level that builds up."""
        return float(strengths[0])

    def noteworthy(self, gap: Gap, site: Site, strengths: Floats) -> bool:
        """A travel longer than every contact yields before it slides, whatever its law; else it is refitted along.

        A gear does not yield less where its joint is turned by less than a radian.
        """
        stroke = float(np.ptp(gap.motion.position[:, site.joint]))
        return bool(site.shape[0] > YIELDING * (stroke if gap.body.sliding[site.joint] else max(stroke, 1.0)))

    def extend(self, robot: Robot, site: Site, strengths: Floats) -> Robot:
        """Move a part of the Coulomb level into a law that builds up; where no level is stated, nothing moves."""
        joint = robot.joints[site.joint]
        level = min(self.taken_level(strengths), stated_levels(robot.joint(joint))[0])
        if level <= 0.0:
            return robot  # no level to move: refitted levels may not have been built in yet
        return self.moved(robot, joint, level, site.shape[0], strengths)

    @abstractmethod
    def moved(self, robot: Robot, joint: str, level: float, travel: float, strengths: Floats) -> Robot:
        """Return the robot with a ``level`` moved into the law in which it builds up over a ``travel``."""

    def travel(self, site: Site, strengths: Floats) -> float:
        """The travel after a reversal over which 1 − 1/e of the change builds up."""
        return site.shape[0]

    def evidence(self, gap: Gap, site: Site, strengths: Floats) -> str:
        """Give the level and the travel."""
        sliding, level = gap.body.sliding[site.joint], self.taken_level(strengths)
        return (
            f"after every reversal {level:.3g} {'N' if sliding else 'N·m'} of the friction build up over a travel of "
            f"{site.shape[0]:.3g} {'m' if sliding else 'rad'}, fast or slow"
        )


class LevelBristle(Bristle):
    """The Coulomb level alone builds up."""

    def bristle(self, gap: Gap, site: Site) -> Floats:
        """Return z, the share of the level that has built up, −1 to 1, (n,)."""
        return self.followed(gap, site, DAHL, _dahl(1.0, site.shape[0]))

    def moved(self, robot: Robot, joint: str, level: float, travel: float, strengths: Floats) -> Robot:
        """Move the level into a law of its own."""
        law, values = self.law(level, travel, strengths)
        return with_term(raised_levels(robot, joint, -level, 0.0), joint, law.name, values)

    @abstractmethod
    def law(self, level: float, travel: float, strengths: Floats) -> tuple[Law, Values]:
        """Return the law whose ``level`` builds up over a ``travel``, and its values."""


@final
class SlippingElements(LevelBristle):
    """Springs that slip one after the other (Maxwell-slip): ΣEᵢ·(zᵢ − sgn v), where zᵢ follows x up to ±1 over a
    distance of dᵢ = :data:`SLIPS`·x₀.

    They remember every reversal.  Where the travel is as long as the motion's, their inner hysteresis loops are tilted
    as those of a spring.
    """

    longest = LONGEST_OF_ELEMENTS

    def samples(self, gap: Gap, site: Site) -> Floats:
        """Each element's share minus the direction of motion, (n, elements)."""
        motion, joint = gap.motion, site.joint
        packed = MAXWELL_SLIP.pack(_elements(np.ones(len(SLIPS)), site.shape[0]))
        shares = np.empty((motion.time.size, len(SLIPS)))
        for own in motion.pieces:
            velocity = motion.velocity[own, joint]
            shares[own] = MAXWELL_SLIP.follow(velocity, ambient(velocity.size), 1.0 / motion.rate, packed)[1]
        return shares - column(gap.forward(joint))

    def quantities(self, gap: Gap, site: Site) -> tuple[Quantity, ...]:
        """The level of each element."""
        return tuple(Quantity(level) for level in LEVELS)

    def taken_level(self, strengths: Floats) -> float:
        """The sum of the elements' levels."""
        return float(np.sum(strengths))

    def admissible(self, gap: Gap, site: Site, strengths: Floats) -> bool:
        """Also, every element opposes the motion, within noise."""
        least = -LEAST_ELEMENT * float(np.sum(strengths))
        return super().admissible(gap, site, strengths) and bool(np.min(strengths) > least)

    def noteworthy(self, gap: Gap, site: Site, strengths: Floats) -> bool:
        """The last element that holds a relevant part slips only beyond what every contact yields before it slides."""
        held = np.array(SLIPS)[np.asarray(strengths) > LEAST_PART * np.sum(strengths)]
        return super().noteworthy(gap, site.shaped((float(np.max(held)) * site.shape[0],)), strengths)

    def travel(self, site: Site, strengths: Floats) -> float:
        """That of a bristle as soft: an element that slips after d builds up its whole change over 2·d, evenly."""
        held = np.maximum(strengths, 0.0)
        ends = 2.0 * np.array(SLIPS)
        built = np.minimum(ends[:, None] / ends, 1.0) @ (held / np.sum(held))
        return site.shape[0] * float(np.interp(1.0 - 1.0 / np.e, np.append(0.0, built), np.append(0.0, ends)))

    def law(self, level: float, travel: float, strengths: Floats) -> tuple[Law, Values]:
        """The Maxwell-slip law with the elements of positive level."""
        levels = np.maximum(strengths, 0.0)
        return MAXWELL_SLIP, _elements(level * levels / np.sum(levels), travel)


@final
class Presliding(LevelBristle):
    """A bristle without damping, as in Dahl's law."""

    richer = SlippingElements

    def samples(self, gap: Gap, site: Site) -> Floats:
        """The bristle's share minus the direction of motion, (n, 1)."""
        return column(self.bristle(gap, site) - gap.forward(site.joint))

    def quantities(self, gap: Gap, site: Site) -> tuple[Quantity, ...]:
        """The level that builds up."""
        return (Quantity(LEVEL),)

    def law(self, level: float, travel: float, strengths: Floats) -> tuple[Law, Values]:
        """Dahl's law."""
        return DAHL, _dahl(level, travel)


@final
class DampedPresliding(LevelBristle):
    """A bristle whose deflection is damped, as in the LuGre law: in addition σ₁·(1 − z·sgn v)·v.

    This damping acts after a reversal and fades as the bristle slides.  Without it the fitted travel is too short.
    """

    simpler = Presliding
    richer = SlippingElements

    def samples(self, gap: Gap, site: Site) -> Floats:
        """The bristle's share minus the direction of motion, and the rate of its deflection, (n, 2)."""
        bristle, velocity = self.bristle(gap, site), gap.motion.velocity[:, site.joint]
        return np.column_stack([bristle - gap.forward(site.joint), velocity - np.abs(velocity) * bristle])

    def quantities(self, gap: Gap, site: Site) -> tuple[Quantity, ...]:
        """The level that builds up, and the damping."""
        return (Quantity(LEVEL), Quantity(DAMPING))

    def admissible(self, gap: Gap, site: Site, strengths: Floats) -> bool:
        """Also, the deflection is damped, never driven."""
        return super().admissible(gap, site, strengths) and bool(strengths[1] > 0.0)

    def law(self, level: float, travel: float, strengths: Floats) -> tuple[Law, Values]:
        """The LuGre law, without a Stribeck curve."""
        curve = {"coulomb": level, "static": level, "stribeck_velocity": 1.0, "stribeck_exponent": 2.0}
        stiff = {"bristle_stiffness": level / travel, "bristle_damping": float(strengths[1]), "viscous": 0.0}
        return LUGRE, curve | stiff
