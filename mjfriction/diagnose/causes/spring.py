"""body.spring: a torque that depends on position, from a balancer, a hose or a cable."""

from __future__ import annotations

from abc import abstractmethod
from typing import ClassVar, final

import numpy as np
from numpy.polynomial import polynomial

from mjfriction.diagnose.causes.cause import JointCause, Quantity, Site
from mjfriction.identify.gap import Gap
from mjfriction.parameter import Parameter
from mjfriction.record.log import Floats
from mjfriction.robot.robot import Robot
from mjfriction.robot.spring import coefficients, plus

PRELOAD = Parameter("preload", "{force}", "torque at position zero")
STIFFNESS = Parameter("stiffness", "{force}/{length}", "torque per position")
QUADRATIC = Parameter("quadratic", "{force}/{length}²", "torque per position squared")
CUBIC = Parameter("cubic", "{force}/{length}³", "torque per position cubed")
LINEAR = ((1, STIFFNESS), (0, PRELOAD))


def _position(gap: Gap, joint: int) -> Floats:
    # Where the joint is by its stated zero: that is what a robot file states a spring over.
    return np.asarray(gap.motion.position[:, joint] - gap.robot.table.joint[joint].position_sensor.offset)


class _Spring(JointCause):
    """A sum of powers of position."""

    name = "body.spring"
    covariate = "position"
    contains = ("drive.offset",)
    least_told = 0.08  # on any machine, hoses, cables and a base that is not quite level make less than this
    parameters: ClassVar[tuple[tuple[int, Parameter], ...]]  # (power, its coefficient), in the order of the strengths

    def samples(self, gap: Gap, site: Site) -> Floats:
        """The powers of position, (n, strengths)."""
        position = _position(gap, site.joint)
        return np.column_stack([position**power for power, _ in self.parameters])

    def quantities(self, gap: Gap, site: Site) -> tuple[Quantity, ...]:
        """The coefficients, stated plus change."""
        stated = coefficients(gap.robot.table.joint[site.joint].spring)
        return tuple(Quantity(parameter, shift=float(stated[power])) for power, parameter in self.parameters)

    def extend(self, robot: Robot, site: Site, strengths: Floats) -> Robot:
        """Add to the joint's spring."""
        joint = robot.table.joint[site.joint]
        return robot.with_joint(joint.model_copy(update={"spring": plus(joint.spring, self._powers(strengths))}))

    def evidence(self, gap: Gap, site: Site, strengths: Floats) -> str:
        """Give the torque over the travelled part of the stroke."""
        low, high = np.quantile(_position(gap, site.joint), [0.02, 0.98])
        powers = self._powers(strengths)
        force, length = ("N", "m") if gap.body.sliding[site.joint] else ("N·m", "rad")
        return self.told(powers, float(low), float(high), force, length)

    def _powers(self, strengths: Floats) -> Floats:
        powers = np.zeros(1 + max(power for power, _ in self.parameters))
        powers[[power for power, _ in self.parameters]] = strengths
        return powers

    @abstractmethod
    def told(self, powers: Floats, low: float, high: float, force: str, length: str) -> str:
        """Describe the torque, a polynomial in position, between two positions."""


@final
class BentSpring(_Spring):
    """A cubic of position: a balancer on a lever, a hose that stiffens."""

    least_cleared = 3.0  # four coefficients fit a part of any error that follows the pose
    parameters = (*LINEAR, (2, QUADRATIC), (3, CUBIC))

    def told(self, powers: Floats, low: float, high: float, force: str, length: str) -> str:
        """Give the torque at both ends and in the middle."""
        places = np.array([low, 0.5 * (low + high), high])
        first, middle, last = polynomial.polyval(places, powers)
        return (
            f"a torque that follows position alone, and bends along the stroke, goes from {first:+.3g} {force} at "
            f"{low:.3g} {length} over {middle:+.3g} at {places[1]:.3g} to {last:+.3g} at {high:.3g}, whichever way the "
            "joint moves"
        )


@final
class Spring(_Spring):
    """k·q + b."""

    parameters = LINEAR
    richer = BentSpring

    def told(self, powers: Floats, low: float, high: float, force: str, length: str) -> str:
        """Give the torque at both ends."""
        ends = polynomial.polyval(np.array([low, high]), powers)
        return (
            f"a torque that follows position alone goes from {ends[0]:+.3g} to {ends[1]:+.3g} {force} between "
            f"{low:.3g} and {high:.3g} {length}, whichever way the joint moves"
        )
