"""The table follows its reference: under PD, with an observer, with friction fed forward, with both."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import minimize_scalar

from mjfriction.laws.law import Floats
from mjfriction.plant.machine import Run, run_machine
from mjfriction.plant.motions import inner_loops
from mjfriction.plant.trajectory import Trajectory
from mjfriction.progress import Tell, counting
from mjfriction.reproduce.table.identified import (
    Identified,
    identify_table,
    with_law,
)
from mjfriction.reproduce.table.machine import (
    AMPLITUDE,
    FASTER,
    JOINT,
    PERIOD,
    RATE,
    true_table,
    weak_control,
)
from mjfriction.robot.friction_tables import FrictionTerm
from mjfriction.robot.robot import Robot

TUNED = {"gms": "attraction", "lugre": "bristle_damping", "leuven": "bristle_damping"}
BETWEEN = {"attraction": (1.0, 1e4), "bristle_damping": (1e2, 3e5)}  # N/s, N·s/m
EVALUATIONS = 8
LAWS = ("dahl", "lugre", "leuven over position", "leuven", "gms")


@dataclass(frozen=True)
class Tracked:
    """One run along the reference: ``time`` and position ``error`` (µm) of its last period, and the whole ``run``."""

    time: Floats
    error: Floats
    run: Run

    @property
    def peak_to_peak(self) -> float:
        """The peak-to-peak error, µm."""
        return float(np.ptp(self.error))

    @property
    def rms(self) -> float:
        """The RMS error, µm."""
        return float(np.sqrt(np.mean(np.square(self.error))))


def run_table(tell: Tell, seed: int = 0) -> tuple[Identified, dict[str, Tracked]]:
    """Identify the table, tune the laws, follow the reference with each; ``tell`` is called at each step."""
    begin = counting(tell, 4 + 3 * len(LAWS))
    begin("identifying the table")
    identified = identify_table(seed)
    machine, known = true_table(), identified.robot_without_friction()
    laws = {}
    for law in LAWS:
        begin(f"tuning {law}")
        laws[law] = _tuned(machine, identified, law, seed)
    runs: dict[str, Tracked] = {}

    def follow(name: str, model: Robot, *, friction: bool, observer: bool, period: float = PERIOD) -> None:
        begin(f"following the reference: {name}")
        runs[name] = _tracked(machine, model, friction=friction, observer=observer, period=period, seed=seed)

    follow("PD", known, friction=False, observer=False)
    follow("observer", known, friction=False, observer=True)
    follow("observer, ten times faster", known, friction=False, observer=True, period=PERIOD / FASTER)
    for law, term in laws.items():
        model = with_law(known, term)
        follow(law, model, friction=True, observer=False)
        follow(f"observer and {law}", model, friction=True, observer=True)
    identified = replace(identified, laws=laws)
    return identified, runs


def _reference(period: float) -> Trajectory:
    return inner_loops(JOINT, 0.0, AMPLITUDE, period)


def _tracked(
    machine: Robot, model: Robot, *, friction: bool, observer: bool, period: float = PERIOD, seed: int
) -> Tracked:
    control = replace(weak_control(friction=friction, observer=observer), seed=seed)
    run = run_machine(machine, _reference(period), RATE, control, model)
    last = run.time > run.time[-1] - period
    error = 1e6 * (run.wanted - run.played.position)[last, 0]
    return Tracked(run.time[last] - run.time[last][0], error, run)


def _tuned(machine: Robot, identified: Identified, law: str, seed: int) -> FrictionTerm:
    # As in the document, a parameter that slow turns do not show is chosen for the least maximum error along the
    # reference.
    term = identified.laws[law]
    name = TUNED.get(term.law)
    if name is None:
        return term
    known = identified.robot_without_friction()

    def changed(exponent: float) -> FrictionTerm:
        return term.model_copy(update={"parameters": {**term.parameters, name: float(np.exp(exponent))}})

    def worst(exponent: float) -> float:
        model = with_law(known, changed(exponent))
        tracked = _tracked(machine, model, friction=True, observer=False, seed=seed)
        return float(np.max(np.abs(tracked.error)))

    found = minimize_scalar(worst, bounds=np.log(BETWEEN[name]), method="bounded", options={"maxiter": EVALUATIONS})
    return changed(found.x)
