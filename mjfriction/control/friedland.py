"""Observers that model friction as a Coulomb level of unknown size and estimate that level.

    F̂ = m·â·sgn v̂,   â = z − k·|v̂|^μ,   dz/dt = k·μ·|v̂|^(μ−1)·(w − â·sgn v̂)·sgn v̂,   w = u/m

With known velocity, the error of â obeys dε/dt = −k·μ·|v|^(μ−1)·ε: it decays for k, μ > 0 as long as v stays away from
zero.  The three observers differ in the source of v̂: a measurement (Friedland and Park, IEEE Trans. Automatic Control
37(10), 1992); v̂ = z_v + k_v·x with dz_v/dt = −k_v·v̂ + w − â·sgn v̂ (Friedland and Mentzelopoulou, IEEE CCA 1992); or
the same without the last two terms, which is a filtered derivative (Tafazoli, de Silva, Lawrence, IROS 1994).  The text
of Bonchis and others is damaged at these equations ((3) to (9)); their order is taken from the papers they cite.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from mjfriction.control.observer import Observer
from mjfriction.laws.curves import sign
from mjfriction.laws.law import Floats, kernel, routine

SLOWEST = 1e-12  # rad/s or m/s; the level is not updated at lower speeds


@kernel
def level_step(level: float, v: float, before: float, w: float, h: float, gain: float, exponent: float) -> float:
    """Return â after a step in which the velocity changed linearly from ``before`` to ``v`` under ``w``.

    Written in â, the observer is dâ/dt = k·μ·|v|^(μ−1)·(w·sgn v − â − d|v|/dt).  The variable z serves to avoid the
    derivative, which sampled velocities provide anyway.  For μ = 1 the step is exact.
    """
    size = 0.5 * (abs(v) + abs(before))
    if size < SLOWEST or math.isnan(w):
        return level
    rate = gain * exponent * size ** (exponent - 1.0)
    goal = w * sign(v + before) - (abs(v) - abs(before)) / h
    return goal + (level - goal) * math.exp(-rate * h)


@routine
def friedland_park(x: float, v: float, u: float, h: float, p: Floats, z: Floats, z_next: Floats) -> tuple[float, float]:
    """Step with the measured velocity; p = (m, k, μ), z = (â, v, w) with v and w of the previous reading."""
    level = level_step(z[0], v, z[1], z[2], h, p[1], p[2])
    z_next[0], z_next[1], z_next[2] = level, v, u / p[0]
    return p[0] * level * sign(v), v


@routine
def friedland_mentzelopoulou(
    x: float, v: float, u: float, h: float, p: Floats, z: Floats, z_next: Floats
) -> tuple[float, float]:
    """Step with velocity estimated using the net acceleration; p = (m, k, μ, k_v), z = (â, v̂, x, net, w)."""
    return _position_only(x, u, h, p, z, z_next, 1.0)


@routine
def tafazoli(x: float, v: float, u: float, h: float, p: Floats, z: Floats, z_next: Floats) -> tuple[float, float]:
    """Step with velocity from a filtered derivative; p and z as in :func:`friedland_mentzelopoulou`."""
    return _position_only(x, u, h, p, z, z_next, 0.0)


@kernel
def _position_only(
    x: float, u: float, h: float, p: Floats, z: Floats, z_next: Floats, share: float
) -> tuple[float, float]:
    # Exact solution of dv̂/dt = k_v·(dx/dt − v̂) + net over the step that ended, with position linear between readings.
    kept = math.exp(-p[3] * h)
    now = kept * z[1] + (1.0 - kept) * ((x - z[2]) / h + z[3] / p[3])
    level = level_step(z[0], now, z[1], z[4], h, p[1], p[2])
    w = u / p[0]
    z_next[0], z_next[1], z_next[2] = level, now, x
    z_next[3], z_next[4] = share * (w - level * sign(now)), w
    return p[0] * level * sign(now), now


@dataclass(frozen=True)
class FriedlandPark(Observer):
    """Coulomb level estimated from a measured velocity: ``gain`` k, m/s² per (m/s)^μ, and ``exponent`` μ."""

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
        """Return the state without known friction: â = 0."""
        return np.array([0.0, velocity, np.nan])


@dataclass(frozen=True)
class _FromPosition(Observer):
    # What the two observers that estimate their velocity share: gains, the kernel's vector, the initial state.
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
        """Return the state without known friction, at the given velocity."""
        return np.array([0.0, velocity, position, 0.0, np.nan])


@dataclass(frozen=True)
class FriedlandMentzelopoulou(_FromPosition):
    """Coulomb level and velocity from position: ``gain`` k, ``velocity_gain`` k_v (1/s), ``exponent`` μ.

    With the velocity's error included, the level's error obeys s² + k_v·s + k·k_v = 0 for μ = 1: well damped for k
    below k_v.
    """

    advance = friedland_mentzelopoulou


@dataclass(frozen=True)
class Tafazoli(_FromPosition):
    """Coulomb level from position, with velocity from a filtered derivative: gains as in FriedlandMentzelopoulou."""

    advance = tafazoli
