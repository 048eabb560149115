"""The table's laws from its own experiments: passes for cogging and Stribeck curve, a slow sawtooth for the rest."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import pyarrow as pa
from scipy.optimize import least_squares

from mjfriction.identify.cogging import cogging_waves, harmonics
from mjfriction.identify.friction_course import FrictionCourse, friction_course
from mjfriction.identify.friction_map import FrictionMap, friction_maps
from mjfriction.identify.hysteresis import Elements, bristle_travel, elements_of
from mjfriction.identify.map_fit import MapFit, fit_map
from mjfriction.identify.phases import Phase, constant_speed_phases
from mjfriction.laws.ambient import ambient
from mjfriction.laws.catalog import find_law
from mjfriction.laws.law import Floats
from mjfriction.plant.machine import simulate
from mjfriction.plant.motions import KNOTS, forward_backward, move, sawtooth
from mjfriction.plant.sensors import Recorder
from mjfriction.plant.trajectory import Trajectory
from mjfriction.record.log import Log
from mjfriction.record.readers.table import log_from_table
from mjfriction.reproduce.table.machine import JOINT, PITCH, blank_table, stiff_control, true_table
from mjfriction.robot.friction_tables import FrictionTerm
from mjfriction.robot.robot import Robot
from mjfriction.robot.table import Wave

SPEEDS = np.geomspace(80e-6, 20e-3, 12)  # m/s
SHORTEST, LONGEST, SECONDS = 4e-3, 60e-3, 8.0  # m, m, s; bounds of a pass's length, and its duration within them
SLID = 1.2e-3  # m of travel after which a pass slides: its friction no longer depends on where it began
HARMONICS = 30  # number of the screw's harmonics that are searched for cogging
LEAST_COGGING = 0.1  # N; smaller waves are left to the observer
TURNS = (300e-6, 300e-6, 150e-6, 80e-6, 40e-6, 300e-6, 200e-6, 100e-6, 300e-6)  # m
TURN_SPEED = 15e-6  # m/s
PASS_RATE, TURN_RATE, BAND = 500.0, 200.0, 10.0  # Hz
ATTRACTION, BRISTLE_DAMPING = 65.0, 1e4  # N/s, N·s/m; the document's values, where tuning begins
PRINTED_SHAPE = 10.0  # the document's δ_l = 0.1 read as 1/δ_l; taken literally, z would hardly move
TRAVEL_ELEMENTS = (12,)  # number of elements over the bristle's travel, as in the document
SHAPES = np.geomspace(0.5, 20.0, 16)  # exponents of the Leuven law that are tried


@dataclass(frozen=True)
class Identified:
    """The results of the experiments: the map and its Stribeck curve, cogging, loops, elements, and laws by name."""

    points: FrictionMap
    stribeck: MapFit
    cogging: tuple[Wave, ...]
    turns: FrictionCourse
    elements: Elements
    laws: dict[str, FrictionTerm]

    def robot_without_friction(self) -> Robot:
        """Return the table as a controller knows it: with its cogging but without friction."""
        return _with_cogging(blank_table(), self.cogging)


def with_law(robot: Robot, term: FrictionTerm) -> Robot:
    """Return the table with a law in the place of its friction."""
    return robot.with_joint(robot.joint(JOINT).model_copy(update={"friction": (term,)}))


def identify_table(seed: int = 0) -> Identified:
    """Run the table's experiments and identify its cogging, its Stribeck curve, its elements and the four laws."""
    passes, turns = _experiment(_passes(), PASS_RATE, seed), _experiment(_turns(), TURN_RATE, seed + 1)
    blank = blank_table()
    course = friction_course(passes, blank, JOINT)
    phases = [_slid(phase, course) for phase in constant_speed_phases(course.motion)]
    cogging = cogging_waves(course, phases, harmonics(PITCH, HARMONICS).tolist(), LEAST_COGGING)
    known = _with_cogging(blank, cogging)
    friction = friction_course(passes, known, JOINT).friction
    (points,) = friction_maps(course.motion, friction[:, None], phases)
    stribeck = fit_map(points, find_law("stribeck"), "joint", 1.0)
    loops = friction_course(turns, known, JOINT, BAND)
    elements = elements_of(loops.position, loops.friction)
    laws = {
        "dahl": _dahl(loops, stribeck),
        "lugre": _lugre(loops, stribeck),
        "leuven": _leuven(loops, stribeck),
        "leuven over position": _leuven_over_position(stribeck, elements),
        "gms": _gms(stribeck, elements),
    }
    return Identified(points, stribeck, cogging, loops, elements, laws)


def _experiment(trajectory: Trajectory, rate: float, seed: int) -> Log:
    columns = simulate(
        true_table(),
        trajectory,
        recorder=Recorder(rate),
        control=replace(stiff_control(), seed=seed),
        controller_robot=blank_table(),
        seed=seed,
    )
    return log_from_table(pa.table(columns), "the table's own experiment")


def _passes() -> Trajectory:
    parts = [np.zeros(1)]
    for speed in SPEEDS.tolist():
        way = float(np.clip(SECONDS * speed, SHORTEST, LONGEST))
        own = forward_backward(JOINT, -0.5 * way, way, [speed], 8.0 * speed * speed / way).position[:, 0]
        there = move(parts[-1][-1:], own[:1], np.array([0.02]), np.array([0.2]))[:, 0]
        parts += [there, np.full(round(0.5 * KNOTS), own[0]), own]
    place = np.concatenate(parts)
    return Trajectory((JOINT,), np.arange(place.size) / KNOTS, place[:, None])


