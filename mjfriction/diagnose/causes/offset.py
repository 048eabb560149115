"""drive.offset: a constant added to the effort."""

from __future__ import annotations

from typing import final

import numpy as np

from mjfriction.diagnose.causes.cause import Cause, Quantity, Site
from mjfriction.identify.gap import Gap
from mjfriction.identify.regression import Columns
from mjfriction.parameter import Parameter
from mjfriction.record.log import Floats
from mjfriction.robot.robot import Robot

OFFSET = Parameter("offset", "{force}", "constant in the reported effort")


@final
class Offset(Cause):
    """A constant.  Coulomb levels that differ between the directions have the same effect."""

    name = "drive.offset"
    covariate = "time"
    least_told = 0.06  # on any machine, amplifiers drift by a percent or two of their range

    def columns(self, gap: Gap, site: Site) -> Columns:
        """Ones, added after everything that the sensor does to efforts."""
        return {site.joint: np.ones((gap.chain.time.size, 1))}

    def quantities(self, gap: Gap, site: Site) -> tuple[Quantity, ...]:
        """The offset, stated plus change."""
        stated = gap.robot.table.joint[site.joint].effort_sensor.offset
        return (Quantity(OFFSET, shift=stated, before_sensor=False),)

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
