"""The variable-structure observer of position, velocity and friction, with sharp or smooth switching.

    dx̂/dt = v̂ − σ,   dv̂/dt = (u − F̂)/m + L₁·σ,   dF̂/dt = L₂·σ,   σ = M·sgn(x̂ − x)  or  M·tanh((x̂ − x)/κ)

Equations (10) to (12) of Bonchis, Ha, Corke and Rye are unreadable in print; (13), (14), the condition L₁ < 0 < L₂ and
that the proof is by singular perturbations can be read.  The form used here follows from these (Utkin's sliding-mode
observers, their reference 15).  While M > |v̂ − v|, the position error is held at zero and the mean of σ is the
velocity error, so the errors e_v, e_F of velocity and friction obey

    de_v/dt = −e_F/m + L₁·e_v,   de_F/dt = L₂·e_v,   or   s² − L₁·s + L₂/m = 0.

They decay exactly if L₁ < 0 < L₂, the printed condition.  L₁ in 1/s, L₂ in N/m (N·m/rad), M in m/s (rad/s).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from mjfriction.control.observer import Observer
from mjfriction.laws.curves import sign
from mjfriction.laws.law import Floats, routine


@routine
def variable_structure(
    x: float, v: float, u: float, h: float, p: Floats, z: Floats, z_next: Floats
) -> tuple[float, float]:
    """Explicit Euler step with p = (m, M, L₁, L₂, κ), z = (x̂, v̂, F̂); κ = 0 switches sharply."""
    error = z[0] - x
    switched = p[1] * (math.tanh(error / p[4]) if p[4] > 0.0 else sign(error))
    z_next[0] = z[0] + h * (z[1] - switched)
    z_next[1] = z[1] + h * ((u - z[2]) / p[0] + p[2] * switched)
    z_next[2] = z[2] + h * p[3] * switched
    return z_next[2], z_next[1]


@dataclass(frozen=True)
class VariableStructure(Observer):
    """``switching`` M, ``velocity_gain`` L₁ < 0, ``friction_gain`` L₂ > 0; ``smoothing`` κ (m, rad), 0 if sharp."""

    switching: float
    velocity_gain: float
    friction_gain: float
    smoothing: float = 0.0

    advance = variable_structure

    def __post_init__(self) -> None:
        super().__post_init__()
        self.require(self.switching > 0.0, "switching", "above 0")
        self.require(self.velocity_gain < 0.0, "velocity_gain", "below 0")
        self.require(self.friction_gain > 0.0, "friction_gain", "above 0")
        self.require(self.smoothing >= 0.0, "smoothing", "0 or above")

    @classmethod
    def with_rate(
        cls, mass: float, rate: float, switching: float, smoothing: float = 0.0, damping: float = 0.8
    ) -> VariableStructure:
        """Return the observer whose errors decay at ``rate`` (rad/s): s² − L₁s + L₂/m = s² + 2ζωs + ω²."""
        return cls(mass, switching, -2.0 * damping * rate, mass * rate * rate, smoothing)

    @property
    def packed(self) -> Floats:
        """(m, M, L₁, L₂, κ)."""
        return np.array([self.mass, self.switching, self.velocity_gain, self.friction_gain, self.smoothing])

    def start(self, position: float, velocity: float = 0.0) -> Floats:
        """Return the state at the joint's position and velocity, without known friction."""
        return np.array([position, velocity, 0.0])

    def check_step(self, step: float) -> None:
        """Raise :class:`ControlError` if the step is so long that the errors do not decay from step to step.

        With smooth switching, the three errors are linear within its width; with sharp switching, the two errors of the
        sliding motion are.
        """
        super().check_step(step)
        drawn = 1.0 / self.mass
        if self.smoothing > 0.0:
            steep = self.switching / self.smoothing
            rates = np.array(
                [
                    [-steep, 1.0, 0.0],
                    [self.velocity_gain * steep, 0.0, -drawn],
                    [self.friction_gain * steep, 0.0, 0.0],
                ]
            )
        else:
            rates = np.array([[self.velocity_gain, -drawn], [self.friction_gain, 0.0]])
        self.require_settling(np.eye(rates.shape[0]) + step * rates, step)