def _turns() -> Trajectory:
    return sawtooth(JOINT, 0.0, TURNS, TURN_SPEED)


def _slid(phase: Phase, course: FrictionCourse) -> Phase:
    way = np.abs(course.position[phase.first : phase.past] - course.position[phase.first])
    return replace(phase, first=phase.first + int(np.argmax(way > SLID)))


def _with_cogging(robot: Robot, waves: tuple[Wave, ...]) -> Robot:
    return robot.with_joint(robot.joint(JOINT).model_copy(update={"cogging": waves}))


def _curve(stribeck: MapFit) -> dict[str, float]:
    return {
        name: stribeck.values[name]
        for name in ("coulomb", "static", "stribeck_velocity", "stribeck_exponent", "viscous")
    }


def _dahl(loops: FrictionCourse, stribeck: MapFit) -> FrictionTerm:
    level = {"coulomb": stribeck.values["static"], "viscous": stribeck.values["viscous"]}
    return _curve_fitted("dahl", loops, level, {"bristle_stiffness": 1e6, "shape_exponent": 1.0})


def _lugre(loops: FrictionCourse, stribeck: MapFit) -> FrictionTerm:
    known = {**_curve(stribeck), "bristle_damping": BRISTLE_DAMPING}
    return _curve_fitted("lugre", loops, known, {"bristle_stiffness": 1e6})


def _curve_fitted(law: str, loops: FrictionCourse, known: dict[str, float], free: dict[str, float]) -> FrictionTerm:
    # Fit the logarithms of the free parameters.  Samples before the first of the largest turns are dropped: from there
    # on the law has forgotten its initial state.
    found, names = find_law(law), list(free)
    after = int(np.argmax(loops.position >= 0.99 * np.max(loops.position)))
    around, step = ambient(loops.friction.size), 1.0 / loops.motion.rate

    def values(x: Floats) -> dict[str, float]:
        return {**known, **dict(zip(names, np.exp(x).tolist(), strict=True))}

    def left(x: Floats) -> Floats:
        force, _ = found.follow(loops.velocity, around, step, found.pack(values(x)))
        return (force - loops.friction)[after:]

    fitted = least_squares(left, np.log(list(free.values())), x_scale=0.1, diff_step=1e-4)
    return FrictionTerm(law=law, parameters=values(fitted.x))


def _leuven(loops: FrictionCourse, stribeck: MapFit) -> FrictionTerm:
    # Position is converted to z for every exponent tried.  Take the exponent whose law then follows the loops best.
    curve = _curve(stribeck)
    tried = []
    for shape in SHAPES.tolist():
        level = np.full(loops.position.size, curve["static"])
        travel = bristle_travel(loops.position, loops.velocity, loops.friction, level, shape)
        tried.append(_leuven_of(curve, elements_of(travel, loops.friction, TRAVEL_ELEMENTS), shape))
    errors = [_following(loops, term) for term in tried]
    return tried[int(np.argmin(errors))]


def _leuven_over_position(stribeck: MapFit, elements: Elements) -> FrictionTerm:
    # The document's own method: its exponent, and the elements found over position.
    return _leuven_of(_curve(stribeck), elements, PRINTED_SHAPE)


def _leuven_of(curve: dict[str, float], elements: Elements, shape: float) -> FrictionTerm:
    level = elements.level.copy()
    # The bristle stops where the elements reach the Stribeck level, so the level of the last element never shows.
    # Raise it where the levels sum to less than the static level.
    level[-1] += max(0.0, 1.001 * curve["static"] - float(np.sum(level)))
    travel = level / elements.stiffness
    order = np.argsort(travel)
    values = {
        **curve,
        "bristle_damping": BRISTLE_DAMPING,
        "shape_exponent": shape,
        "stiffness": tuple(elements.stiffness[order].tolist()),
        "level": tuple(level[order].tolist()),
    }
    return FrictionTerm(law="leuven", parameters=values)


def _gms(stribeck: MapFit, elements: Elements) -> FrictionTerm:
    # Shares of the static level: the loops were traced slowly, where the Stribeck level equals it.  The last element
    # slips only beyond the turns seen, so it gets the rest of the level.
    share = elements.level / stribeck.values["static"]
    share[-1] = max(1.0 - float(np.sum(share[:-1])), 1e-3)
    share /= np.sum(share)
    order = np.argsort(share / elements.stiffness)
    values = {
        **_curve(stribeck),
        "attraction": ATTRACTION,
        "stiffness": tuple(elements.stiffness[order].tolist()),
        "share": tuple(share[order].tolist()),
    }
    return FrictionTerm(law="gms", parameters=values)


def _following(loops: FrictionCourse, term: FrictionTerm) -> float:
    force, _ = term.friction(1.0).follow(loops.velocity, ambient(loops.friction.size), 1.0 / loops.motion.rate)
    after = int(np.argmax(loops.position >= 0.99 * np.max(loops.position)))
    return float(np.sqrt(np.mean(np.square((force - loops.friction)[after:]))))


def following_errors(identified: Identified) -> dict[str, float]:
    """Return every law's RMS error, N, on the loops that it was fitted to."""
    return {name: _following(identified.turns, term) for name, term in identified.laws.items()}


def loop_of(term: FrictionTerm, position: Floats, rate: float) -> Floats:
    """Return the force of a law along a wanted course of positions (n,) at a rate (Hz)."""
    velocity = np.gradient(position) * rate
    return term.friction(1.0).follow(velocity, ambient(position.size), 1.0 / rate)[0]
