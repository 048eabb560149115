"""Friction that the stated law does not have."""

from __future__ import annotations

import numpy as np

from mjfriction.benchmark.effects.effect import Effect, Place, on_joint, sign, updated, wave_along
from mjfriction.robot.friction import (
    raised_levels,
    with_asymmetric_damping,
    with_friction_edge,
    with_friction_spot,
    with_friction_wave,
    with_term,
)
from mjfriction.robot.friction_tables import Event, PressureFriction, Thermal, WarmUp
from mjfriction.robot.robot import Robot
from mjfriction.robot.table import Edge, Spot

# Probability that friction that varies along the stroke is a wave, and that one that is not is an edge; otherwise it is
# a worn spot.
WAVING, EDGED = 0.6, 0.5
CHAMBERS = 0.6  # probability that each chamber presses its own seal; otherwise their difference presses one seal


def coulomb_viscous(rng: np.random.Generator, place: Place) -> Effect:
    """Stated levels that are off, both in the same direction."""
    shares = rng.uniform(0.5, 1.0, 2) * sign(rng)
    levels = (place.coulomb * shares[0], place.viscous * shares[1])

    def change(robot: Robot, a: float) -> Robot:
        return raised_levels(robot, place.joint, a * levels[0], a * levels[1])

    largest = float(np.max(np.abs(shares)))
    return on_joint("friction.coulomb_viscous", place, change, 0.3, 0.9, of_stated=largest)


def stribeck(rng: np.random.Generator, place: Place) -> Effect:
    """Extra friction that fades over a small part of the usual speed."""
    velocity = float(place.speed * np.exp(rng.uniform(np.log(0.08), np.log(0.35))))
    exponent = float(rng.choice([1.0, 2.0, rng.uniform(0.7, 2.5)]))

    def change(robot: Robot, a: float) -> Robot:
        values = {"stribeck_velocity": velocity, "stribeck_exponent": exponent, "coulomb": 0.0, "viscous": 0.0}
        return with_term(robot, place.joint, "stribeck", {**values, "static": a * place.coulomb})

    return on_joint("friction.stribeck", place, change, 0.5, 2.0)


def viscous_nonlinear(rng: np.random.Generator, place: Place) -> Effect:
    """Damping that saturates as the joint runs faster, or friction that grows with the square of speed."""
    half = float(place.speed * rng.uniform(0.5, 2.0))

    def saturating(robot: Robot, a: float) -> Robot:
        values = {"coulomb": 0.0, "viscous": a * place.viscous, "half_velocity": half}
        return with_term(robot, place.joint, "saturating_viscous", values)

    def quadratic(robot: Robot, a: float) -> Robot:
        values = {"coulomb": 0.0, "viscous": 0.0, "quadratic": a * place.viscous / place.speed}
        return with_term(robot, place.joint, "quadratic_viscous", values)

    return on_joint("friction.viscous_nonlinear", place, rng.choice([saturating, quadratic]), 0.5, 8.0)  # type: ignore[arg-type]


def asymmetry(rng: np.random.Generator, place: Place) -> Effect:
    """Damping that differs between directions."""
    way = sign(rng) * place.viscous
    return on_joint(
        "friction.asymmetry", place, lambda r, a: with_asymmetric_damping(r, place.joint, a * way), 0.3, 1.0
    )


def load(rng: np.random.Generator, place: Place) -> Effect:
    """A level that grows with the load."""
    del rng
    values = {"coulomb": 0.0, "viscous": 0.0}
    return on_joint(
        "friction.load",
        place,
        lambda r, a: with_term(r, place.joint, "load_dependent", {**values, "load": a}),
        0.05,
        0.5,
    )


def presliding(rng: np.random.Generator, place: Place) -> Effect:
    """Friction that builds up over a travel after each reversal, all of the Coulomb level or most of it."""
    share = float(rng.uniform(0.6, 1.0))
    elements = int(rng.choice([1, 4]))

    def change(robot: Robot, a: float) -> Robot:
        level = share * place.coulomb
        robot = raised_levels(robot, place.joint, -level, 0.0)
        travel = a * place.stroke
        if elements == 1:
            values = {"coulomb": level, "bristle_stiffness": level / travel, "shape_exponent": 1.0, "viscous": 0.0}
            return with_term(robot, place.joint, "dahl", values)
        levels = np.full(elements, level / elements)
        reach = 2.0 * travel * np.arange(1, elements + 1) / elements
        slip = {"viscous": 0.0, "stiffness": tuple((levels / reach).tolist()), "level": tuple(levels.tolist())}
        return with_term(robot, place.joint, "maxwell_slip", slip)  # type: ignore[arg-type]

    return on_joint("friction.presliding", place, change, 0.01, 0.08)


