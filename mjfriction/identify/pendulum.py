"""Friction from passes in one direction, with gravity removed as a pendulum's; passes both ways make this unnecessary.

While all other joints stand still, gravity acts on a turning joint as on a pendulum, a·sin q + b·cos q.  The two
numbers are those of the stated model, or come from least squares beside a level and a damping (Indri and others,
section 3.2).  What is then left of passes forward and of passes backward should be the same friction; the difference of
the two is the pendulum's error.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from mjfriction.body.model import Body
from mjfriction.identify.phases import Phase
from mjfriction.record.log import Floats
from mjfriction.record.motion import Motion
from mjfriction.robot.links_torque import held_torque, links_torque
from mjfriction.robot.robot import Robot

CUTOFF = 10.0  # Hz, of the efforts of a pass
FEWEST = 3  # phases each way


@dataclass(frozen=True)
class ByPendulum:
    """A joint's friction (k, 2), N·m, at the speeds (k,), rad/s, of its phases ``forward`` and ``backward``.

    The first column is by the stated model's pendulum, the second by the fitted one.
    """

    forward: Floats
    forward_friction: Floats
    backward: Floats
    backward_friction: Floats

    @property
    def apart(self) -> Floats:
        """Half the difference of the two directions' friction, RMS over the speeds that both have, (2,)."""
        low = max(float(np.min(self.forward)), float(np.min(self.backward)))
        high = min(float(np.max(self.forward)), float(np.max(self.backward)))
        speed = self.forward[(self.forward >= low) & (self.forward <= high)]
        there, back = (
            np.column_stack([np.interp(speed, own, friction[:, k]) for k in range(2)])
            for own, friction in ((self.forward, self.forward_friction), (self.backward, self.backward_friction))
        )
        return np.asarray(np.sqrt(np.mean(np.square(0.5 * (there - back)), axis=0)))


def by_pendulum(
    motion: Motion, torque: Floats, robot: Robot, body: Body, phases: Sequence[Phase], joint: int
) -> ByPendulum | None:
    """Return a joint's friction by pendulums, None for a sliding joint or one with fewer than three phases each way.

    ``torque`` (n,) is the joint's effort along the motion, N·m.
    """
    own = [phase for phase in phases if phase.joint == joint]
    ways = [sum(phase.velocity > 0.0 for phase in own), sum(phase.velocity < 0.0 for phase in own)]
    if body.sliding[joint] or min(ways) < FEWEST:
        return None
    smooth = motion.low_passed(torque, CUTOFF)
    samples = np.concatenate([np.arange(phase.first, phase.past) for phase in own])
    which = np.repeat(np.arange(len(own)), [phase.past - phase.first for phase in own])
    place = motion.position[samples, joint]
    waves = np.column_stack([np.sin(place), np.cos(place)])
    velocity = np.array([phase.velocity for phase in own])
    friction = np.column_stack([np.sign(velocity), velocity])[which]
    still = replace(motion, velocity=0.0 * motion.velocity, acceleration=0.0 * motion.acceleration)
    # What the arm held for a while is known, and not part of the pendulum.
    model, held = (torques(robot, body, still)[samples, joint] for torques in (links_torque, held_torque))
    numbers = np.linalg.lstsq(np.hstack([waves, friction]), smooth[samples] - held, rcond=None)[0]
    gravity = np.column_stack([model, waves @ numbers[:2] + held])
    count = np.bincount(which)
    left = np.column_stack([np.bincount(which, smooth[samples] - own_gravity) / count for own_gravity in gravity.T])
    left *= np.sign(velocity)[:, None]
    parts = []
    for way in (1.0, -1.0):
        order = np.flatnonzero(np.sign(velocity) == way)
        order = order[np.argsort(np.abs(velocity[order]), kind="stable")]
        parts += [np.abs(velocity[order]), left[order]]
    return ByPendulum(*parts)
