"""drive.torque_constant: the measured effort is a constant factor off."""

from __future__ import annotations

from typing import final

from mjfriction.diagnose.causes.cause import JointCause, Quantity, Site, column
from mjfriction.identify.gap import Gap
from mjfriction.parameter import Parameter
from mjfriction.record.log import CURRENT, Floats
from mjfriction.robot.robot import Robot

FACTOR = Parameter("factor", "1", "measured effort over the effort the model says", lower=0.0)

MOST_OFF = 3.0
# Relative error of a data sheet's constant up to which it is usual: magnets vary by several percent, and weaken as they
# warm.
USUALLY_OFF = 0.06
LEAST_OFF = 0.02  # the same of one that was measured


@final
class TorqueConstant(JointCause):
    """ε·(the whole effort that is predicted): the reading is 1 + ε times the effort."""

    name = "drive.torque_constant"
    covariate = "effort"

    def samples(self, gap: Gap, site: Site) -> Floats:
        """The predicted effort of the joint, (n, 1)."""
        return column(gap.known.effort.total[:, site.joint])

    def quantities(self, gap: Gap, site: Site) -> tuple[Quantity, ...]:
        """The factor, 1 where the reading is right."""
        return (Quantity(FACTOR, shift=1.0, before_sensor=False),)

    def admissible(self, gap: Gap, site: Site, strengths: Floats) -> bool:
        """A factor of three or more, or a reversed sign, is a fault of units or wiring, not of a constant."""
        return bool(1.0 / MOST_OFF < 1.0 + strengths[0] < MOST_OFF)

    def usual(self, gap: Gap, site: Site, strengths: Floats) -> bool:
        """No more than the few percent that any motor's constant is off."""
        return bool(abs(strengths[0]) < USUALLY_OFF)

    def least_change(self, gap: Gap, site: Site) -> float:
        """What a constant and a current sensor are known to at best."""
        return LEAST_OFF

    def extend(self, robot: Robot, site: Site, strengths: Floats) -> Robot:
        """Scale the effort sensor.

        For a reading in amperes the factor is the torque constant's: the true one is the stated one divided by it.  The
        robot file keeps the stated constant and stores the factor, so that it holds for either kind of log.
        """
        joint = robot.joints[site.joint]
        table = robot.joint(joint)
        scale = table.effort_sensor.scale * (1.0 + float(strengths[0]))
        sensor = table.effort_sensor.model_copy(update={"scale": scale})
        return robot.with_joint(table.model_copy(update={"effort_sensor": sensor}))

    def evidence(self, gap: Gap, site: Site, strengths: Floats) -> str:
        """Give the factor, and for currents the torque constant it means."""
        factor = 1.0 + float(strengths[0])
        constant = gap.robot.table.joint[site.joint].actuator.torque_constant
        if gap.motion.quantity[site.joint] == CURRENT and constant is not None:
            return (
                f"currents read {factor:.3g} times what the model needs at every load: if the gear ratio is right, the "
                f"torque constant is {constant / factor:.3g} N·m/A, not {constant:.3g}"
            )
        return f"the reported effort is {factor:.3g} times what the model needs, at every load"
