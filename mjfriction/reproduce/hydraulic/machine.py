"""The hydraulic document's cylinder, richer than its law and on long hoses, and the observers compared on it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mjfriction.control.friedland import FriedlandMentzelopoulou, Tafazoli
from mjfriction.control.observer import ObserverFor
from mjfriction.control.servo import Control
from mjfriction.control.valve import FrictionSource, ValveControl, ValveGains
from mjfriction.control.variable_structure import VariableStructure
from mjfriction.laws.law import Floats
from mjfriction.plant.machine import Run, run_machine
from mjfriction.plant.trajectory import Trajectory
from mjfriction.record.log import SUPPLY_PRESSURE
from mjfriction.robot.body_tables import Payload
from mjfriction.robot.files import read_robot
from mjfriction.robot.friction import with_term
from mjfriction.robot.robot import Robot

JOINT = "piston"
HOSE = 8e-13  # m³/Pa of each hose: 5 m of 10 mm bore, whose walls yield as much as oil of bulk modulus 0.5 GPa
STEEP, THRESHOLD = 2e4, 6e-3  # N·s/m below a speed (m/s): the static-kinetic template of the document's figure 2
RATE = 10000.0  # Hz of control and simulation
RAMP, WARM = 1.0, 1.0  # s over which the reference grows, and before which nothing is evaluated
AMPLITUDE, FREQUENCY = 0.04, 0.25  # m, Hz
NOMINAL_SUPPLY, LOW_SUPPLY = 8e6, 2e6  # Pa
HEAVY = 96.0  # kg

LEVEL_RATE = 150.0  # 1/s at which Friedland's observers learn the level
VELOCITY_RATE = 300.0  # 1/s of their velocity estimate, and of the filtered derivative
SLIDING_RATE, SLIDING_SPEED, SLIDING_WIDTH = 250.0, 10.0, 5e-3  # rad/s, m/s, m of the variable-structure observer


def cylinder(*, mass: float | None = None) -> Robot:
    """Return the machine: the bundled one on long hoses, its friction steep below 6 mm/s; ``mass`` (kg) of its load."""
    stated = on_hoses(read_robot("hydraulic_cylinder"))
    steep = {"level": 0.0, "slope_below": STEEP, "slope_above": 0.0, "threshold_velocity": THRESHOLD}
    machine = with_term(stated, JOINT, "static_kinetic", steep)
    if mass is None:
        return machine
    own = float(stated.body().model.inertias[1].mass)
    load = Payload(mass=mass - own, com=(0.28, 0.0, 0.0), parent=JOINT)
    return Robot(machine.table.model_copy(update={"payload": load}), machine.folder)


def on_hoses(robot: Robot) -> Robot:
    """Return a robot with the document's hoses of considerable length."""
    joint = robot.joint(JOINT)
    assert joint.hydraulics is not None
    longer = joint.hydraulics.model_copy(update={"hose_compliance": HOSE})
    return robot.with_joint(joint.model_copy(update={"hydraulics": longer}))


def known_cylinder() -> Robot:
    """Return what a controller knows: the cylinder without friction."""
    robot = on_hoses(read_robot("hydraulic_cylinder"))
    return robot.with_joint(robot.joint(JOINT).model_copy(update={"friction": ()}))


def _learning(kind: type[FriedlandMentzelopoulou | Tafazoli]) -> ObserverFor:
    return lambda mass, _: kind(mass, LEVEL_RATE, VELOCITY_RATE)


def _sliding(smoothing: float) -> ObserverFor:
    return lambda mass, _: VariableStructure.with_rate(mass, SLIDING_RATE, SLIDING_SPEED, smoothing)


OBSERVERS = {
    "Friedland-Mentzelopoulou": _learning(FriedlandMentzelopoulou),
    "Tafazoli": _learning(Tafazoli),
    "variable structure": _sliding(SLIDING_WIDTH),
}
SHARP = _sliding(0.0)
"""The variable-structure observer with the signum of (13) in the place of the tanh of (14)."""


@dataclass(frozen=True)
class Tracked:
    """One run along the reference, after it has grown to its full amplitude.

    ``time``, the ``wanted`` position and the ``error`` (mm), ``voltage`` (V), the ``true`` friction and the friction
    that the controller ``estimated`` (N), each (n,).  ``extends`` marks the samples where the wanted motion extends.
    """

    time: Floats
    wanted: Floats
    error: Floats
    voltage: Floats
    true: Floats
    estimated: Floats
    extends: np.ndarray

    def rms(self, *, extending: bool | None = None) -> float:
        """RMS error, mm, of one direction or of both."""
        own = np.ones(self.error.size, dtype=bool) if extending is None else self.extends == extending
        return float(np.sqrt(np.mean(np.square(self.error[own]))))


def follow(
    gains: tuple[ValveGains, ValveGains],
    friction: FrictionSource | None,
    *,
    machine: Robot | None = None,
    supply: float = NOMINAL_SUPPLY,
    periods: float = 1.0,
    seed: int = 0,
) -> Tracked:
    """Run the cylinder along the reference, with ``gains`` for extending and retracting; ``friction`` None is PD."""
    control = Control(
        friction="none",
        feedforward="none",
        sensed=True,
        seed=seed,
        valve=ValveControl(*gains, friction),
    )
    trajectory = reference(periods, supply)
    run = run_machine(machine or cylinder(), trajectory, RATE, control, known_cylinder())
    return _judged(run)


def reference(periods: float, supply: float = NOMINAL_SUPPLY) -> Trajectory:
    """Return the sine that the piston should follow, growing from rest, with the supply's pressure."""
    seconds = RAMP + periods / FREQUENCY
    time = np.arange(0.0, seconds + 1e-9, 0.002)
    share = np.clip(time / RAMP, 0.0, 1.0)
    place = AMPLITUDE * share**3 * (10.0 - 15.0 * share + 6.0 * share**2) * np.sin(2.0 * np.pi * FREQUENCY * time)
    ambient = {SUPPLY_PRESSURE: np.full(time.size, supply)}
    return Trajectory((JOINT,), time, place[:, None], ambient)


def _judged(run: Run) -> Tracked:
    own = run.time > WARM
    wanted = run.wanted[:, 0]
    return Tracked(
        run.time[own] - WARM,
        1e3 * wanted[own],
        1e3 * (wanted - run.played.position[:, 0])[own],
        run.cylinders[JOINT].volts[own],
        run.played.friction[own, 0],
        run.estimates[own, 0],
        (np.gradient(wanted) > 0.0)[own],
    )
