"""sensor.delay: effort and motion are shifted in time against each other, on one joint or on all alike."""

from __future__ import annotations

from dataclasses import replace
from typing import final

import numpy as np

from mjfriction.diagnose.causes.cause import JointCause, Quantity, Site, column, near_around
from mjfriction.identify.gap import Gap
from mjfriction.identify.regression import Columns
from mjfriction.parameter import Parameter
from mjfriction.record.log import Floats
from mjfriction.robot.effort import later
from mjfriction.robot.robot import Robot

DELAY = Parameter("delay", "s", "time by which the reported effort comes after the motion it belongs to")
# s; drives report efforts through filters that take about as long, and positions through shorter ones.
USUALLY_LATE, USUALLY_EARLY = 0.003, 0.0015
LONGEST = 0.25  # s; a longer delay means that the clocks differ
GRID = (0.0, 0.015, 0.025, 0.04, 0.06, 0.09, 0.13, 0.2, -0.015, -0.03, -0.06, -0.12)  # s
FINER = 1.6  # about one step of the grid, as a ratio
NEAR = 0.6  # largest relative difference of the fitted delay from the one that its columns were computed for


def late(gap: Gap, effort: Floats, delay: float) -> Floats:
    """Return the change of an effort (n,) per second of delay, piece by piece: a secant, for zero delay the tangent."""
    out = np.empty_like(gap.motion.time)
    for own in gap.motion.pieces:
        part, time = effort[own], gap.motion.time[own]
        if delay == 0.0:
            out[own] = -np.gradient(part) * gap.motion.rate
        else:
            out[own] = (np.interp(time - delay, time, part) - part) / delay
    return out


def _delayed(robot: Robot, joint: str, delay: float) -> Robot:
    return robot.with_joint(later(robot.joint(joint), delay))


class _Delay(JointCause):
    """The effort from a time d ago in place of the present one.

    It is first linearised by the secant to the nearest of a grid of delays, then fitted on the shifted effort itself.
    """

    name = "sensor.delay"
    covariate = "time"
    picture = "loop"
    curved = True
    of_sensor = True

    def samples(self, gap: Gap, site: Site) -> Floats:
        """The predicted effort's change per second of delay, (n, 1)."""
        return column(late(gap, gap.known.effort.total[:, site.joint], site.around))

    def quantities(self, gap: Gap, site: Site) -> tuple[Quantity, ...]:
        """The delay, stated plus change."""
        stated = gap.robot.table.joint[site.joint].effort_sensor.delay
        return (Quantity(DELAY, shift=stated, before_sensor=False),)

    def admissible(self, gap: Gap, site: Site, strengths: Floats) -> bool:
        """At most a quarter of a second either way, and near the delay that the columns were computed for."""
        near = site.around == 0.0 or abs(strengths[0] / site.around - 1.0) < NEAR
        return bool(near and abs(strengths[0]) < LONGEST)

    def around_sites(self, gap: Gap, site: Site) -> list[Site]:
        """Delays up to the neighbours on the grid; none around zero delay."""
        return near_around(site, FINER) if site.around else []

    def noteworthy(self, gap: Gap, site: Site, strengths: Floats) -> bool:
        """At least one sample, and more than the filter of any drive takes: of an early effort, that of its positions.

        A shift of less than a sample is an effect of sampling: a command, for example, acts over the step that follows.
        """
        usual = USUALLY_LATE if strengths[0] > 0.0 else USUALLY_EARLY
        return bool(abs(strengths[0]) >= max(gap.motion.clock.step, usual))


@final
class JointDelay(_Delay):
    """One joint's effort is reported late."""

    def sites(self, gap: Gap) -> list[Site]:
        """Every examined joint, around every delay of the grid."""
        return [replace(site, around=delay) for site in super().sites(gap) for delay in GRID]

    def extend(self, robot: Robot, site: Site, strengths: Floats) -> Robot:
        """Change the delay of the joint's effort sensor."""
        joint = robot.joints[site.joint]
        return _delayed(robot, joint, float(strengths[0]))

    def evidence(self, gap: Gap, site: Site, strengths: Floats) -> str:
        """Give the delay."""
        return f"the reported effort comes {1e3 * strengths[0]:.3g} ms after the motion it belongs to"


@final
class LogDelay(_Delay):
    """All joints' efforts are late by the same time."""

    whole_arm = True

    def sites(self, gap: Gap) -> list[Site]:
        """The joint whose effort changes most relative to its noise; none with a single joint, which shares nothing."""
        if len(gap.examined) < 2:
            return []
        felt = {j: float(np.std(self.columns(gap, Site(j))[j]) / max(gap.noise_floor[j], 1e-12)) for j in gap.examined}
        most = max(felt, key=lambda joint: felt[joint])
        return [Site(most, around=delay) for delay in GRID]

    def columns(self, gap: Gap, site: Site) -> Columns:
        """Every examined joint's column."""
        key = f"{self.name} {site.around}"

        def made() -> Columns:
            places = {j: replace(site, joint=j) for j in gap.examined}
            return {j: gap.reported(j, self.samples(gap, place)) for j, place in places.items()}

        return gap.kept.recall(key, made)

    def extend(self, robot: Robot, site: Site, strengths: Floats) -> Robot:
        """Change the delay of every joint's effort sensor."""
        for name in robot.joints:
            robot = _delayed(robot, name, float(strengths[0]))
        return robot

    def evidence(self, gap: Gap, site: Site, strengths: Floats) -> str:
        """Give the delay."""
        return f"the efforts of all joints come {1e3 * strengths[0]:.3g} ms after the motion they belong to"
