"""A hydraulic cylinder behind a proportional valve: compressible oil, and the force of its pressures.

    (V₁/β + C) dp₁/dt = Q₁ − A₁·v − c·(p₁ − p₂),   V₁ = V₁₀ + A₁·x
    (V₂/β + C) dp₂/dt = Q₂ + A₂·v + c·(p₁ − p₂),   V₂ = V₂₀ − A₂·x,   force = A₁·p₁ − A₂·p₂

The flow through an edge of the valve is Q = K·y·√Δp, where y is the opening of the spool (−1 to 1) and K follows from
the rated flow.  y > 0 connects the supply to the head and the rod to the tank, y < 0 the other way round.  Pressures
are relative to the tank's.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from mjfriction.errors import SimulationError
from mjfriction.laws.law import Floats
from mjfriction.robot.schema import Hydraulics

LAMINAR = 5e4  # Pa; pressure drop below which the flow through an edge reverses smoothly


class Cylinder:
    """A cylinder that is stepped along with its piston; its history is in its arrays, one row per step.

    ``voltage`` is called at every step with the step's number, the piston's position and both chambers' pressures; it
    returns the voltage at the valve's amplifier.
    """

    def __init__(
        self,
        of: Hydraulics,
        voltage: Callable[[int, float, float, float], float],
        supply: Floats,
        step: float,
        start: float,
        load: float,
    ) -> None:
        self.of, self.voltage, self.supply, self.step = of, voltage, supply, step
        self.spool = 0.0
        self.share = -np.expm1(-2.0 * np.pi * of.valve_bandwidth * step)
        # At rest the chambers balance the load; the rod is at half the supply, or higher to keep the head above 0.
        self.rod = max(0.5 * float(supply[0]), -load / of.rod_area)
        self.head = (self.rod * of.rod_area + load) / of.head_area
        self.volts, self.p1, self.p2, self.q1, self.q2 = (np.empty(supply.size) for _ in range(5))
        self.cavitating: dict[str, list[int]] = {"head": [], "rod": []}
        self._volumes(start, 0)

    def force(self, k: int, position: float, velocity: float) -> float:
        """Advance the oil by one step with a piston at a position and velocity, and return its force, N."""
        of = self.of
        asked = self.voltage(k, position, self.head, self.rod)
        self.volts[k] = min(max(asked, -of.voltage_limit), of.voltage_limit)
        self.spool += self.share * (self.volts[k] / of.voltage_limit - self.spool)
        supply = float(self.supply[k])
        if self.spool >= 0.0:
            inward, outward = self._flow(supply - self.head), self._flow(-self.rod)
        else:
            inward, outward = self._flow(self.head), self._flow(self.rod - supply)
        self.q1[k], self.q2[k] = self.spool * inward, self.spool * outward
        first, second = self._volumes(position, k)
        past = of.leakage * (self.head - self.rod)
        self.head += self.step * (self.q1[k] - of.head_area * velocity - past) / first
        self.rod += self.step * (self.q2[k] + of.rod_area * velocity + past) / second
        # Oil cannot pull: below the tank's pressure it cavitates and leaves the chamber without pressure.
        if self.head < 0.0:
            self.head = 0.0
            self.cavitating["head"].append(k)
        if self.rod < 0.0:
            self.rod = 0.0
            self.cavitating["rod"].append(k)
        self.p1[k], self.p2[k] = self.head, self.rod
        return of.head_area * self.head - of.rod_area * self.rod

    def notes(self, time: Floats, joint: str) -> list[str]:
        """Return a sentence for each chamber that cavitated."""
        return [
            f"joint '{joint}': the {chamber} chamber cavitated for {len(steps) * self.step:.3g} s, first at "
            f"{time[steps[0]]:.4g} s; its pressure was held at the tank's"
            for chamber, steps in self.cavitating.items()
            if steps
        ]

    def _flow(self, drop: float) -> float:
        return self.of.rated_flow * drop / math.sqrt(self.of.rated_drop * (abs(drop) + LAMINAR))

    def _volumes(self, position: float, k: int) -> tuple[float, float]:
        first = self.of.head_volume + self.of.head_area * position
        second = self.of.rod_volume - self.of.rod_area * position
        if min(first, second) <= 0.0:
            raise SimulationError(
                f"at {k * self.step:.4g} s the piston is at {position:.4g} m, past the end of its chambers "
                "(head_volume, rod_volume); shorten the motion or check the robot file"
            )
        oil = self.of.bulk_modulus
        return first / oil + self.of.hose_compliance, second / oil + self.of.hose_compliance


def speed_per_volt(of: Hydraulics) -> tuple[float, float]:
    """Return the piston's speed per volt without load, extending and retracting, m/(s·V).

    It follows from the flows through the two edges and A₁·p₁ = A₂·p₂.
    """
    edge = of.rated_flow / np.sqrt(of.rated_drop) * np.sqrt(of.supply_pressure) / of.voltage_limit
    a, b = of.head_area, of.rod_area
    return float(edge / np.sqrt(a**2 + b**3 / a)), float(edge / np.sqrt(b**2 + a**3 / b))
