"""Changing a robot's friction: its levels, its directions, further laws."""

from __future__ import annotations

from collections.abc import Mapping

from mjfriction.laws.asymmetric import ASYMMETRIC
from mjfriction.laws.coulomb_viscous import COULOMB_VISCOUS
from mjfriction.laws.load_dependent import LOAD_DEPENDENT
from mjfriction.laws.stribeck import STRIBECK
from mjfriction.robot.robot import Robot
from mjfriction.robot.schema import FrictionTerm, Joint


def terms(joint: Joint) -> tuple[FrictionTerm, ...]:
    """Return the friction laws of a joint, none when it states none."""
    return joint.friction or ()


def reflection(term: FrictionTerm, joint: Joint) -> tuple[float, float]:
    """Return what turns a law's own torque and torque-per-speed into the joint's: 1, or the gear ratio's powers."""
    ratio = joint.actuator.gear_ratio if term.side == "motor" else 1.0
    return abs(ratio), ratio * ratio


def stated_levels(joint: Joint) -> tuple[float, float]:
    """Return Coulomb and viscous friction as stated, summed over the laws, at the joint."""
    coulomb = viscous = 0.0
    for term in terms(joint):
        level, rate = reflection(term, joint)
        values = term.parameters
        if term.law == ASYMMETRIC.name:
            coulomb += 0.5 * level * (values["coulomb_positive"] + values["coulomb_negative"])
            viscous += 0.5 * rate * (values["viscous_positive"] + values["viscous_negative"])
        else:
            coulomb += level * values.get("coulomb", 0.0)
            viscous += rate * values.get("viscous", 0.0)
    return coulomb, viscous


def stribeck_excess(joint: Joint) -> float:
    """Return how much friction near rest is stated above the Coulomb level, at the joint."""
    return sum(
        reflection(term, joint)[0] * (term.parameters["static"] - term.parameters["coulomb"])
        for term in terms(joint)
        if term.law == STRIBECK.name
    )


def stated_load(joint: Joint) -> float:
    """Return how fast friction is stated to grow with the transmitted load; the same on either side of the gear."""
    return sum(term.parameters["load"] for term in terms(joint) if term.law == LOAD_DEPENDENT.name)


def raised_levels(robot: Robot, joint: str, coulomb: float, viscous: float) -> Robot:
    """Return the robot with Coulomb and viscous friction of a joint raised (or lowered) by so much, at the joint.

    The change goes into the first law that has such levels, as far as they stay at least 0, then into the next; what
    no law can take becomes a Coulomb-viscous law of its own.
    """
    table = robot.joint(joint)
    changed = []
    for term in terms(table):
        level, rate = reflection(term, table)
        values = dict(term.parameters)
        for name, room, reflected in (("coulomb", coulomb, level), ("viscous", viscous, rate)):
            keys = [key for key in (name, f"{name}_positive", f"{name}_negative") if key in values]
            if not keys:
                continue
            lowest = min(values[key] for key in keys)
            step = max(room / reflected, -lowest)
            for key in keys:
                values[key] += step
            if name == "coulomb":
                if "static" in values:
                    values["static"] += step
                coulomb -= step * reflected
            else:
                viscous -= step * reflected
        changed.append(term.model_copy(update={"parameters": values}))
    if coulomb > 0.0 or viscous > 0.0:
        rest = {"coulomb": max(coulomb, 0.0), "viscous": max(viscous, 0.0)}
        changed.append(FrictionTerm(law=COULOMB_VISCOUS.name, parameters=rest))
    return robot.with_joint(table.model_copy(update={"friction": tuple(changed)}))


def with_term(robot: Robot, joint: str, law: str, parameters: Mapping[str, float]) -> Robot:
    """Return the robot with one more friction law on a joint, on the joint's side."""
    table = robot.joint(joint)
    term = FrictionTerm(law=law, parameters=dict(parameters))
    return robot.with_joint(table.model_copy(update={"friction": (*terms(table), term)}))


def with_asymmetric_damping(robot: Robot, joint: str, asymmetry: float) -> Robot:
    """Return the robot with a joint's damping raised by ``asymmetry`` forward and lowered by it backward.

    The joint's Coulomb-viscous law, or the damping of its other laws, becomes an asymmetric law.
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
            # A motor that turns against its joint sees the joint's forward motion as its own backward one.
            turned = ways[::-1] if term.side == "motor" and table.actuator.gear_ratio < 0.0 else ways
            for way, own in zip(ways, turned, strict=True):
                coulomb[f"coulomb_{way}"] += level * values.get(f"coulomb_{own}", values.get("coulomb", 0.0))
            forward, backward = (values.get(f"viscous_{own}", values.get("viscous", 0.0)) for own in turned)
            viscous += 0.5 * rate * (forward + backward)
            asymmetry += 0.5 * rate * (forward - backward)
            continue
        viscous += rate * values.pop("viscous", 0.0)
        kept.append(term.model_copy(update={"parameters": {**term.parameters, **_still(term)}}))
    # Damping cannot be negative in either direction; past that, friction would drive the joint.
    damping = {
        "viscous_positive": max(viscous + asymmetry, 0.0),
        "viscous_negative": max(viscous - asymmetry, 0.0),
    }
    joined = FrictionTerm(law=ASYMMETRIC.name, parameters={**coulomb, **damping})
    return robot.with_joint(table.model_copy(update={"friction": (joined, *kept)}))


def _still(term: FrictionTerm) -> dict[str, float]:
    return {"viscous": 0.0} if "viscous" in term.parameters else {}
