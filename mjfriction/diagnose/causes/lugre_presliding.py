"""friction.presliding: the stated Stribeck curve builds up over some travel too, as in the LuGre law."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Mapping
from typing import ClassVar, final

import numpy as np

from mjfriction.diagnose.causes.cause import Quantity, Site, column
from mjfriction.diagnose.causes.presliding import DAMPING, LEVEL, Bristle, DampedPresliding, Presliding
from mjfriction.identify.gap import Gap
from mjfriction.laws.lugre import LUGRE
from mjfriction.laws.rules import scalar
from mjfriction.laws.stribeck import STRIBECK
from mjfriction.record.log import Floats
from mjfriction.robot.friction import (
    coulomb_level,
    raised_levels,
    stated_levels,
    stribeck_excess,
    stribeck_shapes,
    terms,
    with_term,
)
from mjfriction.robot.friction_tables import FrictionTerm
from mjfriction.robot.robot import Robot
from mjfriction.robot.schema import Joint

Curve = tuple[float, float, float]  # excess near rest, relative to the Coulomb level; Stribeck velocity; exponent
NO_CURVE: Curve = (0.0, 1.0, 2.0)
# Largest level that builds up, relative to the stated one: with more, the curve that is stated is none of its own.
MOST_OF_STATED = 1.5


def stated_curve(joint: Joint) -> Curve | None:
    """Return the Stribeck curve of a joint's one law with such a curve, averaged over the directions; None where there
    is no such law or another one, or where it has no level or no excess.

    A curve that was found holds the excess alone.
    """
    whole = [term for term in terms(joint) if _has_level(term)]
    if len(whole) != 1:
        return None
    alone = joint.model_copy(update={"friction": tuple(whole)})
    excess, (shape,) = stribeck_excess(alone), stribeck_shapes(alone)
    return (excess / stated_levels(joint)[0], *shape) if excess > 0.0 else None


def _lugre(level: float, travel: float, curve: Curve, damping: float) -> dict[str, float]:
    share, velocity, exponent = curve
    return {
        "coulomb": level,
        "static": level * (1.0 + share),
        "stribeck_velocity": velocity,
        "stribeck_exponent": exponent,
        "bristle_stiffness": level / travel,
        "bristle_damping": damping,
        "viscous": 0.0,
    }


class LuGreBristle(Bristle):
    """A part E of the Coulomb level and as large a part of the stated Stribeck curve follow a bristle: E·(z − s·sgn v),
    where dz/dx = (1 − z·sgn v/s)/x₀ and s(v) is the level at speed, relative to Coulomb's.

    One contact makes both.  Were the curve to act at once, what it adds at every reversal would be left as an error.
    """

    alone: ClassVar[type[Bristle]]  # the bristle of the level alone

    def sites(self, gap: Gap) -> list[Site]:
        """Joints as of any bristle that state such a curve, the same in both directions."""
        table = gap.robot.table.joint
        able = [
            joint for joint, own in enumerate(table) if stated_curve(own) and not any(t.negative for t in terms(own))
        ]
        return [site for site in super().sites(gap) if site.joint in able]

    def curve(self, gap: Gap, site: Site) -> Curve:
        """Return the curve stated at the site's joint."""
        curve = stated_curve(gap.robot.table.joint[site.joint])
        assert curve is not None, "sites names joints that state one"
        return curve

    def built_up(self, gap: Gap, site: Site) -> Floats:
        """Return z, how much of the level has built up, relative to Coulomb's, (n,)."""
        return self.followed(gap, site, LUGRE, _lugre(1.0, site.shape[0], self.curve(gap, site), 0.0))

    def level_at_speed(self, gap: Gap, site: Site) -> Floats:
        """Return s, the level at the present speed relative to the Coulomb level, (n,)."""
        share, velocity, exponent = self.curve(gap, site)
        return np.asarray(1.0 + share * np.exp(-((np.abs(gap.motion.velocity[:, site.joint]) / velocity) ** exponent)))

    def behind(self, gap: Gap, site: Site) -> Floats:
        """Return z − s·sgn v, (n,)."""
        return self.built_up(gap, site) - self.level_at_speed(gap, site) * gap.forward(site.joint)

    def admissible(self, gap: Gap, site: Site, strengths: Floats) -> bool:
        """Also, it is not much more than the level whose curve is stated."""
        most = MOST_OF_STATED * stated_levels(gap.robot.table.joint[site.joint])[0]
        return self.taken_level(strengths) < most and super().admissible(gap, site, strengths)

    def moved(self, robot: Robot, joint: str, level: float, travel: float, strengths: Floats) -> Robot:
        """Move the level, and as large a part of the curve, into the LuGre law."""
        curve = stated_curve(robot.joint(joint))
        values = _lugre(level, travel, curve or NO_CURVE, self.damping(strengths))
        if curve is not None:
            robot = _with_less_of_curve(robot, joint, level / stated_levels(robot.joint(joint))[0])
        return with_term(raised_levels(robot, joint, -level, 0.0), joint, LUGRE.name, values)

    @abstractmethod
    def damping(self, strengths: Floats) -> float:
        """Return the damping of the bristle's deflection, N·m·s/rad or N·s/m."""


