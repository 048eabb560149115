"""The disturbance observer: friction on a mass as a second-order random walk, estimated by a Kalman filter.

    X̂ = (v̂, x̂, F̂, dF̂),   X̂⁺ = F̂·X̂ + Ĝ·u + L·(x − Ĥ·X̂),   friction = F̂ + σ₂·v̂

    F̂ = [[1 − σ₂T/m, 0, −T/m, 0], [T, 1, 0, 0], [0, 0, 1, T], [0, 0, 0, 1]],   Ĝ = (T/m, 0, 0, 0),   Ĥ = (0, 1, 0, 0)

Lampaert, Swevers, Al-Bender and others (pre-sliding compensation, section V), after Ray, Ramasubramanian, Townsend,
Control Engineering Practice 9, 2001.  The filter errors decay if all eigenvalues of F̂ − L·Ĥ lie inside the unit
circle.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.linalg import solve_discrete_are

from mjfriction.control.observer import Observer, ObserverFor
from mjfriction.errors import ControlError
from mjfriction.laws.law import Floats, routine

SAME_STEP = 1e-6  # relative tolerance for a step to be the one that the gains were made for
# Least bandwidth as a fraction of the sampling rate: below it, the eigenvalues differ from 1 by no more than rounding.
SLOWEST = 1e-4


@routine
def disturbance(x: float, v: float, u: float, h: float, p: Floats, z: Floats, z_next: Floats) -> tuple[float, float]:
    """Step of the filter with p = (m, σ₂, T, L₁…L₄), z = (v̂, x̂, F̂, dF̂)."""
    surprise = x - z[1]
    pull = p[2] / p[0]
    z_next[0] = (1.0 - p[1] * pull) * z[0] + pull * (u - z[2]) + p[3] * surprise
    z_next[1] = z[1] + p[2] * z[0] + p[4] * surprise
    z_next[2] = z[2] + p[2] * z[3] + p[5] * surprise
    z_next[3] = z[3] + p[6] * surprise
    return z_next[2] + p[1] * z_next[0], z_next[0]


@dataclass(frozen=True)
class DisturbanceObserver(Observer):
    """``viscous`` σ₂ (N·s/m), ``sampling`` T (s), and ``gains`` L of velocity, position, force and its change.

    Raises :class:`ControlError` for gains with which the errors do not decay.
    """

    viscous: float
    sampling: float
    gains: tuple[float, float, float, float]

    advance = disturbance

    def __post_init__(self) -> None:
        super().__post_init__()
        self.require(self.viscous >= 0.0, "viscous", "0 or above")
        self.require(self.sampling > 0.0, "sampling", "above 0")
        if len(self.gains) != 4 or not np.all(np.isfinite(self.gains)):
            raise ControlError(f"{self.title}: gains = {self.gains}; four finite numbers are needed")
        forward, measured = _matrices(self.mass, self.viscous, self.sampling)
        self.require_settling(forward - np.array(self.gains)[:, None] * measured, self.sampling)

    @classmethod
    def kalman(
        cls, mass: float, sampling: float, *, position_noise: float, force_walk: float, viscous: float = 0.0
    ) -> DisturbanceObserver:
        """Return the observer with the gain of the steady-state Kalman filter.

        ``position_noise``: standard deviation of a reading, m; ``force_walk``: of the second difference of the force
        per step, N.  The gain is L = F̂PĤᵀ(ĤPĤᵀ + R)⁻¹, P from the discrete Riccati equation.
        """
        _check(mass=mass, sampling=sampling, position_noise=position_noise, force_walk=force_walk)
        # Scale to units in which both noises are 1: readings in nanometres and forces in newtons are ten decades apart.
        forward, measured = _matrices(mass, viscous, sampling)
        unit = np.array([position_noise / sampling, position_noise, force_walk, force_walk / sampling])
        own = forward * unit / unit[:, None]
        driven = np.zeros((4, 4))
        driven[3, 3] = 1.0
        covariance = solve_discrete_are(own.T, measured.T, driven, np.eye(1))
        gain = own @ covariance @ measured.T / (measured @ covariance @ measured.T + 1.0)
        scaled = gain[:, 0] * unit / position_noise
        return cls(mass, viscous, sampling, _four(scaled))

    @classmethod
    def with_bandwidth(
        cls, mass: float, sampling: float, bandwidth: float, *, viscous: float = 0.0
    ) -> DisturbanceObserver:
        """Return the observer whose errors decay with four equal rates 2π·``bandwidth`` (Hz)."""
        _check(mass=mass, sampling=sampling, bandwidth=bandwidth)
        if bandwidth * sampling < SLOWEST:
            raise ControlError(
                f"a disturbance observer of {bandwidth:g} Hz is too slow for steps of {sampling:g} s: its gains would "
                f"drown in rounding; at least {SLOWEST / sampling:.3g} Hz is allowed"
            )
        # Scale to units of one step, so that all entries are about 1 and F̂ − λ loses no precision with λ near 1.
        forward, measured = _matrices(mass, viscous, sampling)
        unit = np.array([1.0 / sampling, 1.0, mass / sampling**2, mass / sampling**3])
        own = forward * unit / unit[:, None]
        off = own - np.exp(-2.0 * np.pi * bandwidth * sampling) * np.eye(4)
        seen = np.vstack([measured @ np.linalg.matrix_power(own, k) for k in range(4)])
        # Ackermann's formula for the pair (F̂, Ĥ) with four equal eigenvalues.
        gain = off @ off @ off @ off @ np.linalg.solve(seen, np.array([0.0, 0.0, 0.0, 1.0]))
        return cls(mass, viscous, sampling, _four(gain * unit))

    @property
    def packed(self) -> Floats:
        """(m, σ₂, T, L₁…L₄)."""
        return np.array([self.mass, self.viscous, self.sampling, *self.gains])

    def start(self, position: float, velocity: float = 0.0) -> Floats:
        """Return the state at the joint's position and velocity, without known friction."""
        return np.array([velocity, position, 0.0, 0.0])

    def check_step(self, step: float) -> None:
        """Raise :class:`ControlError` for a step other than the one that the gains were made for."""
        super().check_step(step)
        if abs(step - self.sampling) > SAME_STEP * self.sampling:
            raise ControlError(
                f"{self.title}: its gains are for steps of {self.sampling:g} s, not {step:g} s; make it for that step"
            )


def disturbance_observer(bandwidth: float) -> ObserverFor:
    """Return (mass, step) → the observer of that bandwidth (Hz), for controllers that need one at every joint."""
    return lambda mass, step: DisturbanceObserver.with_bandwidth(mass, step, bandwidth)


def _matrices(mass: float, viscous: float, sampling: float) -> tuple[Floats, Floats]:
    t = sampling
    forward = np.array(
        [[1.0 - viscous * t / mass, 0.0, -t / mass, 0.0], [t, 1.0, 0, 0], [0, 0, 1.0, t], [0, 0, 0, 1.0]]
    )
    return forward, np.array([[0.0, 1.0, 0.0, 0.0]])


def _check(**given: float) -> None:
    for name, value in given.items():
        if not (np.isfinite(value) and value > 0.0):
            raise ControlError(f"a disturbance observer needs {name} above 0, not {value:g}")


def _four(gain: Floats) -> tuple[float, float, float, float]:
    a, b, c, d = (float(value) for value in gain)
    return a, b, c, d
