"""What a friction law has to explain at one joint: the rows of effort that the rest of the balance leaves."""

from __future__ import annotations

import functools
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from mjfriction.identify.beside import Beside, FreeOf, free_of
from mjfriction.identify.gap import Gap
from mjfriction.identify.row_noise import row_noise
from mjfriction.identify.starts import Usual
from mjfriction.laws.law import Law
from mjfriction.laws.rules import Values
from mjfriction.record.log import Floats
from mjfriction.robot.friction_tables import FrictionTerm
from mjfriction.robot.rubbing import direction, forward_share, surroundings, term_torque

Side = Literal["joint", "motor"]
NOISE_ROUNDS = 3
OUTLYING = 3.0  # deviations beyond which a residual counts by its size and not by its square


@dataclass(frozen=True)
class Problem:
    """Rows of one joint: ``target`` (rows,) in N·m or N at the joint, each with a standard ``deviation`` (rows,).

    ``gap`` is that of the robot without friction at this joint; ``beside`` holds what else is unknown at the joint.
    """

    gap: Gap
    joint: int
    side: Side
    target: Floats
    deviation: Floats
    beside: Beside

    def term(self, law: Law, values: Values) -> FrictionTerm:
        """Return a law with given values in the form of a robot file."""
        parameters = {name: own if isinstance(own, (int, float)) else tuple(own) for name, own in values.items()}
        return FrictionTerm(law=law.name, side=self.side, parameters=parameters)

    def rows(self, term: FrictionTerm) -> Floats:
        """Return the effort of a friction law, passed through the measurement chain, (rows,)."""
        gap, joint = self.gap, self.gap.robot.table.joint[self.joint]
        ratio = joint.actuator.gear_ratio
        torque = term_torque(term, ratio, gap.motion, self.joint, self._around, self._turned, follow=True)
        return gap.reported(self.joint, torque)

    @functools.cached_property
    def _around(self) -> Floats:
        gap, joint = self.gap, self.joint
        load, rotor = gap.effort.load[:, joint], gap.effort.rotor[:, joint]
        return surroundings(gap.robot.table.joint[joint], gap.motion, joint, load, rotor)

    @functools.cached_property
    def _turned(self) -> tuple[Floats, Floats]:
        motion = self.gap.motion
        return direction(motion.velocity[:, self.joint], motion.sure_speed[:, self.joint])

    def left(self, term: FrictionTerm) -> Floats:
        """Return a law's residual in deviations, with what is unknown beside it projected out, (rows + k,)."""
        return self._free.target((self.target - self.rows(term)) / self.deviation)

    def freed(self, slopes: Floats) -> Floats:
        """Return the derivatives of that residual, (rows + k, m), from the ``slopes`` (rows, m) of the law's rows."""
        return self._free.columns(-slopes / self.deviation[:, None])

    @functools.cached_property
    def _free(self) -> FreeOf:
        return free_of(self.beside, self.deviation)

    def believed(self, residual: Floats) -> Problem:
        """Return the problem with row deviations taken from the noise of a fit's ``residual`` (rows,).

        A residual of more than three deviations counts by its size and not by its square (Huber, Annals of Mathematical
        Statistics 35, 1964): a hand on the arm, or a collision, says nothing about friction.
        """
        noise = float(np.sqrt(np.mean(np.square(residual))))
        for _ in range(NOISE_ROUNDS):
            noise = row_noise(self.gap, self.joint, residual, noise)
        deviation = np.hypot(noise, self.gap.doubt[:, self.joint])
        far = np.maximum(1.0, np.abs(residual) / (OUTLYING * deviation))
        return replace(self, deviation=deviation * np.sqrt(far))

    def usual(self) -> Usual:
        """Return the joint's level and damping by least squares, and its usual speed, stroke and load."""
        gap, joint = self.gap, self.joint
        ratio = abs(gap.robot.table.joint[joint].actuator.gear_ratio) if self.side == "motor" else 1.0
        velocity = gap.motion.velocity[:, joint]
        columns = gap.reported(joint, np.column_stack([forward_share(gap.motion, joint), velocity]))
        weight = 1.0 / self.deviation[:, None]
        level, damping = np.linalg.lstsq(columns * weight, self.target / self.deviation, rcond=None)[0]
        size = float(np.sqrt(np.mean(np.square(self.target))))
        speed = float(np.sqrt(np.mean(np.square(velocity))))
        return Usual(
            level=max(float(level), 0.05 * size) / ratio,
            damping=max(float(damping), 0.01 * size / speed) / ratio**2,
            speed=speed * ratio,
            stroke=float(np.ptp(gap.motion.position[:, joint])) * ratio,
            load=float(np.sqrt(np.mean(np.square(gap.effort.load[:, joint])))) / ratio,
        )
