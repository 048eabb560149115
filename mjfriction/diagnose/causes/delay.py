"""sensor.delay: effort and motion are shifted in time against each other, on one joint or on all alike."""

from __future__ import annotations

from typing import final

import numpy as np

from mjfriction.diagnose.causes.cause import Cause, Quantity, Site, column
from mjfriction.diagnose.gap import Gap
from mjfriction.diagnose.regression import Columns
from mjfriction.parameter import Parameter
from mjfriction.record.log import Floats
from mjfriction.robot.robot import Robot

DELAY = Parameter("delay", "s", "time by which the reported effort comes after the motion it belongs to")
LONGEST = 0.25  # s; a longer one is another clock


def _late(gap: Gap, joint: int) -> Floats:
    # To first order effort(t − d) = effort(t) − d·(its rate); pieces are apart, and so are their rates.
    out = np.empty_like(gap.motion.time)
    for piece in np.unique(gap.motion.piece):
        own = gap.motion.piece == piece
        out[own] = -np.gradient(gap.effort.total[own, joint]) * gap.motion.rate
    return out


def _delayed(robot: Robot, joint: str, delay: float) -> Robot:
    table = robot.joint(joint)
    sensor = table.effort_sensor.model_copy(update={"delay": table.effort_sensor.delay + delay})
    return robot.with_joint(table.model_copy(update={"effort_sensor": sensor}))


class _Delay(Cause):
    """−d·dτ/dt to first order; then fitted on the shifted effort itself."""

    name = "sensor.delay"
    covariate = "time"
    before_sensor = False
    curved = True

    def samples(self, gap: Gap, site: Site) -> Floats:
        """The rate of the stated effort, turned, (n, 1)."""
        return column(gap.robot.table.joint[site.joint].effort_sensor.scale * _late(gap, site.joint))

    def quantities(self, gap: Gap, site: Site) -> tuple[Quantity, ...]:
        """The delay, stated plus change."""
        return (Quantity(DELAY, shift=gap.robot.table.joint[site.joint].effort_sensor.delay),)

    def admissible(self, gap: Gap, site: Site, strengths: Floats) -> bool:
        """A shift of a quarter of a second either way at most."""
        return bool(abs(strengths[0]) < LONGEST)

    def noteworthy(self, gap: Gap, site: Site, strengths: Floats) -> bool:
        """A shift of less than one sample is how a log is sampled: a command, say, acts over the step that follows."""
        return bool(abs(strengths[0]) >= gap.motion.clock.step)


@final
class JointDelay(_Delay):
    """One joint's effort comes late."""

    def columns(self, gap: Gap, site: Site) -> Columns:
        """The joint's own column."""
        return {site.joint: gap.chain.rows(self.samples(gap, site))}

    def extend(self, robot: Robot, site: Site, strengths: Floats) -> Robot:
        """Move the delay of the joint's effort sensor."""
        joint = robot.joints[site.joint]
        return _delayed(robot, joint, float(strengths[0]))

    def evidence(self, gap: Gap, site: Site, strengths: Floats) -> str:
        """Give the delay."""
        return f"the reported effort comes {1e3 * strengths[0]:.3g} ms after the motion it belongs to"


@final
class LogDelay(_Delay):
    """All joints' efforts come late alike."""

    whole_arm = True

    def sites(self, gap: Gap) -> list[Site]:
        """Once, where effort changes most; with a single joint there is nothing to share."""
        if len(gap.examined) < 2:
            return []
        felt = {j: float(np.std(self.columns(gap, Site(j))[j]) / max(gap.noise_floor[j], 1e-12)) for j in gap.examined}
        return [Site(max(felt, key=lambda joint: felt[joint]))]

    def columns(self, gap: Gap, site: Site) -> Columns:
        """Every examined joint's column."""
        if self.name not in gap.kept:
            gap.kept[self.name] = {j: gap.chain.rows(self.samples(gap, Site(j))) for j in gap.examined}
        return gap.kept[self.name]

    def extend(self, robot: Robot, site: Site, strengths: Floats) -> Robot:
        """Move the delay of every joint's effort sensor."""
        for name in robot.joints:
            robot = _delayed(robot, name, float(strengths[0]))
        return robot

    def evidence(self, gap: Gap, site: Site, strengths: Floats) -> str:
        """Give the delay."""
        return f"the efforts of all joints come {1e3 * strengths[0]:.3g} ms after the motion they belong to"
