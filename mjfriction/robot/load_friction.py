"""Changing how a robot's friction grows with the load: what its laws state of that together, and others of them."""

from __future__ import annotations

from mjfriction.laws.geared_load import GEARED_LOAD
from mjfriction.laws.load_dependent import LOAD_DEPENDENT
from mjfriction.robot.friction import terms, with_term
from mjfriction.robot.friction_tables import FrictionTerm
from mjfriction.robot.robot import Robot
from mjfriction.robot.schema import Joint

# The coefficients of a law by which friction grows: where the drive works against the load, and where the load drives.
COEFFICIENTS = {LOAD_DEPENDENT.name: ("load", "load"), GEARED_LOAD.name: ("load_driving", "load_braking")}


def stated_loads(joint: Joint, *, includes_rotor: bool = False) -> tuple[float, float]:
    """Return how fast friction is stated to grow with the transmitted load, counted without or with what the rotor
    takes, where the drive works against it and where the load drives; the same on either side of the gear.
    """
    own = [term for term in terms(joint) if _of_load(term, includes_rotor)]
    driving, braking = ([term.value(COEFFICIENTS[term.law][way]) for term in own] for way in (0, 1))
    return sum(driving), sum(braking)


def stated_load(joint: Joint, *, includes_rotor: bool = False) -> float:
    """Return how fast friction is stated to grow with the load in either direction of power."""
    return min(stated_loads(joint, includes_rotor=includes_rotor))


def with_less_load(robot: Robot, joint: str, less: float, *, includes_rotor: bool = False) -> Robot:
    """Return the robot with friction of a joint that grows by so much less with the load than is stated, in the laws
    that :func:`stated_load` sums up, as far as they go.
    """
    table, changed = robot.joint(joint), []
    for term in terms(table):
        lowered = term
        if _of_load(term, includes_rotor):
            taken = min(less, *(term.value(name) for name in COEFFICIENTS[term.law]))
            less -= taken
            lowered = _lowered(term, dict.fromkeys(COEFFICIENTS[term.law], taken))
        changed.append(lowered)
    return robot.with_joint(table.model_copy(update={"friction": tuple(changed)}))


def with_loads(robot: Robot, joint: str, driving: float, braking: float, *, includes_rotor: bool = False) -> Robot:
    """Return the robot with friction of a joint that grows with the load by these coefficients, in a law of its own, in
    the place of what is stated.
    """
    table = robot.joint(joint)
    without = tuple(
        _lowered(term, {name: term.value(name) for name in COEFFICIENTS[term.law]})
        if _of_load(term, includes_rotor)
        else term
        for term in terms(table)
    )
    robot = robot.with_joint(table.model_copy(update={"friction": without}))
    own = {"coulomb": 0.0, "load_driving": driving, "load_braking": braking, "viscous": 0.0}
    return with_term(robot, joint, GEARED_LOAD.name, own, load_includes_rotor=includes_rotor)


def _of_load(term: FrictionTerm, includes_rotor: bool) -> bool:
    return term.law in COEFFICIENTS and term.load_includes_rotor == includes_rotor


def _lowered(term: FrictionTerm, less: dict[str, float]) -> FrictionTerm:
    lower = {name: term.value(name) - taken for name, taken in less.items()}
    return term.model_copy(update={"parameters": {**term.parameters, **lower}})
