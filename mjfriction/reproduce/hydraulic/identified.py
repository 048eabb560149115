"""The cylinder's friction from constant voltages at two supplies, and gains by one procedure for every controller."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import pyarrow as pa
from scipy.optimize import minimize

from mjfriction.control.chattering import chattering
from mjfriction.control.valve import FrictionSource, ValveGains
from mjfriction.identify.pressure import SteadyPoints, Variant, choose_variant, pressure_law, steady_points
from mjfriction.laws.friction import Friction, friction
from mjfriction.laws.law import Floats
from mjfriction.plant.machine import simulate
from mjfriction.plant.motions import valve_steps
from mjfriction.plant.sensors import Recorder
from mjfriction.plant.trajectory import Trajectory
from mjfriction.record.log import SUPPLY_PRESSURE
from mjfriction.record.readers.table import log_from_table
from mjfriction.reproduce.hydraulic.machine import JOINT, RATE, Tracked, cylinder, follow, known_cylinder

SUPPLIES = (8e6, 4e6)  # Pa
VOLTS = np.geomspace(0.25, 9.0, 9)
STROKE = 0.09  # m; stroke of the voltage steps, of which each voltage covers a part
LOG_RATE = 500.0

FAST, MOST_FAST = 20.0, 0.25  # Hz, V RMS: voltage above that frequency from which on a run is penalised
FIRST_PD = (5000.0, 1e-3)  # V/m, and velocity gain per position gain (s)
FIRST_ACCELERATION = (16000.0, 1e-6)  # V/m, and acceleration gain per position gain (s²)
EVALUATIONS = 18
FACTORS = (0.85, 1.0, 1.2)  # factors that are tried on the gains of one direction


@dataclass(frozen=True)
class Identified:
    """The points, the variant taken in each direction, and all that were tried."""

    points: SteadyPoints
    chosen: dict[str, Variant]
    tried: dict[str, dict[int, Variant]]

    def law(self, number: int | None = None) -> tuple[Friction, ...]:
        """Return the friction of the variants taken, or of one of the document's models, for a controller."""
        extending, retracting = (
            self.chosen[way] if number is None else self.tried[way][number] for way in ("extending", "retracting")
        )
        return (friction("pressure", pressure_law(extending, retracting)),)


def identify_cylinder(seed: int = 0) -> Identified:
    """Run constant voltages at two supply pressures and fit every variant to either direction."""
    machine, known = cylinder(), known_cylinder()
    of = machine.joint(JOINT).hydraulics
    assert of is not None
    logs = []
    for k, supply in enumerate(SUPPLIES):
        steps = valve_steps(JOINT, of, STROKE, VOLTS.tolist())
        ambient = {**steps.ambient, SUPPLY_PRESSURE: np.full(steps.time.size, supply)}
        trajectory = Trajectory(steps.joints, steps.time, steps.position, ambient)
        columns = simulate(machine, trajectory, recorder=Recorder(LOG_RATE), seed=seed + k)
        logs.append(log_from_table(pa.table(columns), f"constant voltages at {1e-5 * supply:g} bar"))
    points = steady_points(logs, known, JOINT)
    extending, retracting = choose_variant(points, "extending"), choose_variant(points, "retracting")
    return Identified(
        points,
        {"extending": extending[0], "retracting": retracting[0]},
        {"extending": extending[1], "retracting": retracting[1]},
    )


def tuned_pd(seed: int = 0) -> ValveGains:
    """Return the PD gains of least error."""
    position, ratio = _tuned(FIRST_PD, lambda p, r: ValveGains(p, p * r), None, seed)
    return ValveGains(position, position * ratio)


def tuned_acceleration(friction: FrictionSource, seed: int = 0) -> ValveGains:
    """Return position and acceleration gains of least error with the friction of a law or an observer."""
    position, ratio = _tuned(FIRST_ACCELERATION, lambda p, r: ValveGains(p, 0.0, p * r), friction, seed)
    return ValveGains(position, 0.0, position * ratio)


def _tuned(
    first: tuple[float, float],
    gains: Callable[[float, float], ValveGains],
    friction: FrictionSource | None,
    seed: int,
) -> tuple[float, float]:
    # The same for all controllers: two numbers by Nelder-Mead from a first guess.  The cost is the error, increased
    # where the valve is asked for too much fast voltage.
    def cost(x: Floats) -> float:
        own = gains(float(np.exp(x[0])), float(np.exp(x[1])))
        tracked = follow((own, own), friction, seed=seed)
        return tracked.rms() * (1.0 + max(0.0, fast_voltage(tracked) / MOST_FAST - 1.0))

    start = np.log(first)
    simplex = start + np.array([[0.0, 0.0], [0.7, 0.0], [0.0, 0.9]])
    options = {"maxfev": EVALUATIONS, "initial_simplex": simplex}
    found = minimize(cost, start, method="Nelder-Mead", options=options)
    return float(np.exp(found.x[0])), float(np.exp(found.x[1]))


def fast_voltage(tracked: Tracked) -> float:
    """Return the voltage that a run asks of its valve above 20 Hz, V RMS."""
    return chattering(tracked.voltage, RATE, FAST)


def separate_gains(equal: ValveGains, friction: FrictionSource, seed: int = 0) -> tuple[ValveGains, ValveGains]:
    """Return gains for extending and retracting, each scaled in turn from equal ones for the least error of both."""
    own = [equal, equal]
    for way in (0, 1):
        tried = []
        for factor in FACTORS:
            scaled = ValveGains(factor * equal.position, factor * equal.velocity, factor * equal.acceleration)
            pair = (scaled, own[1]) if way == 0 else (own[0], scaled)
            tracked = follow(pair, friction, seed=seed)
            cost = tracked.rms() * (1.0 + max(0.0, fast_voltage(tracked) / MOST_FAST - 1.0))
            tried.append((cost, factor, scaled))
        own[way] = min(tried, key=lambda entry: entry[:2])[2]
    return own[0], own[1]
