"""friction.presliding: after a reversal friction builds up over a travel, not at once."""

from __future__ import annotations

from abc import abstractmethod
from typing import final

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
SLIPS = (0.25, 0.75, 2.0)  # times the travel, over which elements slip
LEVELS = tuple(
    Parameter(
        f"presliding_level_{i + 1}", "{force}", f"level of the element that slips after {slip:g} travels", lower=0.0
    )
    for i, slip in enumerate(SLIPS)
)
LEAST_ELEMENT = 0.05  # of all that builds up, by which noise may turn the sign of an element that is none
SHORTEST = 2.0  # times the travel that a reversal's doubt covers: what builds up within it cannot be seen
LONGEST = 0.2  # of the stroke
SHAPES = 8
LEAST_PART = 0.1  # of the joint's level that has to build up: a contact yields under all of it, not under a trace
MOST_OF_LEVEL = (
    3.0  # times the stated level that may build up, for stated levels are off, and near rest there may be more
)
LEAST_LEVEL = 0.1  # of the joint's effort, that a level may be where none is stated


def _usual_effort(gap: Gap, joint: int) -> float:
    return float(np.sqrt(np.mean(np.square(gap.measured[:, joint]))))


def _dahl(level: float, travel: float) -> dict[str, float]:
    return {"coulomb": level, "bristle_stiffness": level / travel, "shape_exponent": 1.0, "viscous": 0.0}


def _elements(levels: Floats, travel: float) -> dict[str, float | list[float]]:
    stiffness, held = levels / (np.array(SLIPS) * travel), levels > 0.0
    return {"viscous": 0.0, "stiffness": stiffness[held].tolist(), "level": levels[held].tolist()}


class _Bristle(JointCause):
    """Of the Coulomb level, E follows a bristle in place of the direction of motion: E·(z − sgn v), where
    dz/dx = (1 − z·sgn v)/x₀.
    """

    name = "friction.presliding"
    picture = "travel"
    least_of_friction = 0.0  # of the level that builds up more is asked
    shape_parameters = (TRAVEL,)

    def sites(self, gap: Gap) -> list[Site]:
        """Every moving joint that reverses, with travels spaced evenly in logarithm over what its motion can show."""
        out = []
        for site in super().sites(gap):
            low, high = self.shape_bounds(gap, site)[0]
            turns = np.ptp(np.sign(gap.forward(site.joint))) > 1.0
            if turns and high > 2.0 * low:
                out += [site.shaped((float(travel),)) for travel in np.geomspace(low, high, SHAPES)]
        return out

    def shape_bounds(self, gap: Gap, site: Site) -> list[tuple[float, float]]:
        """From the travel that a blurred reversal covers to a part of the stroke."""
        motion, joint = gap.motion, site.joint
        blurred = gap.doubt_speed[joint] * DOUBT_PERIODS / motion.cutoff
        return [(SHORTEST * blurred, LONGEST * float(np.ptp(motion.position[:, joint])))]

    def bristle(self, gap: Gap, site: Site) -> Floats:
        """Return z, the share of the level that has built up, −1 to 1, (n,)."""
        motion, joint = gap.motion, site.joint

        def made() -> Columns:
            packed = DAHL.pack(_dahl(1.0, site.shape[0]))
            bristle = np.empty_like(motion.time)
            for own in motion.pieces:
                velocity = motion.velocity[own, joint]
                bristle[own] = DAHL.follow(velocity, ambient(velocity.size), 1.0 / motion.rate, packed)[0]
            return {joint: bristle}

        return gap.kept.recall(f"bristle {joint} {site.shape}", made)[joint]

    def admissible(self, gap: Gap, site: Site, strengths: Floats) -> bool:
        """Friction that builds up stands against the motion, and is no trace of what there is nor more than that."""
        stated, builds_up = gap.robot.table.joint[site.joint], self.taken_level(strengths)
        there = max(stated_levels(stated)[0] + stribeck_excess(stated), LEAST_LEVEL * _usual_effort(gap, site.joint))
        return bool(LEAST_PART * there < builds_up < MOST_OF_LEVEL * there)

    def taken_level(self, strengths: Floats) -> float:
        """All that builds up."""
        return float(strengths[0])

    def noteworthy(self, gap: Gap, site: Site, strengths: Floats) -> bool:
        """A travel that every contact yields before it slides, whatever its law, is refitted along."""
        return bool(site.shape[0] > YIELDING * np.ptp(gap.motion.position[:, site.joint]))

    def extend(self, robot: Robot, site: Site, strengths: Floats) -> Robot:
        """Move a part of the Coulomb level into a law that builds up; where none is stated, nothing moves."""
        joint = robot.joints[site.joint]
        level = min(self.taken_level(strengths), stated_levels(robot.joint(joint))[0])
        if level <= 0.0:
            return robot  # there is none to move: levels that are refitted along may not be built in yet
        law, values = self.law(level, site.shape[0], strengths)
        return with_term(raised_levels(robot, joint, -level, 0.0), joint, law.name, values)

    @abstractmethod
    def law(self, level: float, travel: float, strengths: Floats) -> tuple[Law, Values]:
        """Return the law whose ``level`` builds up over a ``travel``, and its values."""

    def evidence(self, gap: Gap, site: Site, strengths: Floats) -> str:
        """Give the travel."""
        sliding, level = gap.body.sliding[site.joint], self.taken_level(strengths)
        return (
            f"after every reversal {level:.3g} {'N' if sliding else 'N·m'} of the friction build up over a travel of "
            f"{site.shape[0]:.3g} {'m' if sliding else 'rad'}, fast or slow"
        )


