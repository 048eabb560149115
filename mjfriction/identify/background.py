"""What stands beside friction in the balance and is refitted with it: the links' inertias and the efforts' offsets.

Each link gets a scale of its mass and inertia and a shift of its centre of mass, each effort a constant, held near what
is stated by how far stated values usually are off.  Of the ten parameters of a link only combinations show in the
efforts; what the data do not fix stays as stated.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from mjfriction.identify.fitted import Fitted
from mjfriction.identify.gap import Gap
from mjfriction.identify.regression import Columns
from mjfriction.record.log import Floats
from mjfriction.robot.links import link_scale, link_shift, scaled_link, shifted_link
from mjfriction.robot.robot import Robot

USUAL_SCALE = 0.10  # one standard deviation of how far a stated mass and inertia are off
USUAL_SHIFT = 0.02  # m, and a stated centre of mass
USUAL_OFFSET = 0.1  # of the joint's RMS effort, and an effort's zero
FELT = 1e-6  # of the effort, below which a link is not felt
SMALLEST, LARGEST = -0.9, 9.0  # change of a mass that a link can have


class Background(Protocol):
    """A part of the balance that is linear in its strengths."""

    @property
    def columns(self) -> Columns:
        """Efforts per unit strength at the joints that feel it."""
        ...

    @property
    def precision(self) -> Floats:
        """One over the variance known beforehand of each strength."""
        ...

    def applied(self, robot: Robot, strengths: Floats) -> Robot:
        """Return the robot with the part changed by its strengths."""
        ...

    def fitted(self, robot: Robot, half: Floats) -> list[Fitted]:
        """Return its values as they stand in a robot, with the half-widths of their 95 % intervals."""
        ...


@dataclass(frozen=True)
class LinkChange:
    """Four strengths of the link that joint ``name`` moves: its scale, and its shifts along x, y and z (m)."""

    name: str
    columns: Columns

    @property
    def precision(self) -> Floats:
        """By how far stated links usually are off."""
        return np.array([USUAL_SCALE**-2.0, *[USUAL_SHIFT**-2.0] * 3])

    def applied(self, robot: Robot, strengths: Floats) -> Robot:
        """Scale the link and move its centre."""
        factor = 1.0 + float(np.clip(strengths[0], SMALLEST, LARGEST))
        return shifted_link(scaled_link(robot, self.name, factor), self.name, strengths[1:].tolist())

    def fitted(self, robot: Robot, half: Floats) -> list[Fitted]:
        """The scale, and the shifts."""
        scale, shift = link_scale(robot, self.name), link_shift(robot, self.name)
        meaning = "mass and inertia of the link that the joint moves, relative to the model file"
        out = [_fitted(f"link_scale.{self.name}", meaning, "1", scale, scale * float(half[0]))]
        for axis, value, own in zip("xyz", shift, half[1:].tolist(), strict=True):
            meaning = f"shift of the centre of mass along {axis}"
            out.append(_fitted(f"link_shift_{axis}.{self.name}", meaning, "m", value, own))
        return out


@dataclass(frozen=True)
class OffsetChange:
    """One strength: a constant in the effort of joint ``index``, whose RMS effort is ``size``."""

    index: int
    columns: Columns
    size: float
    unit: str

    @property
    def precision(self) -> Floats:
        """By how far a zero usually is off."""
        return np.array([1.0 / (USUAL_OFFSET * self.size) ** 2])

    def applied(self, robot: Robot, strengths: Floats) -> Robot:
        """Move the effort sensor's zero."""
        joint = robot.table.joint[self.index]
        sensor = joint.effort_sensor.model_copy(update={"offset": joint.effort_sensor.offset + float(strengths[0])})
        return robot.with_joint(joint.model_copy(update={"effort_sensor": sensor}))

    def fitted(self, robot: Robot, half: Floats) -> list[Fitted]:
        """The offset."""
        joint = robot.table.joint[self.index]
        meaning = "constant in what the drive reports"
        return [_fitted(f"offset.{joint.name}", meaning, self.unit, joint.effort_sensor.offset, float(half[0]))]


def link_changes(gap: Gap) -> list[Background]:
    """Return every link that is felt."""
    size = float(np.sqrt(np.mean(np.square(np.nan_to_num(gap.measured)))))
    out: list[Background] = []
    for k, name in enumerate(gap.body.links):
        block = {joint: rows[:, k] for joint, rows in gap.link_rows.items()}
        if any(np.max(np.abs(columns)) > FELT * size for columns in block.values()):
            out.append(LinkChange(name, block))
    return out


def offset_changes(gap: Gap, joints: list[int]) -> list[Background]:
    """Return the zeros of some joints' efforts."""
    out: list[Background] = []
    for joint in joints:
        size = float(np.sqrt(np.mean(np.square(gap.measured[:, joint]))))
        unit = "N" if gap.body.sliding[joint] else "N·m"
        out.append(OffsetChange(joint, {joint: np.ones((gap.measured.shape[0], 1))}, size, unit))
    return out


def _fitted(name: str, meaning: str, unit: str, value: float, half: float) -> Fitted:
    return Fitted(name, meaning, unit, value, value - half, value + half)
