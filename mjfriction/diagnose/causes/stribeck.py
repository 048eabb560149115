"""friction.stribeck: extra friction near rest that falls away with speed."""

from __future__ import annotations

from collections.abc import Collection
from typing import ClassVar, final

import numpy as np

from mjfriction.diagnose.causes.cause import JointCause, Quantity, Shape, Site, column
from mjfriction.identify.gap import Gap
from mjfriction.laws.law import Law
from mjfriction.laws.lorentzian import LORENTZIAN
from mjfriction.laws.stribeck import STRIBECK
from mjfriction.parameter import Parameter
from mjfriction.record.log import Floats
from mjfriction.robot.friction import stribeck_excess, stribeck_shapes, with_less_stribeck, with_term
from mjfriction.robot.robot import Robot

EXCESS = Parameter("stribeck_excess", "{force}", "friction near rest above the Coulomb level", lower=0.0)
EXPONENTS = (1.0, 2.0)
EXPONENT_RANGE = (0.5, 4.0)
# Least Stribeck velocity, in multiples of the speed below which the direction is in doubt: what fades within less looks
# like a blurred reversal.
SLOWEST = 2.0
GONE_BY = 0.8  # fraction of the top speed by which all but a twentieth must have faded: else it is a bent viscous curve
ALL_OF_IT = 1.25  # multiple of a stated extra level that a fit may take away where there really is none
FASTEST = 0.6  # largest Stribeck velocity, as a fraction of the top speed: what fades later is a bent viscous curve
OF_STEP = 0.97  # fraction of the highest exponent from which on a level falls like a step
# The same as FASTEST where the end of the curve is not seen: what fades later still falls in a straight line, as lower
# damping does.
UNFINISHED = 2.0
FALLEN = 0.3  # least share that has faded at the top speed where the end is not seen: what stays is a level that is off


