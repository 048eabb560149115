"""How the load of each joint of an arm changes as that joint alone moves otherwise."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from mjfriction.body.inverse import motion_derivatives
from mjfriction.body.model import Body
from mjfriction.laws.law import Floats
from mjfriction.record.motion import Motion

# Hz, rate at which quantities that depend on the pose are computed, with linear interpolation between: within one
# period no joint turns far enough for them to be visibly nonlinear.
POSES = 50.0

Slopes = Callable[[Body, Motion], Floats]


def own_slopes(body: Body, motion: Motion) -> Floats:
    """Return how each joint's load changes with its own position, velocity and acceleration, (3, n, joints).

    They are computed at a few samples and interpolated: they change no faster than the pose does, but for what
    accelerations add to the first.
    """
    count, change = motion.time.size, np.flatnonzero(np.diff(motion.piece))
    every = np.arange(0, count, max(1, int(motion.rate / POSES)))
    some = np.unique([*every, *change, *(change + 1), count - 1])
    velocity = motion.velocity[some]
    derivatives = motion_derivatives(body, motion.position[some], velocity, np.zeros_like(velocity))
    told = [np.diagonal(derivative, axis1=1, axis2=2) for derivative in derivatives]
    courses = [[np.interp(np.arange(count), some, own) for own in each.T] for each in told]
    return np.moveaxis(np.array(courses), 1, 2)
