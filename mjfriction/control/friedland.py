"""Observers that take friction for a Coulomb level of unknown size, and learn that level.

    F̂ = m·â·sgn v̂,   â = z − k·|v̂|^μ,   dz/dt = k·μ·|v̂|^(μ−1)·(w − â·sgn v̂)·sgn v̂,   w = u/m

With the velocity known, the error of â obeys dε/dt = −k·μ·|v|^(μ−1)·ε: it dies away for k, μ > 0 while v keeps away
from zero.  The three differ in where v̂ comes from: a measurement (Friedland and Park, IEEE Trans. Automatic Control
37(10), 1992); v̂ = z_v + k_v·x with dz_v/dt = −k_v·v̂ + w − â·sgn v̂ (Friedland and Mentzelopoulou, IEEE CCA 1992); the
same without the last terms, a filtered derivative (Tafazoli, de Silva, Lawrence, IROS 1994).  The text of Bonchis and
others is damaged at these equations ((3) to (9)); their order is taken from the papers they cite.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from mjfriction.control.observer import Observer
from mjfriction.errors import ControlError
from mjfriction.laws.curves import sign
from mjfriction.laws.law import Floats, kernel, routine

LONGEST = 0.1  # of the time that a level is learnt in, for a step
SLOWEST = 1e-12  # rad/s or m/s, in place of zero where a power below zero would have no value


@kernel
def level_step(v: float, w: float, h: float, gain: float, exponent: float, z: float) -> tuple[float, float]:
    """Return (next z, â) of the level's observer with ``v`` held through the step: linear in z, so stepped exactly."""
    size = max(abs(v), SLOWEST)
    learnt = gain * size**exponent
    if v == 0.0:
        return z, z - learnt
    rate = gain * exponent * size ** (exponent - 1.0)
    goal = w * sign(v) + learnt
    ahead = goal + (z - goal) * math.exp(-rate * h)
    return ahead, ahead - learnt


@routine
def friedland_park(x: float, v: float, u: float, h: float, p: Floats, z: Floats, z_next: Floats) -> tuple[float, float]:
    """Velocity as measured; p = (m, k, μ), z = (z,)."""
    z_next[0], level = level_step(v, u / p[0], h, p[1], p[2], z[0])
    return p[0] * level * sign(v), v


@routine
def friedland_mentzelopoulou(
    x: float, v: float, u: float, h: float, p: Floats, z: Floats, z_next: Floats
) -> tuple[float, float]:
    """Velocity estimated with the net acceleration; p = (m, k, μ, k_v), z = (z, v̂, x, net)."""
    return _position_only(x, u, h, p, z, z_next, 1.0)


@routine
def tafazoli(x: float, v: float, u: float, h: float, p: Floats, z: Floats, z_next: Floats) -> tuple[float, float]:
    """Velocity by a filtered derivative; p and z as of the one before."""
    return _position_only(x, u, h, p, z, z_next, 0.0)


@kernel
def _position_only(
    x: float, u: float, h: float, p: Floats, z: Floats, z_next: Floats, share: float
) -> tuple[float, float]:
    # dv̂/dt = k_v·(dx/dt − v̂) + net over the step that ended, position going evenly from reading to reading: exact.
    kept = math.exp(-p[3] * h)
    now = kept * z[1] + (1.0 - kept) * ((x - z[2]) / h + z[3] / p[3])
    z_next[0], _ = level_step(now, u / p[0], h, p[1], p[2], z[0])
    level = z[0] - p[1] * max(abs(now), SLOWEST) ** p[2]
    z_next[1], z_next[2], z_next[3] = now, x, share * (u / p[0] - level * sign(now))
    return p[0] * level * sign(now), now


@dataclass(frozen=True)
class FriedlandPark(Observer):
    """Coulomb level learnt from a measured velocity: ``gain`` k, m/s² per (m/s)^μ, and ``exponent`` μ."""

    gain: float
    exponent: float = 1.0

    advance = friedland_park
    needs_velocity = True

    def __post_init__(self) -> None:
        super().__post_init__()
        self.require(self.gain > 0.0, "gain", "above 0")
        self.require(self.exponent > 0.0, "exponent", "above 0")

    @property
    def packed(self) -> Floats:
        """(m, k, μ)."""
        return np.array([self.mass, self.gain, self.exponent])

    def start(self, position: float, velocity: float = 0.0) -> Floats:
        """No friction known: â = 0."""
        return np.array([self.gain * max(abs(velocity), SLOWEST) ** self.exponent])


@dataclass(frozen=True)
class _FromPosition(Observer):
    # What the two that estimate their velocity share: gains, kernel's vector, start.
    gain: float
    velocity_gain: float
    exponent: float = 1.0

    def __post_init__(self) -> None:
        super().__post_init__()
        self.require(self.gain > 0.0, "gain", "above 0")
        self.require(self.exponent > 0.0, "exponent", "above 0")
        self.require(self.velocity_gain > 0.0, "velocity_gain", "above 0")

    @property
    def packed(self) -> Floats:
        """(m, k, μ, k_v)."""
        return np.array([self.mass, self.gain, self.exponent, self.velocity_gain])

    def start(self, position: float, velocity: float = 0.0) -> Floats:
        """No friction known, the velocity as told."""
        learnt = self.gain * max(abs(velocity), SLOWEST) ** self.exponent
        return np.array([learnt, velocity, position, 0.0])

    def check_step(self, step: float) -> None:
        """Raise :class:`ControlError` where the level would be learnt within a few steps: it would swing up."""
        super().check_step(step)
        if self.exponent == 1.0 and self.gain * step > LONGEST:
            raise ControlError(
                f"{self.title}: gain {self.gain:g} learns within a few steps of {step:g} s and swings up; at most "
                f"{LONGEST / step:.3g} is allowed"
            )


@dataclass(frozen=True)
class FriedlandMentzelopoulou(_FromPosition):
    """Coulomb level and velocity from position: ``gain`` k, ``velocity_gain`` k_v (1/s), ``exponent`` μ.

    With the velocity's error in it, the level's obeys s² + k_v·s + k·k_v = 0 for μ = 1: well damped for k below k_v.
    """

    advance = friedland_mentzelopoulou


@dataclass(frozen=True)
class Tafazoli(_FromPosition):
    """Coulomb level from position, the velocity by a filtered derivative: gains as of the one above."""

    advance = tafazoli
