"""Read and change a robot's friction: its levels, its directions, additional laws."""

from __future__ import annotations

import math
from collections.abc import Mapping

from mjfriction.laws.asymmetric import ASYMMETRIC
from mjfriction.laws.catalog import find_law
from mjfriction.laws.coulomb_viscous import COULOMB_VISCOUS
from mjfriction.laws.rules import SumReaches, Values, array, scalar
from mjfriction.laws.stribeck import STRIBECK
from mjfriction.robot.friction_tables import FrictionTerm, LevelTable
from mjfriction.robot.robot import Robot
from mjfriction.robot.schema import Joint
from mjfriction.robot.table import Edge, Spot, Wave

LEVELS = (
    "coulomb",
    "static",
    "static_rested",
    "coulomb_positive",
    "coulomb_negative",
    "level",
    "level_extending",
    "level_retracting",
)
DAMPINGS = ("viscous", "viscous_positive", "viscous_negative", "viscous_extending", "viscous_retracting")
SUM_REACHES_STATIC = SumReaches("level", "static")


def terms(joint: Joint) -> tuple[FrictionTerm, ...]:
    """Return the friction laws of a joint, none when it states none."""
    return joint.friction or ()


def reflection(term: FrictionTerm, joint: Joint) -> tuple[float, float]:
    """Return the factors from a law's torque and torque per speed to the joint's: 1, or |gear ratio| and its square."""
    ratio = joint.actuator.gear_ratio if term.side == "motor" else 1.0
    return abs(ratio), ratio * ratio


def coulomb_level(term: FrictionTerm) -> float:
    """Return the Coulomb level of a law at speed, on the law's own side, averaged over the directions."""
    if "stribeck_fall" in term.parameters:
        return term.value("static") + 0.5 * math.pi * term.value("stribeck_fall")
    if "coulomb" not in term.parameters and isinstance(term.parameters.get("level"), tuple):
        return float(sum(array(term.parameters, "level")))
    pairs = (("coulomb_positive", "coulomb_negative"), ("level_extending", "level_retracting"))
    for forward, backward in pairs:
        if forward in term.parameters:
            return 0.5 * (term.value(forward) + term.value(backward))
    return term.value("coulomb") + term.value("level")


def viscous_rate(term: FrictionTerm) -> float:
    """Return a law's linear damping, on the law's own side, averaged over the directions."""
    pairs = (("viscous_positive", "viscous_negative"), ("viscous_extending", "viscous_retracting"))
    return term.value("viscous") + sum(0.5 * (term.value(one) + term.value(other)) for one, other in pairs)


def stated_levels(joint: Joint) -> tuple[float, float]:
    """Return the stated Coulomb and viscous levels at the joint, summed over its laws."""
    coulomb = viscous = 0.0
    for term in terms(joint):
        level, rate = reflection(term, joint)
        coulomb += level * coulomb_level(term)
        viscous += rate * viscous_rate(term)
    return coulomb, viscous


def stribeck_excess(joint: Joint) -> float:
    """Return how far friction near rest is stated above the Coulomb level, at the joint, summed over Stribeck laws."""
    return sum(
        reflection(term, joint)[0] * (term.value("static") - term.value("coulomb"))
        for term in terms(joint)
        if term.law == STRIBECK.name
    )


def stribeck_shapes(joint: Joint) -> tuple[tuple[float, float], ...]:
    """Return the Stribeck velocity (at the joint) and the exponent of every stated Stribeck law."""
    return tuple(
        (
            term.value("stribeck_velocity") / reflection(term, joint)[0],
            term.value("stribeck_exponent"),
        )
        for term in terms(joint)
        if term.law == STRIBECK.name
    )


def with_less_stribeck(robot: Robot, joint: str, excess: float) -> Robot:
    """Return the robot with the friction near rest above a joint's Coulomb level lowered by ``excess``, down to 0."""
    table = robot.joint(joint)
    kept = max(0.0, 1.0 - excess / stribeck_excess(table))

    def less(values: Mapping[str, float | tuple[float, ...]]) -> dict[str, float | tuple[float, ...]]:
        coulomb = scalar(values, "coulomb")
        return {**values, "static": coulomb + kept * (scalar(values, "static") - coulomb)}

    lowered = tuple(
        term.model_copy(
            update={
                "parameters": less(term.parameters),
                "negative": None if term.negative is None else less({**term.parameters, **term.negative}),
            }
        )
        if term.law == STRIBECK.name
        else term
        for term in terms(table)
    )
    return robot.with_joint(table.model_copy(update={"friction": lowered}))


