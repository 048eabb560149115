"""An arbitrary course along the stroke: of the friction level (friction.position), or of a torque that does not change
sign with the direction of motion (body.spring).

These causes do not compete.  They replace waves, a spot or a spring that describe such a course only in part.  A robot
file stores them as waves, the longest of which is twice as long as the stroke.
"""

from __future__ import annotations

from abc import abstractmethod
from typing import ClassVar, final

import numpy as np
from numpy.polynomial import Polynomial

from mjfriction.diagnose.causes.cause import UNCONSTRAINED, JointCause, Quantity, Site
from mjfriction.diagnose.causes.spring import Spring
from mjfriction.diagnose.causes.waves import PositionFriction, as_stated
from mjfriction.identify.gap import Gap
from mjfriction.parameter import Parameter
from mjfriction.record.log import Floats
from mjfriction.robot.friction import with_friction_wave
from mjfriction.robot.robot import Robot
from mjfriction.robot.schema import Joint
from mjfriction.robot.spring import plus
from mjfriction.robot.table import Wave

FINEST = 8  # number of half waves over the stroke in the series of a course
PLACES = 5  # number of positions along the stroke at which the evidence gives the course
MEAN = Parameter("mean", "{force}", "mean of the torque over the stroke")
MIDDLE = Parameter("middle", "{force}", "parabola under the half waves: its torque in the middle of the stroke")
RISE = Parameter("rise", "{force}", "parabola: by how much it rises from the beginning of the stroke to its end")
BOW = Parameter("bow", "{force}", "parabola: four times by how much its ends are above its middle, apart from the rise")
HALF_WAVES = tuple(
    Parameter(f"half_waves_{m}", "{force}", "amplitude of the cosine of which so many half waves are on the stroke")
    for m in range(1, FINEST + 1)
)


class AlongStroke(JointCause):
    """Σ c_m·cos(m·π·(q − q₀)/s), m = 1 … 8, over a stroke s from its end q₀: the series of an even function.

    The shape is (q₀, s); it follows from the motion and is not searched.
    """

    covariate = "position"
    of_unevenness = True
    what: ClassVar[str]  # beginning of its evidence
    under: ClassVar[str] = ""  # what its half waves stand on, for its evidence

    def along(self, gap: Gap, joint: int) -> Site:
        """Return the site on a joint, with the stroke that the joint travelled as its shape."""
        position = gap.motion.position[:, joint]
        return Site(joint, (float(np.min(position)), float(np.ptp(position))))

    def shape_steps(self, gap: Gap, site: Site) -> tuple[float, ...]:
        """None: the stroke is not searched."""
        return ()

    @abstractmethod
    def course(self, site: Site, position: Floats) -> Floats:
        """Return the level or torque per unit of each strength at positions (n,), (n, strengths)."""

    def evidence(self, gap: Gap, site: Site, strengths: Floats) -> str:
        """Give the course at a few positions."""
        force, length = ("N", "m") if gap.body.sliding[site.joint] else ("N·m", "rad")
        low, stroke = site.shape
        places = low + np.linspace(0.0, stroke, PLACES)
        course = self.course(site, places) @ strengths
        told = ", ".join(f"{value:+.3g} at {place:.3g}" for value, place in zip(course, places, strict=True))
        series = f"{self.under}{FINEST} half waves over {stroke:.4g} {length} from {low:.4g} {length}"
        return f"{self.what} along the stroke: {told} ({force}, {length}; {series})"


def travelled(gap: Gap, joint: int) -> bool:
    """Return whether clear rows cover the whole stroke of a joint: a course is undetermined where there are none."""
    position = gap.at_rows("position")[gap.clear[:, joint], joint]
    stroke = gap.motion.position[:, joint]
    count, _ = np.histogram(position, bins=FINEST, range=(float(np.min(stroke)), float(np.max(stroke))))
    return bool(np.all(count > 0))


def half_waves(site: Site, position: Floats) -> Floats:
    """Return the half waves along a site's stroke at positions (n,), (n, 8)."""
    low, stroke = site.shape
    return np.asarray(np.cos(np.outer((position - low) * (np.pi / stroke), np.arange(1, FINEST + 1))))