@final
class LuGrePresliding(LuGreBristle):
    """A bristle without damping."""

    alone = Presliding

    def samples(self, gap: Gap, site: Site) -> Floats:
        """How far the level is from built up, (n, 1)."""
        return column(self.behind(gap, site))

    def quantities(self, gap: Gap, site: Site) -> tuple[Quantity, ...]:
        """The level that builds up."""
        return (Quantity(LEVEL),)

    def damping(self, strengths: Floats) -> float:
        """None."""
        return 0.0


@final
class DampedLuGrePresliding(LuGreBristle):
    """A bristle whose deflection is damped: in addition σ₁·(1 − z·sgn v/s)·v."""

    alone = DampedPresliding

    def samples(self, gap: Gap, site: Site) -> Floats:
        """How far the level is from built up, and the rate of the deflection, (n, 2)."""
        velocity = gap.motion.velocity[:, site.joint]
        rate = velocity - np.abs(velocity) * self.built_up(gap, site) / self.level_at_speed(gap, site)
        return np.column_stack([self.behind(gap, site), rate])

    def quantities(self, gap: Gap, site: Site) -> tuple[Quantity, ...]:
        """The level that builds up, and the damping."""
        return (Quantity(LEVEL), Quantity(DAMPING))

    def admissible(self, gap: Gap, site: Site, strengths: Floats) -> bool:
        """Also, the deflection is damped, never driven."""
        return super().admissible(gap, site, strengths) and bool(strengths[1] > 0.0)

    def damping(self, strengths: Floats) -> float:
        """As fitted."""
        return float(strengths[1])


def _with_less_of_curve(robot: Robot, joint: str, share: float) -> Robot:
    # The curve that is stated, and none that was found, loses this share of its excess.
    table = robot.joint(joint)

    def less(values: Mapping[str, float | tuple[float, ...]]) -> dict[str, float | tuple[float, ...]]:
        coulomb, static = scalar(values, "coulomb"), scalar(values, "static")
        return {**values, "static": coulomb + (1.0 - share) * (static - coulomb)}

    def lowered(term: FrictionTerm) -> FrictionTerm:
        if not _has_level(term):
            return term
        negative = None if term.negative is None else less({**term.parameters, **term.negative})
        return term.model_copy(update={"parameters": less(term.parameters), "negative": negative})

    return robot.with_joint(table.model_copy(update={"friction": tuple(map(lowered, terms(table)))}))


def _has_level(term: FrictionTerm) -> bool:
    return term.law == STRIBECK.name and coulomb_level(term) > 0.0