def raised_levels(robot: Robot, joint: str, coulomb: float, viscous: float) -> Robot:
    """Return the robot with a joint's Coulomb and viscous levels raised (or lowered) by amounts given at the joint.

    The change goes into the first law that has such levels, as far as they stay at or above 0, then into the next.  An
    increase that no law can take becomes a new Coulomb-viscous law; a decrease that no law can take is dropped.
    """
    table = robot.joint(joint)
    changed = []
    for stated in terms(table):
        level, rate = reflection(stated, table)
        step, left = _taken(coulomb, level, [coulomb_level(stated), *_scalars(stated, LEVELS)])
        raised = _level_raised(stated, step)
        if raised is not None:
            coulomb = left
        damped = raised or stated
        dampings = _scalars(stated, DAMPINGS)
        if dampings:
            step, viscous = _taken(viscous, rate, dampings)
            damped = _changed(damped, dict.fromkeys(DAMPINGS, step))
        changed.append(damped)
    if coulomb > 0.0 or viscous > 0.0:
        rest = {"coulomb": max(coulomb, 0.0), "viscous": max(viscous, 0.0)}
        changed.append(FrictionTerm(law=COULOMB_VISCOUS.name, parameters=rest))
    return robot.with_joint(table.model_copy(update={"friction": tuple(changed)}))


def _taken(change: float, per_step: float, values: list[float]) -> tuple[float, float]:
    # The largest step of the values, up to the whole change, that takes none of them below 0, and the rest of the
    # change: 0, or negative.
    step, lowest = change / per_step, -min(values)
    return (step, 0.0) if step >= lowest else (lowest, change - lowest * per_step)


def _scalars(term: FrictionTerm, names: tuple[str, ...]) -> list[float]:
    sets = (term.parameters, term.negative or {})
    return [scalar(values, name) for values in sets for name in names if isinstance(values.get(name), float)]


def _level_raised(term: FrictionTerm, step: float) -> FrictionTerm | None:
    if _scalars(term, LEVELS):
        raised = _changed(term, dict.fromkeys(LEVELS, step))
        if SUM_REACHES_STATIC not in find_law(term.law).rules:
            return raised
        return _stretched(raised, max(1.0, raised.value("static") / sum(array(raised.parameters, "level"))))
    if isinstance(term.parameters.get("level"), tuple):
        return _stretched(term, 1.0 + step / coulomb_level(term))
    return None


def _changed(term: FrictionTerm, steps: Mapping[str, float]) -> FrictionTerm:
    def moved(values: Mapping[str, float | tuple[float, ...]]) -> dict[str, float | tuple[float, ...]]:
        return {
            name: value + steps[name] if name in steps and not isinstance(value, tuple) else value
            for name, value in values.items()
        }

    negative = None if term.negative is None else moved(term.negative)
    return term.model_copy(update={"parameters": moved(term.parameters), "negative": negative})


def _stretched(term: FrictionTerm, factor: float) -> FrictionTerm:
    # Scale level and stiffness together, so that every element still breaks away after the same travel.
    own = {name: tuple(factor * x for x in array(term.parameters, name)) for name in ("level", "stiffness")}
    return term.model_copy(update={"parameters": {**term.parameters, **own}})


def with_term(robot: Robot, joint: str, law: str, parameters: Values, *, load_includes_rotor: bool = False) -> Robot:
    """Return the robot with one more friction law on a joint, on the joint's side."""
    table = robot.joint(joint)
    term = FrictionTerm(law=law, parameters=dict(parameters), load_includes_rotor=load_includes_rotor)
    return robot.with_joint(table.model_copy(update={"friction": (*terms(table), term)}))


def with_friction_wave(robot: Robot, joint: str, wave: Wave) -> Robot:
    """Return the robot with one more wave on a joint's friction level.

    If the joint has no plain Coulomb-viscous law to carry the wave, one with zero levels is added.
    """
    return _with_more(robot, joint, "friction_waves", wave)


