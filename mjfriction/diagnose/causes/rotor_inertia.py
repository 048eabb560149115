"""drive.rotor_inertia: a torque that follows the acceleration of one joint alone."""

from __future__ import annotations

from typing import final

import numpy as np

from mjfriction.diagnose.causes.cause import JointCause, Quantity, Site, column
from mjfriction.identify.gap import Gap
from mjfriction.parameter import Parameter
from mjfriction.record.log import Floats
from mjfriction.robot.robot import Robot

LEAST_NOTED = 0.04  # change relative to the stated inertia above which it is a finding
USUALLY_OFF = 0.08  # usual relative error of a stated inertia where everything else is off too
LEAST_STATED = 1e-12  # kg·m² or kg, floor of the stated inertia in relative changes

ROTOR_INERTIA = Parameter("rotor_inertia", "kg·m²", "inertia of the rotor, at the motor", lower=0.0)


@final
class RotorInertia(JointCause):
    """ΔJ·gear_ratio²·q̈."""

    name = "drive.rotor_inertia"
    covariate = "acceleration"
    brief_in_passes = True

    def samples(self, gap: Gap, site: Site) -> Floats:
        """The joint's acceleration, (n, 1)."""
        return column(gap.motion.acceleration[:, site.joint])

    def quantities(self, gap: Gap, site: Site) -> tuple[Quantity, ...]:
        """The rotor's inertia at the motor, stated plus change."""
        actuator = gap.robot.table.joint[site.joint].actuator
        return (Quantity(ROTOR_INERTIA, 1.0 / actuator.gear_ratio**2, actuator.rotor_inertia),)

    def admissible(self, gap: Gap, site: Site, strengths: Floats) -> bool:
        """A rotor has no negative inertia."""
        actuator = gap.robot.table.joint[site.joint].actuator
        return bool(actuator.rotor_inertia + strengths[0] / actuator.gear_ratio**2 >= 0.0)

    def noteworthy(self, gap: Gap, site: Site, strengths: Floats) -> bool:
        """More than a few percent of the stated inertia."""
        return self._change(gap, site, strengths) > LEAST_NOTED

    def usual(self, gap: Gap, site: Site, strengths: Floats) -> bool:
        """No more than a data sheet is off, which does not include the coupling and the gear."""
        return self._change(gap, site, strengths) < USUALLY_OFF

    def _change(self, gap: Gap, site: Site, strengths: Floats) -> float:
        # The size of the change, relative to what is stated.
        stated = gap.robot.table.joint[site.joint].actuator.reflected_inertia
        return abs(float(strengths[0])) / max(stated, LEAST_STATED)

    def extend(self, robot: Robot, site: Site, strengths: Floats) -> Robot:
        """Change the rotor inertia of the joint's actuator."""
        joint = robot.joints[site.joint]
        table = robot.joint(joint)
        inertia = table.actuator.rotor_inertia + float(strengths[0]) / table.actuator.gear_ratio**2
        actuator = table.actuator.model_copy(update={"rotor_inertia": inertia})
        return robot.with_joint(table.model_copy(update={"actuator": actuator}))

    def evidence(self, gap: Gap, site: Site, strengths: Floats) -> str:
        """Give the effort at hard acceleration."""
        hard = float(np.quantile(np.abs(gap.motion.acceleration[:, site.joint]), 0.99))
        sliding = gap.body.sliding[site.joint]
        return (
            f"accelerating at {hard:.3g} {'m/s²' if sliding else 'rad/s²'} takes {strengths[0] * hard:+.3g} "
            f"{'N' if sliding else 'N·m'} besides the links, in this joint alone"
        )
