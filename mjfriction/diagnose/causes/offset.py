"""drive.offset: a constant added to the effort."""

from __future__ import annotations

from typing import final

import numpy as np

from mjfriction.diagnose.causes.cause import Cause, Quantity, Site
from mjfriction.identify.gap import Gap
from mjfriction.identify.regression import Columns
from mjfriction.parameter import Parameter
from mjfriction.record.log import Floats
from mjfriction.robot.friction import stated_levels
from mjfriction.robot.robot import Robot

OFFSET = Parameter("offset", "{force}", "constant in the reported effort")
ONE_WAY = 0.05  # of the stated Coulomb level, by which either direction of any machine may differ from it


@final
class Offset(Cause):
    """A constant.  Coulomb levels that differ between the directions have the same effect."""

    name = "drive.offset"
    covariate = "time"

    def columns(self, gap: Gap, site: Site) -> Columns:
        """Ones, added after everything that the sensor does to efforts."""
        return {site.joint: np.ones((gap.chain.time.size, 1))}

    def quantities(self, gap: Gap, site: Site) -> tuple[Quantity, ...]:
        """The offset, stated plus change."""
        stated = gap.robot.table.joint[site.joint].effort_sensor.offset
        return (Quantity(OFFSET, shift=stated, before_sensor=False),)

    def least_change(self, gap: Gap, site: Site) -> float:
        """What Coulomb levels that differ between the directions make on any machine."""
        return ONE_WAY * stated_levels(gap.robot.table.joint[site.joint])[0]

    def extend(self, robot: Robot, site: Site, strengths: Floats) -> Robot:
        """Change the effort sensor's offset."""
        joint = robot.joints[site.joint]
        table = robot.joint(joint)
        offset = table.effort_sensor.offset + float(strengths[0])
        sensor = table.effort_sensor.model_copy(update={"offset": offset})
        return robot.with_joint(table.model_copy(update={"effort_sensor": sensor}))

    def evidence(self, gap: Gap, site: Site, strengths: Floats) -> str:
        """Give the constant beside the joint's effort."""
        unit = "N" if gap.body.sliding[site.joint] else "N·m"
        effort = float(np.sqrt(np.mean(np.square(gap.measured[:, site.joint]))))
        return (
            f"the reported effort stands {strengths[0]:+.3g} {unit} off at every speed and pose "
            f"({100 * abs(strengths[0]) / effort:.2g} % of its RMS)"
        )
