"""What acts beside friction in the balance and is refitted with it: the links' inertias and the efforts' offsets.

Each has a prior about its stated value, as wide as stated values usually are off.  Of the ten parameters of a link only
combinations show in the efforts (:mod:`mjfriction.identify.base_parameters`); what the data do not determine stays as
stated.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from mjfriction.identify.fitted import Fitted
from mjfriction.identify.gap import Gap
from mjfriction.identify.regression import Columns
from mjfriction.record.log import Floats
from mjfriction.robot.robot import Robot

USUAL_OFFSET = 0.1  # of the joint's RMS effort: one standard deviation of how far an effort's zero is off


class Background(Protocol):
    """A part of the balance that is linear in its strengths."""

    @property
    def columns(self) -> Columns:
        """Efforts per unit strength at the joints that it affects."""
        ...

    @property
    def precision(self) -> Floats:
        """One over the prior variance of each strength."""
        ...

    def applied(self, robot: Robot, strengths: Floats) -> Robot:
        """Return the robot with the part changed by its strengths."""
        ...

    def fitted(self, robot: Robot, gram: Floats, covariance: Floats, quantile: float, /) -> list[Fitted]:
        """Return its values as a robot states them, each with an interval of ``quantile`` deviations to either side.

        ``gram`` and ``covariance`` (k, k) are those of its strengths.
        """
        ...


@dataclass(frozen=True)
class OffsetChange:
    """One strength: a constant in the effort of joint ``index``, whose RMS effort is ``size``."""

    index: int
    columns: Columns
    size: float
    unit: str

    @property
    def precision(self) -> Floats:
        """The prior precision, from how far off a zero usually is."""
        return np.array([1.0 / (USUAL_OFFSET * self.size) ** 2])

    def applied(self, robot: Robot, strengths: Floats) -> Robot:
        """Return the robot with its effort sensor's offset changed."""
        joint = robot.table.joint[self.index]
        sensor = joint.effort_sensor.model_copy(update={"offset": joint.effort_sensor.offset + float(strengths[0])})
        return robot.with_joint(joint.model_copy(update={"effort_sensor": sensor}))

    def fitted(self, robot: Robot, _gram: Floats, covariance: Floats, quantile: float) -> list[Fitted]:
        """Return the offset, as a robot states it."""
        joint = robot.table.joint[self.index]
        value, half = joint.effort_sensor.offset, quantile * float(np.sqrt(max(covariance[0, 0], 0.0)))
        meaning = "constant in what the drive reports"
        return [Fitted(f"offset.{joint.name}", meaning, self.unit, value, value - half, value + half)]


def offset_changes(gap: Gap, joints: list[int]) -> list[Background]:
    """Return the offsets of some joints' efforts as parts of the background."""
    out: list[Background] = []
    for joint in joints:
        size = float(np.sqrt(np.mean(np.square(gap.measured[:, joint]))))
        unit = "N" if gap.body.sliding[joint] else "N·m"
        out.append(OffsetChange(joint, {joint: np.ones((gap.measured.shape[0], 1))}, size, unit))
    return out