class Stribeck(JointCause):
    """E·exp(−|v/v_s|^δ)·sgn v with E ≥ 0."""

    name = "friction.stribeck"
    law: ClassVar[Law] = STRIBECK
    fastest: ClassVar[float] = FASTEST
    ends: ClassVar[bool] = True  # whether it has to fade within the motion
    shape_parameters = (STRIBECK.parameter("stribeck_velocity"), STRIBECK.parameter("stribeck_exponent"))

    def sites(self, gap: Gap) -> list[Site]:
        """Every examined joint, with Stribeck velocities spaced logarithmically over what its motion can show, and the
        stated shapes.
        """
        out = []
        for site in super().sites(gap):
            slow, fast = self.shape_bounds(gap, site)[0]
            if fast > 1.5 * slow:
                grid = np.geomspace(slow, fast, 10)
                out += [site.shaped((float(v), d)) for d in EXPONENTS for v in grid]
                out += [site.shaped(shape) for shape in self.stated_shapes(gap, site) if slow < shape[0] < fast]
        return out

    def stated_shapes(self, gap: Gap, site: Site) -> Collection[Shape]:
        """Return the shapes of such curves that are stated at the joint."""
        return stribeck_shapes(gap.robot.table.joint[site.joint])

    def shape_bounds(self, gap: Gap, site: Site) -> list[tuple[float, float]]:
        """The velocities at which a fading level differs from a blurred reversal and from damping; the exponents."""
        top = float(gap.motion.top_speed[site.joint])
        return [(SLOWEST * gap.doubt_speed[site.joint], self.fastest * top), EXPONENT_RANGE]

    def usual_bounds(self, gap: Gap, site: Site) -> list[tuple[float, float]]:
        """The published exponents: few rows at low speed tell poorly how sharply a level falls."""
        return [self.shape_bounds(gap, site)[0], (min(EXPONENTS), max(EXPONENTS))]

    def own_shape(self, gap: Gap, site: Site) -> bool:
        """A level that neither stays and then falls like a step nor, where its end is seen, falls over the whole range
        of speeds; where it is not seen, one that falls within that range.

        Other levels are no Stribeck curves; published exponents end at 2.
        """
        top = float(gap.motion.top_speed[site.joint])
        if self.ends:
            fades = self.faded_at(site) < GONE_BY * top
        else:
            fades = float(self.left_at(np.array([top]), site)[0]) < 1.0 - FALLEN
        return fades and site.shape[1] < OF_STEP * EXPONENT_RANGE[1]

    def left_at(self, speed: Floats, site: Site) -> Floats:
        """Return the share of the extra level that is left at a speed, (n,)."""
        velocity, exponent = site.shape
        return np.exp(-((speed / velocity) ** exponent))

    def faded_at(self, site: Site) -> float:
        """Return the speed at which a twentieth of it is left."""
        velocity, exponent = site.shape
        return float(velocity * 3.0 ** (1.0 / exponent))

    def samples(self, gap: Gap, site: Site) -> Floats:
        """The fading level times the direction of motion, (n, 1)."""
        return column(gap.forward(site.joint) * self.left_at(np.abs(gap.motion.velocity[:, site.joint]), site))

    def quantities(self, gap: Gap, site: Site) -> tuple[Quantity, ...]:
        """The extra level; with a stated shape, the stated level plus the change."""
        stated = gap.robot.table.joint[site.joint]
        there = site.shape in self.stated_shapes(gap, site)
        return (Quantity(EXCESS, shift=stribeck_excess(stated) if there else 0.0),)

    def admissible(self, gap: Gap, site: Site, strengths: Floats) -> bool:
        """The extra level is positive: friction does not grow from rest.

        With a stated shape it may lower the stated extra level, down to zero or, within the error of a fit, a little
        below.
        """
        stated = gap.robot.table.joint[site.joint]
        least = -ALL_OF_IT * stribeck_excess(stated) if site.shape in self.stated_shapes(gap, site) else 0.0
        return bool(strengths[0] > least)

    def brought_level(self, strengths: Floats) -> float:
        """The whole extra level."""
        return float(strengths[0])

    def extend(self, robot: Robot, site: Site, strengths: Floats) -> Robot:
        """Add a Stribeck law that holds only the extra level or, where it is negative, lower the stated one."""
        joint = robot.joints[site.joint]
        if strengths[0] < 0.0:
            return with_less_stribeck(robot, joint, -float(strengths[0]))
        parameters = {
            "coulomb": 0.0,
            "static": float(strengths[0]),
            "stribeck_velocity": site.shape[0],
            "stribeck_exponent": site.shape[1],
            "viscous": 0.0,
        }
        return with_term(robot, joint, self.law.name, parameters)

    def evidence(self, gap: Gap, site: Site, strengths: Floats) -> str:
        """Give the extra level and the speed by which it has faded."""
        sliding = gap.body.sliding[site.joint]
        if strengths[0] < 0.0:
            return (
                f"near rest the drive works against {-strengths[0]:.3g} {'N' if sliding else 'N·m'} less than is stated"
            )
        faded = f"{self.faded_at(site):.3g} {'m/s' if sliding else 'rad/s'}"
        return (
            f"near rest the drive works against {strengths[0]:.3g} {'N' if sliding else 'N·m'} more than at speed, in "
            f"both directions; at {faded} only a twentieth of it is left"
        )


@final
class UnfinishedStribeck(Stribeck):
    """A Stribeck curve whose end the motion does not reach.

    Beside refitted levels it cannot be identified, because a higher level with less damping does nearly as well.  With
    the levels as stated, it may explain by how much these seem to be off.
    """

    fastest = UNFINISHED
    ends = False


@final
class LorentzianStribeck(Stribeck):
    """E/(1 + |v/v_s|^δ)·sgn v: its tail is so long that, told as an exponential, it leaves levels that seem to be off.

    It is tried with the levels as stated, in the place of them and of the curve beside them.
    """

    law = LORENTZIAN
    ends = False

    def stated_shapes(self, gap: Gap, site: Site) -> Collection[Shape]:
        """None: the tail is part of the stated level."""
        return ()

    def left_at(self, speed: Floats, site: Site) -> Floats:
        """Return the share of the extra level that is left at a speed, (n,)."""
        velocity, exponent = site.shape
        return np.asarray(1.0 / (1.0 + (speed / velocity) ** exponent))

    def faded_at(self, site: Site) -> float:
        """Return the speed at which a twentieth of it is left."""
        velocity, exponent = site.shape
        return float(velocity * 19.0 ** (1.0 / exponent))
