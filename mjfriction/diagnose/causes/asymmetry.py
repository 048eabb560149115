"""friction.asymmetry: the speed-dependent part of friction differs between the directions, in proportion to speed or
by a curve.
"""

from __future__ import annotations

from typing import final

import numpy as np

from mjfriction.diagnose.causes.cause import Cause, JointCause, Quantity, Site, column
from mjfriction.diagnose.causes.offset import Offset
from mjfriction.identify.gap import Gap
from mjfriction.identify.regression import Columns
from mjfriction.laws.asymmetric_curve import ASYMMETRIC_CURVE
from mjfriction.parameter import Parameter
from mjfriction.record.log import Floats
from mjfriction.robot.friction import with_asymmetric_damping, with_term
from mjfriction.robot.robot import Robot

ASYMMETRY = Parameter(
    "viscous_asymmetry", "{force}·s/{length}", "half the difference of the damping in the two directions"
)


HALF_VELOCITIES = (0.04, 1.5)  # range of the half velocity, as fractions of the top speed


@final
class AsymmetryCurve(JointCause):
    """F_a·|v| + F_b·|v|/(1 + |v|/v_h): the difference of the directions levels off, or grows faster than speed."""

    name = "friction.asymmetry"
    shape_parameters = (ASYMMETRIC_CURVE.parameter("half_velocity"),)

    def shape_bounds(self, gap: Gap, site: Site) -> list[tuple[float, float]]:
        """From where the direction of friction is known to where the curve is hardly bent."""
        slow, fast = (share * float(gap.motion.top_speed[site.joint]) for share in HALF_VELOCITIES)
        return [(min(max(slow, float(gap.doubt_speed[site.joint])), 0.5 * fast), fast)]

    def samples(self, gap: Gap, site: Site) -> Floats:
        """The speed, and the speed that levels off, (n, 2)."""
        speed = np.abs(gap.motion.velocity[:, site.joint])
        return np.column_stack([speed, speed / (1.0 + speed / site.shape[0])])

    def quantities(self, gap: Gap, site: Site) -> tuple[Quantity, ...]:
        """Half the difference of the two dampings, and of the part that levels off."""
        return Quantity(ASYMMETRY), Quantity(ASYMMETRIC_CURVE.parameter("asymmetry"))

    def extend(self, robot: Robot, site: Site, strengths: Floats) -> Robot:
        """Give each direction its own damping, and add a law that holds only the curve."""
        joint = robot.joints[site.joint]
        curve = {"coulomb": 0.0, "viscous": 0.0, "asymmetry": float(strengths[1]), "half_velocity": site.shape[0]}
        return with_term(
            with_asymmetric_damping(robot, joint, float(strengths[0])), joint, ASYMMETRIC_CURVE.name, curve
        )

    def evidence(self, gap: Gap, site: Site, strengths: Floats) -> str:
        """Say in which direction the joint is damped more at two speeds, and by how much."""
        sliding = gap.body.sliding[site.joint]
        length, force = ("m/s", "N") if sliding else ("rad/s", "N·m")
        top = float(gap.motion.top_speed[site.joint])
        parts = []
        for speed in (0.25 * top, top):
            more = 2.0 * speed * float(strengths[0] + strengths[1] / (1.0 + speed / site.shape[0]))
            parts.append(f"{more:+.3g} {force} at {speed:.3g} {length}")
        return f"moving in the positive direction costs more than in the other by {' and '.join(parts)}: a curve"


@final
class Asymmetry(JointCause):
    """F_a·|v|: the damping is F_v + F_a forward and F_v − F_a backward.

    A difference of the Coulomb levels is a constant, the same change as ``drive.offset``, and is reported as that.
    """

    name = "friction.asymmetry"
    kin = ("drive.offset",)
    richer = AsymmetryCurve

    def samples(self, gap: Gap, site: Site) -> Floats:
        """The speed, (n, 1)."""
        return column(np.abs(gap.motion.velocity[:, site.joint]))

    def quantities(self, gap: Gap, site: Site) -> tuple[Quantity, ...]:
        """Half the difference of the two dampings."""
        return (Quantity(ASYMMETRY),)

    def extend(self, robot: Robot, site: Site, strengths: Floats) -> Robot:
        """Give each direction its own damping."""
        joint = robot.joints[site.joint]
        return with_asymmetric_damping(robot, joint, float(strengths[0]))

    def evidence(self, gap: Gap, site: Site, strengths: Floats) -> str:
        """Say in which direction the joint is damped more, and by how much at top speed."""
        speed = float(gap.motion.top_speed[site.joint])
        sliding = gap.body.sliding[site.joint]
        more = "positive" if strengths[0] > 0.0 else "negative"
        return (
            f"at {speed:.3g} {'m/s' if sliding else 'rad/s'} moving in the {more} direction costs "
            f"{2.0 * abs(strengths[0]) * speed:.3g} {'N' if sliding else 'N·m'} more than in the other, "
            "and the difference grows with speed"
        )


@final
class AsymmetryWithOffset(Cause):
    """F_a·|v| and a constant in the place of an offset that the robot states.

    An offset identified with friction that is alike in both directions takes up half of what friction that is not
    leaves, so that the asymmetry alone gains little beside it.
    """

    name = "friction.asymmetry"

    def sites(self, gap: Gap) -> list[Site]:
        """The examined joints for which an offset is stated."""
        return [Site(joint) for joint in gap.examined if gap.robot.table.joint[joint].effort_sensor.offset]

    def columns(self, gap: Gap, site: Site) -> Columns:
        """The columns of both."""
        both = [cause.columns(gap, site)[site.joint] for cause in (Asymmetry(), Offset())]
        return {site.joint: np.hstack(both)}

    def quantities(self, gap: Gap, site: Site) -> tuple[Quantity, ...]:
        """Half the difference of the two dampings, and the offset, stated plus change."""
        return (*Asymmetry().quantities(gap, site), *Offset().quantities(gap, site))

    def extend(self, robot: Robot, site: Site, strengths: Floats) -> Robot:
        """Give each direction its own damping, and change the offset."""
        return Offset().extend(Asymmetry().extend(robot, site, strengths[:1]), site, strengths[1:])

    def evidence(self, gap: Gap, site: Site, strengths: Floats) -> str:
        """Say in which direction the joint is damped more, and what that makes of the offset."""
        offset = Offset().quantities(gap, site)[0].shift
        unit = "N" if gap.body.sliding[site.joint] else "N·m"
        return (
            f"{Asymmetry().evidence(gap, site, strengths[:1])}; the stated offset of {offset:.3g} {unit} made up for "
            f"some of it and is {offset + strengths[1]:.3g} {unit} beside it"
        )