def _as_waves(table: Joint, site: Site, strengths: Floats) -> list[Wave]:
    low, stroke = site.shape
    numbers = (np.arange(1, FINEST + 1) * (np.pi / stroke)).tolist()
    return [as_stated(table, k, complex(c * np.exp(1j * k * low))) for k, c in zip(numbers, strengths, strict=True)]


@final
class FrictionAlongStroke(AlongStroke):
    """A course of the friction level, as of a rail that is tight at its ends or of a bent screw."""

    name = PositionFriction.name
    least_of_friction = PositionFriction.least_of_friction
    picture = "turned"
    what = "against the motion in both directions, friction differs from its level"

    def samples(self, gap: Gap, site: Site) -> Floats:
        """The half waves times the direction of motion, (n, 8)."""
        return self.course(site, gap.motion.position[:, site.joint]) * gap.forward(site.joint)[:, None]

    def course(self, site: Site, position: Floats) -> Floats:
        """The half waves."""
        return half_waves(site, position)

    def quantities(self, gap: Gap, site: Site) -> tuple[Quantity, ...]:
        """The amplitudes of the half waves."""
        return tuple(Quantity(own) for own in HALF_WAVES)

    def extend(self, robot: Robot, site: Site, strengths: Floats) -> Robot:
        """Add waves to the joint's friction level."""
        name = robot.joints[site.joint]
        for wave in _as_waves(robot.joint(name), site, strengths):
            robot = with_friction_wave(robot, name, wave)
        return robot


class _Torque(AlongStroke):
    """A torque that depends on q: a hose that pulls beyond one position, a cable, a soft stop.

    To the half waves, which are level at both ends of the stroke, it adds powers of u, which goes from −½ at the
    stroke's beginning to ½ at its end.  As in the series of a curve without kinks, amplitudes are expected to fall as
    1/m²: free ones run wild where motion hardly goes.
    """

    name = Spring.name
    contains = Spring.contains
    what = "a torque follows position alone, whichever way the joint moves,"
    powers: ClassVar[tuple[Parameter, ...]]  # coefficients of the powers, the constant first

    def spreads(self) -> Floats:
        """Free powers, and half waves of the effort's size that fall as 1/m²."""
        return np.append(np.full(len(self.powers), UNCONSTRAINED), np.arange(1, FINEST + 1) ** -2.0)

    def samples(self, gap: Gap, site: Site) -> Floats:
        """The powers of u and the half waves, (n, strengths)."""
        return self.course(site, gap.motion.position[:, site.joint])

    def course(self, site: Site, position: Floats) -> Floats:
        """The powers of u and the half waves."""
        low, stroke = site.shape
        powers = np.vander((position - low) / stroke - 0.5, len(self.powers), increasing=True)
        return np.column_stack([powers, half_waves(site, position)])

    def quantities(self, gap: Gap, site: Site) -> tuple[Quantity, ...]:
        """The coefficients of the powers, and the amplitudes of the half waves."""
        return tuple(Quantity(own) for own in (*self.powers, *HALF_WAVES))

    def extend(self, robot: Robot, site: Site, strengths: Floats) -> Robot:
        """Add the powers to the joint's spring, and the half waves to its cogging, which ignores the direction."""
        table = robot.table.joint[site.joint]
        low, stroke = site.shape
        u = Polynomial([(table.position_sensor.offset - low) / stroke - 0.5, 1.0 / stroke])
        count = len(self.powers)
        spring = plus(table.spring, np.asarray(Polynomial(strengths[:count])(u).coef, dtype=float))
        cogging = (*table.cogging, *_as_waves(table, site, strengths[count:]))
        return robot.with_joint(table.model_copy(update={"spring": spring, "cogging": cogging}))


@final
class TorqueAlongStroke(_Torque):
    """A constant and the half waves."""

    powers = (MEAN,)


@final
class RisingAlongStroke(_Torque):
    """A parabola and the half waves: a torque that rises towards an end of the stroke is hardly one of half waves."""

    powers = (MIDDLE, RISE, BOW)
    under = "a parabola and "
