"""Read and change how a robot's friction grows with load, over all its load-dependent laws."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import numpy as np

from mjfriction.laws.geared_load import GEARED_LOAD
from mjfriction.laws.load_dependent import LOAD_DEPENDENT
from mjfriction.laws.rules import Values, scalar
from mjfriction.robot.friction import terms
from mjfriction.robot.friction_tables import FrictionTerm
from mjfriction.robot.robot import Robot
from mjfriction.robot.schema import Joint

# Parameter names of each law's load coefficients: where the drive works against the load, and where the load drives.
COEFFICIENTS = {LOAD_DEPENDENT.name: ("load", "load"), GEARED_LOAD.name: ("load_driving", "load_braking")}


def stated_loads(joint: Joint, *, includes_rotor: bool = False) -> tuple[float, float]:
    """Return the stated load coefficients of friction, summed over the laws.

    The first is for motion where the drive works against the load, the second for motion where the load drives.  With
    ``includes_rotor`` only laws whose load includes the rotor's torque count, otherwise only the others.  The
    coefficients are the same on either side of the gear.
    """
    own = [term for term in terms(joint) if _of_load(term, includes_rotor)]
    driving, braking = ([term.value(COEFFICIENTS[term.law][way]) for term in own] for way in (0, 1))
    return sum(driving), sum(braking)


def stated_load(joint: Joint, *, includes_rotor: bool = False) -> float:
    """Return the stated load coefficient common to both directions of power: the smaller of the two."""
    return min(stated_loads(joint, includes_rotor=includes_rotor))


def with_less_load(robot: Robot, joint: str, less: float, *, includes_rotor: bool = False) -> Robot:
    """Return the robot with a joint's load coefficient lowered by ``less`` in all directions of motion and power.

    The reduction is taken from the laws that :func:`stated_load` sums up, one after another; no coefficient falls below
    0, so less than ``less`` is taken where they state too little.
    """
    table, changed = robot.joint(joint), []
    for term in terms(table):
        lowered = term
        if _of_load(term, includes_rotor):
            taken = min(less, *(coefficient for way in _ways(term) for coefficient in way))
            less -= taken
            lowered = _moved(term, partial(_less, taken))
        changed.append(lowered)
    return robot.with_joint(table.model_copy(update={"friction": tuple(changed)}))


def with_more_load(robot: Robot, joint: str, more: tuple[float, float], *, includes_rotor: bool = False) -> Robot:
    """Return the robot with a joint's load coefficients changed by ``more``, down to no less than 0.

    ``more`` holds the changes where the drive works against the load and where the load drives.  All load dependence,
    stated and added, moves into one law of its own.
    """
    table = robot.joint(joint)
    own = [term for term in terms(table) if _of_load(term, includes_rotor)]
    stated = np.sum([_ways(term) for term in own], axis=0) if own else np.zeros((2, 2))
    forward, backward = (_geared(*way) for way in np.maximum(0.0, stated + more).tolist())
    rest = (_moved(term, lambda _: 0.0) if term in own else term for term in terms(table))
    geared = FrictionTerm(
        law=GEARED_LOAD.name,
        parameters={"coulomb": 0.0, **forward, "viscous": 0.0},
        negative=None if backward == forward else backward,
        load_includes_rotor=includes_rotor,
    )
    return robot.with_joint(table.model_copy(update={"friction": (*rest, geared)}))


def _less(taken: float, load: float) -> float:
    return load - taken


def _of_load(term: FrictionTerm, includes_rotor: bool) -> bool:
    return term.law in COEFFICIENTS and term.load_includes_rotor == includes_rotor


def _ways(term: FrictionTerm) -> list[list[float]]:
    # The two load coefficients for forward motion, then the two for backward motion.
    sides = (term.parameters, {**term.parameters, **(term.negative or {})})
    return [[scalar(values, name) for name in COEFFICIENTS[term.law]] for values in sides]


def _geared(driving: float, braking: float) -> dict[str, float]:
    return {"load_driving": driving, "load_braking": braking}


def _moved(term: FrictionTerm, move: Callable[[float], float]) -> FrictionTerm:
    def moved(values: Values) -> Values:
        own = COEFFICIENTS[term.law]
        return {name: move(scalar(values, name)) if name in own else values[name] for name in values}

    negative = None if term.negative is None else moved(term.negative)
    return term.model_copy(update={"parameters": moved(term.parameters), "negative": negative})