def with_friction_spot(robot: Robot, joint: str, spot: Spot) -> Robot:
    """Return the robot with one more spot on a joint's friction level, as :func:`with_friction_wave` adds a wave."""
    return _with_more(robot, joint, "friction_spots", spot)


def with_friction_edge(robot: Robot, joint: str, edge: Edge) -> Robot:
    """Return the robot with one more edge on a joint's friction level, as :func:`with_friction_wave` adds a wave."""
    return _with_more(robot, joint, "friction_edges", edge)


def _with_more(robot: Robot, joint: str, key: str, more: Wave | Spot | Edge) -> Robot:
    robot = _with_plain_law(robot, joint)
    table = robot.joint(joint)
    return robot.with_joint(table.model_copy(update={key: (*getattr(table, key), more)}))


def varies_along_stroke(joint: Joint) -> bool:
    """Return whether a joint states waves, spots or edges of its friction level, which need a plain law."""
    return bool(joint.friction_waves or joint.friction_spots or joint.friction_edges)


def _with_plain_law(robot: Robot, joint: str) -> Robot:
    carried = any(
        term.law == COULOMB_VISCOUS.name
        and term.side == "joint"
        and term.negative is None
        and term.level == LevelTable()
        for term in terms(robot.joint(joint))
    )
    return robot if carried else with_term(robot, joint, COULOMB_VISCOUS.name, {"coulomb": 0.0, "viscous": 0.0})


def with_asymmetric_damping(robot: Robot, joint: str, asymmetry: float) -> Robot:
    """Return the robot with a joint's damping raised by ``asymmetry`` forward and lowered by it backward.

    The joint's Coulomb-viscous and asymmetric laws, and the damping of its other laws, merge into one asymmetric law.
    """
    table = robot.joint(joint)
    coulomb = {"coulomb_positive": 0.0, "coulomb_negative": 0.0}
    viscous = 0.0
    kept = []
    for term in terms(table):
        level, rate = reflection(term, table)
        values = dict(term.parameters)
        if term.law in (COULOMB_VISCOUS.name, ASYMMETRIC.name):
            ways = ("positive", "negative")
            # With a negative gear ratio, forward motion of the joint is backward motion of the motor.
            turned = ways[::-1] if term.side == "motor" and table.actuator.gear_ratio < 0.0 else ways
            sides = {"positive": values, "negative": {**values, **(term.negative or {})}}

            def of(name: str, way: str, sides: Mapping[str, Values] = sides) -> float:
                return scalar(sides[way], f"{name}_{way}" if f"{name}_{way}" in sides[way] else name)

            for way, own in zip(ways, turned, strict=True):
                coulomb[f"coulomb_{way}"] += level * of("coulomb", own)
            forward, backward = (of("viscous", own) for own in turned)
            viscous += 0.5 * rate * (forward + backward)
            asymmetry += 0.5 * rate * (forward - backward)
            continue
        viscous += rate * term.value("viscous")
        kept.append(_still(term))
    # Damping must not be negative in either direction: negative friction would drive the joint.
    damping = {
        "viscous_positive": max(viscous + asymmetry, 0.0),
        "viscous_negative": max(viscous - asymmetry, 0.0),
    }
    if varies_along_stroke(table):
        # Keep a plain law with the part of the Coulomb level that both directions share.
        level = min(coulomb.values())
        coulomb = {way: own - level for way, own in coulomb.items()}
        kept.insert(0, FrictionTerm(law=COULOMB_VISCOUS.name, parameters={"coulomb": level, "viscous": 0.0}))
    joined = FrictionTerm(law=ASYMMETRIC.name, parameters={**coulomb, **damping})
    return robot.with_joint(table.model_copy(update={"friction": (joined, *kept)}))


def _still(term: FrictionTerm) -> FrictionTerm:
    def still(values: Mapping[str, float | tuple[float, ...]]) -> dict[str, float | tuple[float, ...]]:
        return {name: 0.0 if name == "viscous" else value for name, value in values.items()}

    negative = None if term.negative is None else still(term.negative)
    return term.model_copy(update={"parameters": still(term.parameters), "negative": negative})
