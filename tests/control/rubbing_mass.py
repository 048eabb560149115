"""A mass that rubs, moved by a known force, stepped finely: what observers are held against."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mjfriction.laws.ambient import ambient
from mjfriction.laws.friction import Friction

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Ran:
    step: float
    position: Floats
    velocity: Floats
    force: Floats
    friction: Floats


def run(mass: float, law: Friction, force: Floats, step: float, *, finer: int = 10, velocity: float = 0.0) -> Ran:
    """Push a mass with a force held through each step; friction at the end of every inner step, symplectic Euler."""
    h, state, x, v = step / finer, np.zeros(law.state_count), 0.0, velocity
    out = np.empty((force.size, 3))
    around = ambient(1)
    friction = 0.0
    for i, pushed in enumerate(force):
        out[i] = x, v, friction
        for _ in range(finer):
            torque, states = law.follow(np.array([v]), around, h, state)
            state, friction = states[0], float(torque[0])
            v += h * (pushed - friction) / mass
            x += h * v
    return Ran(step, out[:, 0], out[:, 1], force, out[:, 2])