@final
class SlippingElements(_Bristle):
    """Springs that slip one after the other, Maxwell-slip's: ΣEᵢ·(zᵢ − sgn v), where zᵢ follows x up to ±1 over a
    distance of dᵢ = :data:`SLIPS`·x₀.

    They keep a memory of every reversal, and their inner loops lean as a spring would where the travel is as long as
    the motion's.
    """

    def samples(self, gap: Gap, site: Site) -> Floats:
        """Each element's share less the direction of motion, (n, elements)."""
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
        """All that builds up."""
        return float(np.sum(strengths))

    def admissible(self, gap: Gap, site: Site, strengths: Floats) -> bool:
        """Every element slips against the motion."""
        least = -LEAST_ELEMENT * float(np.sum(strengths))
        return super().admissible(gap, site, strengths) and bool(np.min(strengths) > least)

    def noteworthy(self, gap: Gap, site: Site, strengths: Floats) -> bool:
        """What still builds up beyond the travel that every contact yields: the last element that holds a part."""
        held = np.array(SLIPS)[np.asarray(strengths) > LEAST_PART * np.sum(strengths)]
        return super().noteworthy(gap, site.shaped((float(np.max(held)) * site.shape[0],)), strengths)

    def law(self, level: float, travel: float, strengths: Floats) -> tuple[Law, Values]:
        """Maxwell-slip's, of those elements that hold anything."""
        levels = np.maximum(strengths, 0.0)
        return MAXWELL_SLIP, _elements(level * levels / np.sum(levels), travel)


@final
class Presliding(_Bristle):
    """A bristle without damping: Dahl's."""

    richer = SlippingElements

    def samples(self, gap: Gap, site: Site) -> Floats:
        """The bristle's share less the direction of motion, (n, 1)."""
        return column(self.bristle(gap, site) - gap.forward(site.joint))

    def quantities(self, gap: Gap, site: Site) -> tuple[Quantity, ...]:
        """The level that builds up."""
        return (Quantity(LEVEL),)

    def law(self, level: float, travel: float, strengths: Floats) -> tuple[Law, Values]:
        """Dahl's."""
        return DAHL, _dahl(level, travel)


@final
class DampedPresliding(_Bristle):
    """A bristle whose deflection is damped, LuGre's: σ₁·(1 − z·sgn v)·v besides, damping that is there after a reversal
    and fades as the bristle slides; without it the travel comes out too short.
    """

    richer = SlippingElements

    def samples(self, gap: Gap, site: Site) -> Floats:
        """The bristle's share less the direction of motion, and the rate of its deflection, (n, 2)."""
        bristle, velocity = self.bristle(gap, site), gap.motion.velocity[:, site.joint]
        return np.column_stack([bristle - gap.forward(site.joint), velocity - np.abs(velocity) * bristle])

    def quantities(self, gap: Gap, site: Site) -> tuple[Quantity, ...]:
        """The level that builds up, and the damping."""
        return (Quantity(LEVEL), Quantity(DAMPING))

    def admissible(self, gap: Gap, site: Site, strengths: Floats) -> bool:
        """Deflection is damped, never driven."""
        return super().admissible(gap, site, strengths) and bool(strengths[1] > 0.0)

    def law(self, level: float, travel: float, strengths: Floats) -> tuple[Law, Values]:
        """LuGre's, with no Stribeck curve."""
        curve = {"coulomb": level, "static": level, "stribeck_velocity": 1.0, "stribeck_exponent": 2.0}
        stiff = {"bristle_stiffness": level / travel, "bristle_damping": float(strengths[1]), "viscous": 0.0}
        return LUGRE, curve | stiff
