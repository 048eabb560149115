"""An observer of the bristle in a known law: the law is simulated along the measured velocity and corrected.

    dv̂/dt = (u − F̂)/m + l·(v − v̂),   dẑ/dt = [the law's own](v, ẑ) − γ·(v − v̂),   F̂ = law(v, ẑ)

The observer uses the law without the damping of its bristle.  For LuGre, dz/dt = v − a·z with a = σ₀|v|/g(v).  At
constant velocity, with errors e_v = v − v̂ and e_z = z − ẑ, the function

    V = ½m·e_v² + σ₀/(2γ)·e_z²   then falls at every speed:   dV/dt = −m·l·e_v² − σ₀·(a/γ)·e_z²   for l, γ > 0.

With σ₁ included, the force of a deflection would change sign where σ₁|v| > g(v).  After Canudas de Wit, Olsson, Åström,
Lischinsky, IEEE Trans. Automatic Control 40(3), 1995, whose observer is corrected by the tracking error; here the
innovation of a velocity observer replaces it, so that the observer also runs on a log.
"""

from __future__ import annotations

import functools
from dataclasses import dataclass, replace

import numpy as np

from mjfriction.control.observer import Observer
from mjfriction.errors import ControlError
from mjfriction.laws.ambient import AMBIENT_SIZE, ROOM_TEMPERATURE, SLIDING, TEMPERATURE
from mjfriction.laws.friction import Friction, Level
from mjfriction.laws.law import Floats, routine
from mjfriction.laws.wrapped import RATIO, advance_wrapped

GAINS = 3  # number of values packed before the law: m, l, γ
STIFFNESS = "bristle_stiffness"


@routine
def bristle(x: float, v: float, u: float, h: float, p: Floats, z: Floats, z_next: Floats) -> tuple[float, float]:
    """Step with p = (m, l, γ, the wrapped law…), z = (v̂, ẑ)."""
    near, around = np.empty(AMBIENT_SIZE), np.zeros(AMBIENT_SIZE)
    around[TEMPERATURE], around[SLIDING] = ROOM_TEMPERATURE, np.nan
    friction, _ = advance_wrapped(v, around, z[1:], h, p[GAINS:], z_next[1:], near)
    error = v - z[0]
    # The correction of the estimated velocity has stiffness l·h; the implicit step is stable for any of it.
    z_next[0] = (z[0] + h * ((u - friction) / p[0] + p[1] * v)) / (1.0 + h * p[1])
    z_next[1] -= h * p[2] * p[GAINS + RATIO] * error
    return friction, z_next[0]


@dataclass(frozen=True)
class BristleObserver(Observer):
    """``law`` at the joint, with one state; ``velocity_gain`` l (1/s), ``bristle_gain`` γ (1)."""

    law: Friction
    velocity_gain: float
    bristle_gain: float

    advance = bristle
    needs_velocity = True

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.law.state_count != 1 or self.law.law.index(STIFFNESS) is None:
            raise ControlError(
                f"{self.title} needs a law with one bristle, such as 'lugre' or 'dahl', not '{self.law.law.name}'"
            )
        if self.law.level != Level() or self.law.law.reads:
            raise ControlError(
                f"{self.title} knows neither load, place nor temperature; take a law whose level does not follow them"
            )
        self.require(self.velocity_gain > 0.0, "velocity_gain", "above 0")
        self.require(self.bristle_gain > 0.0, "bristle_gain", "above 0")

    @property
    def packed(self) -> Floats:
        """(m, l, γ, the law's own vector)."""
        return np.concatenate([[self.mass, self.velocity_gain, self.bristle_gain], self._undamped.packed])

    @functools.cached_property
    def _undamped(self) -> Friction:
        values, place = self.law.values.copy(), self.law.law.index("bristle_damping")
        if place is not None:
            values[place] = 0.0
        return replace(self.law, values=values)

    @property
    def stiffness(self) -> float:
        """The bristle's stiffness reflected to the joint, N·m/rad or N/m."""
        place = self.law.law.index(STIFFNESS)
        assert place is not None, "checked when it was made"
        return float(self.law.values[place]) * self.law.gear_ratio**2

    def check_step(self, step: float) -> None:
        """Raise :class:`ControlError` if the step is so long that the errors do not decay from step to step."""
        super().check_step(step)
        drawn = 1.0 / (1.0 + step * self.velocity_gain)
        errors = [[drawn, -step * self.stiffness / self.mass * drawn], [step * self.bristle_gain, 1.0]]
        self.require_settling(np.array(errors), step)

    def start(self, position: float, velocity: float = 0.0) -> Floats:
        """Return the state at the given velocity, without deflection."""
        return np.array([velocity, 0.0])