def position(rng: np.random.Generator, place: Place) -> Effect:
    """A level that rises and falls along the stroke, or is higher at one place of it, or from there on."""
    wave = wave_along(rng, place, 10.0)
    # Seeded from the wave, so that the other draws of a seed are the same as before spots and edges were added.
    own = np.random.default_rng(int(1e6 * wave(1.0).wavenumber))
    where, width, waves = own.uniform(0.15, 0.85), own.uniform(0.04, 0.2), own.random() < WAVING
    edged, sharp, side = own.random() < EDGED, own.uniform(0.005, 0.06), str(own.choice(["above", "below"]))
    low = float(np.min(place.course))

    def waving(robot: Robot, a: float) -> Robot:
        return with_friction_wave(robot, place.joint, wave(a))

    def worn(robot: Robot, a: float) -> Robot:
        level = 2.0 * a * place.coulomb
        spot = Spot(position=low + where * place.stroke, width=width * place.stroke, coulomb=level)
        return with_friction_spot(robot, place.joint, spot)

    def dry(robot: Robot, a: float) -> Robot:
        edge = Edge(
            position=low + where * place.stroke, width=sharp * place.stroke, coulomb=a * place.coulomb, side=side
        )
        return with_friction_edge(robot, place.joint, edge)

    return on_joint("friction.position", place, waving if waves else dry if edged else worn, 0.3, 0.95)


def temperature(rng: np.random.Generator, place: Place) -> Effect:
    """Friction that falls as the joint warms, with or without a thermometer."""
    seconds = float(np.ptp(place.time))
    tau = float(seconds * np.exp(rng.uniform(np.log(0.25), np.log(1.5))))
    shares = rng.uniform(0.3, 1.0, 2)
    levels = -np.array([place.coulomb, place.viscous]) * shares
    if rng.random() < 0.5:

        def drifting(robot: Robot, a: float) -> Robot:
            warm = WarmUp(coulomb=a * levels[0], viscous=a * levels[1], time_constant=tau)
            return updated(robot, place.joint, warm_up=warm)

        return on_joint("friction.temperature", place, drifting, 0.3, 0.9)
    rise = float(rng.uniform(6.0, 20.0))
    course = 25.0 + rise * -np.expm1(-place.time / tau)

    def warming(robot: Robot, a: float) -> Robot:
        own = Thermal(coulomb_per_kelvin=a * levels[0] / rise, viscous_per_kelvin=a * levels[1] / rise)
        return updated(robot, place.joint, thermal=own)

    return on_joint("friction.temperature", place, warming, 0.3, 0.9, {f"temperature.{place.joint}": course})


def step(rng: np.random.Generator, place: Place) -> Effect:
    """Friction that steps at one moment."""
    moment = float(place.time[0] + np.ptp(place.time) * rng.uniform(0.2, 0.8))
    levels = np.array([place.coulomb, place.viscous]) * rng.uniform(0.4, 1.0, 2)

    def change(robot: Robot, a: float) -> Robot:
        event = Event(time=moment, coulomb=a * levels[0], viscous=a * levels[1])
        return updated(robot, place.joint, events=(event,))

    return on_joint("event.change", place, change, 0.3, 2.0)


def pressure(rng: np.random.Generator, place: Place) -> Effect:
    """Friction of seals that the chamber pressures press on."""
    slow = 2.0 * np.pi * rng.uniform(0.05, 0.3, (2, 3))
    phase = rng.uniform(0.0, 2.0 * np.pi, (2, 3))
    courses = 4e6 + 8e5 * np.sin(place.time[:, None, None] * slow + phase).sum(axis=2)
    head, rod = (rng.uniform(0.2, 1.0, 2) * place.coulomb / 4e6).tolist()
    pressed = {"head": head, "rod": rod} if rng.random() < CHAMBERS else {"difference": head + rod}

    def change(robot: Robot, a: float) -> Robot:
        grown = PressureFriction(**{name: a * per_pascal for name, per_pascal in pressed.items()})
        return updated(robot, place.joint, pressure_friction=grown)

    ambient = {f"pressure_{side}.{place.joint}": courses[:, i] for i, side in enumerate(("head", "rod"))}
    return on_joint("hydraulic.pressure", place, change, 0.5, 4.0, ambient)
