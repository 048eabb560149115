"""The gap between a log and the robot as stated: residuals, their noise, and how far each row can be believed."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mjfriction.body.model import Body
from mjfriction.diagnose.blocks import Blocks, cut_blocks
from mjfriction.diagnose.rows import Chain, make_chain
from mjfriction.record.log import Floats, Log, check_joints
from mjfriction.record.motion import Motion, estimate_motion, raw_noise
from mjfriction.robot.bandwidth import choose_cutoff
from mjfriction.robot.effort import Effort, direction, effort_per_reported, predict_effort
from mjfriction.robot.robot import Robot

DOUBT_SPEED = 0.02  # of a joint's RMS speed: below it no law can be told from its own rounding at zero
DOUBT_PERIODS = 0.6  # of the position filter's cutoff: how far a sign change is blurred


@dataclass(frozen=True)
class Gap:
    """Measured against stated, along one log.

    ``residual`` (rows, joints): reported effort less the stated robot's, N·m or N at the joint, NaN where a joint
    has no measurement.  ``measured`` (rows, joints) is the effort itself.  ``noise_floor`` (joints,) is the effort
    sensor's own noise in the rows' band.  ``doubt`` (rows, joints): what the unknown direction of friction near
    reversals and at rest may add to a row, same unit.  ``doubt_speed`` (joints,): the speed under which that is so.
    ``blocks``: the stretches of motion the rows fall into.  ``per_reported`` (joints,): effort per unit of what the
    drive reports, 1 or N·m/A.
    """

    robot: Robot
    body: Body
    log: Log
    motion: Motion
    effort: Effort
    chain: Chain
    measured: Floats
    residual: Floats
    noise_floor: Floats
    doubt: Floats
    doubt_speed: Floats
    blocks: Blocks
    per_reported: Floats

    @property
    def examined(self) -> tuple[int, ...]:
        """The joints that have a measurement, as indices."""
        return tuple(i for i in range(len(self.robot.joints)) if np.isfinite(self.residual[0, i]))

    def forward(self, joint: int) -> Floats:
        """Return the direction of motion of a joint, −1 to 1, blurred by the velocity's own uncertainty, shape (n,)."""
        probability, _ = direction(self.motion.velocity[:, joint], self.motion.velocity_noise[joint])
        return 2.0 * probability - 1.0


def measure_gap(log: Log, robot: Robot) -> Gap:
    """Hold a log against a robot.

    Raises :class:`LogError` when the log is not of this robot, nothing moves, or it is too short;
    :class:`~mjfriction.errors.RobotError` when the robot's model cannot be read.
    """
    body = robot.body()
    robot = robot.with_stated_friction(body)
    check_joints(log, robot.name, robot.joints)
    motion = estimate_motion(log, robot.joints, choose_cutoff(log, robot, body))
    effort = predict_effort(robot, body, motion)
    chain = make_chain(motion, log.source)
    per_reported = np.array(
        [
            effort_per_reported(joint, quantity, robot.name)
            for joint, quantity in zip(robot.table.joint, motion.quantity, strict=True)
        ]
    )
    measured = chain.rows(motion.torque * per_reported)
    residual = measured - chain.rows(effort.reported)
    noise = [
        abs(per_reported[i]) * raw_noise(log, quantity, joint, motion.clock) if quantity else np.nan
        for i, (joint, quantity) in enumerate(zip(motion.joints, motion.quantity, strict=True))
    ]
    doubt_speed = np.maximum(
        3.0 * motion.velocity_noise, DOUBT_SPEED * np.sqrt(np.mean(np.square(motion.velocity), axis=0))
    )
    return Gap(
        robot=robot,
        body=body,
        log=log,
        motion=motion,
        effort=effort,
        chain=chain,
        measured=measured,
        residual=residual,
        noise_floor=np.array(noise) * chain.noise_gain,
        doubt=_doubt(motion, effort, chain, residual, doubt_speed),
        doubt_speed=doubt_speed,
        blocks=cut_blocks(chain, chain.rows(motion.position), log.source),
        per_reported=per_reported,
    )


def _doubt(motion: Motion, effort: Effort, chain: Chain, residual: Floats, doubt_speed: Floats) -> Floats:
    out = np.empty_like(residual)
    reach = int(np.ceil(DOUBT_PERIODS * motion.rate / motion.cutoff))
    for i in range(residual.shape[1]):
        velocity = motion.velocity[:, i]
        near = np.abs(velocity) < doubt_speed[i]
        turns = np.flatnonzero(np.diff(np.sign(velocity)) != 0)
        for shift in range(-reach, reach + 1):
            near[np.clip(turns + shift, 0, near.size - 1)] = True
        clear = np.abs(effort.friction[~near, i]) if not np.all(near) else np.abs(effort.friction[:, i])
        # Where friction is not stated, the residual itself bounds how much of it there may be.
        level = max(float(np.quantile(clear, 0.25)), float(np.sqrt(np.mean(np.square(residual[:, i])))))
        out[:, i] = level * chain.touched(near)
    return out
