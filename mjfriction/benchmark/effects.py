"""The hidden effects: each turns a robot into one that has something its maker does not know of.

An effect is drawn at a place, with whatever shape it has; how strong it is, is one number that the case scales until
the effect stands out of the noise as much as was asked.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from mjfriction.body.inverse import inertia_at
from mjfriction.body.regressor import tip_link
from mjfriction.laws.law import Floats
from mjfriction.robot.friction import raised_levels, stated_levels, with_asymmetric_damping, with_term
from mjfriction.robot.robot import Robot
from mjfriction.robot.schema import (
    CommonDrive,
    Coupling,
    Event,
    Joint,
    Payload,
    PressureFriction,
    Spring,
    Thermal,
    WarmUp,
    Wave,
)

SLOWEST_SWING = 10.0  # Hz

Change = Callable[[Robot, float], Robot]


@dataclass(frozen=True)
class Effect:
    """One hidden effect: its ``cause``, its ``joint`` (None for the whole arm), the ``change`` it makes at a strength,
    the strength to ``begin`` with and the ``most`` there may be of it, and columns the log gains by it.
    """

    cause: str
    joint: str | None
    change: Change
    begin: float
    most: float
    ambient: Mapping[str, Floats]


@dataclass(frozen=True)
class Place:
    """Where an effect is drawn: the robot, a joint of it, that joint's stroke, centre and usual speed, and the time."""

    robot: Robot
    joint: str
    centre: float
    stroke: float
    speed: float
    time: Floats

    @property
    def coulomb(self) -> float:
        """The joint's Coulomb level."""
        return stated_levels(self.robot.joint(self.joint))[0]

    @property
    def viscous(self) -> float:
        """The joint's damping."""
        return stated_levels(self.robot.joint(self.joint))[1]


Draw = Callable[[np.random.Generator, Place], Effect]


def _on_joint(
    cause: str, place: Place, change: Change, begin: float, most: float, ambient: Mapping[str, Floats] | None = None
) -> Effect:
    return Effect(cause, place.joint, change, begin, most, ambient or {})


def _updated(robot: Robot, joint: str, **changes: object) -> Robot:
    table: Joint = robot.joint(joint)
    return robot.with_joint(table.model_copy(update=changes))


def _sign(rng: np.random.Generator) -> float:
    return float(rng.choice([-1.0, 1.0]))


def coulomb_viscous(rng: np.random.Generator, place: Place) -> Effect:
    """Levels that are off, both by a like share."""
    shares = rng.uniform(0.5, 1.0, 2) * _sign(rng)
    levels = (place.coulomb * shares[0], place.viscous * shares[1])
    return _on_joint(
        "friction.coulomb_viscous",
        place,
        lambda r, a: raised_levels(r, place.joint, a * levels[0], a * levels[1]),
        0.3,
        0.9,
    )


def stribeck(rng: np.random.Generator, place: Place) -> Effect:
    """Extra friction that fades over a small part of the usual speed."""
    velocity = float(place.speed * np.exp(rng.uniform(np.log(0.08), np.log(0.35))))
    exponent = float(rng.choice([1.0, 2.0, rng.uniform(0.7, 2.5)]))

    def change(robot: Robot, a: float) -> Robot:
        values = {"stribeck_velocity": velocity, "stribeck_exponent": exponent, "coulomb": 0.0, "viscous": 0.0}
        return with_term(robot, place.joint, "stribeck", {**values, "static": a * place.coulomb})

    return _on_joint("friction.stribeck", place, change, 0.5, 2.0)


def viscous_nonlinear(rng: np.random.Generator, place: Place) -> Effect:
    """Damping that thins as the joint runs faster, or grows with the square of speed."""
    half = float(place.speed * rng.uniform(0.5, 2.0))

    def saturating(robot: Robot, a: float) -> Robot:
        values = {"coulomb": 0.0, "viscous": a * place.viscous, "half_velocity": half}
        return with_term(robot, place.joint, "saturating_viscous", values)

    def quadratic(robot: Robot, a: float) -> Robot:
        values = {"coulomb": 0.0, "viscous": 0.0, "quadratic": a * place.viscous / place.speed}
        return with_term(robot, place.joint, "quadratic_viscous", values)

    return _on_joint("friction.viscous_nonlinear", place, rng.choice([saturating, quadratic]), 0.5, 8.0)  # type: ignore[arg-type]


def asymmetry(rng: np.random.Generator, place: Place) -> Effect:
    """Damping that differs between directions."""
    way = _sign(rng) * place.viscous
    return _on_joint(
        "friction.asymmetry", place, lambda r, a: with_asymmetric_damping(r, place.joint, a * way), 0.3, 1.0
    )


def load(rng: np.random.Generator, place: Place) -> Effect:
    """A level that grows with the load."""
    del rng
    values = {"coulomb": 0.0, "viscous": 0.0}
    return _on_joint(
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

    return _on_joint("friction.presliding", place, change, 0.01, 0.08)


def position(rng: np.random.Generator, place: Place) -> Effect:
    """A level that rises and falls along the stroke."""
    wavenumber = 2.0 * np.pi * rng.uniform(1.7, 10.0) / place.stroke
    phase = rng.uniform(0.0, 2.0 * np.pi)

    def change(robot: Robot, a: float) -> Robot:
        level = a * place.coulomb
        wave = Wave(wavenumber=wavenumber, cosine=level * np.cos(phase), sine=level * np.sin(phase))
        return _updated(robot, place.joint, friction_waves=(wave,))

    return _on_joint("friction.position", place, change, 0.3, 0.95)


def temperature(rng: np.random.Generator, place: Place) -> Effect:
    """Friction that falls as the joint warms, with or without a thermometer."""
    seconds = float(np.ptp(place.time))
    tau = float(seconds * np.exp(rng.uniform(np.log(0.25), np.log(1.5))))
    shares = rng.uniform(0.3, 1.0, 2)
    levels = -np.array([place.coulomb, place.viscous]) * shares
    if rng.random() < 0.5:

        def drifting(robot: Robot, a: float) -> Robot:
            warm = WarmUp(coulomb=a * levels[0], viscous=a * levels[1], time_constant=tau)
            return _updated(robot, place.joint, warm_up=warm)

        return _on_joint("friction.temperature", place, drifting, 0.3, 0.9)
    rise = float(rng.uniform(6.0, 20.0))
    course = 25.0 + rise * -np.expm1(-place.time / tau)

    def warming(robot: Robot, a: float) -> Robot:
        own = Thermal(coulomb_per_kelvin=a * levels[0] / rise, viscous_per_kelvin=a * levels[1] / rise)
        return _updated(robot, place.joint, thermal=own)

    return _on_joint("friction.temperature", place, warming, 0.3, 0.9, {f"temperature.{place.joint}": course})


def cogging(rng: np.random.Generator, place: Place) -> Effect:
    """A torque that repeats along the stroke."""
    wavenumber = 2.0 * np.pi * rng.uniform(1.7, 12.0) / place.stroke
    phase = rng.uniform(0.0, 2.0 * np.pi)

    def change(robot: Robot, a: float) -> Robot:
        level = a * place.coulomb
        wave = Wave(wavenumber=wavenumber, cosine=level * np.cos(phase), sine=level * np.sin(phase))
        return _updated(robot, place.joint, cogging=(wave,))

    return _on_joint("drive.cogging", place, change, 0.3, 2.0)


def torque_constant(rng: np.random.Generator, place: Place) -> Effect:
    """A reading that is a factor off."""
    way = _sign(rng)

    def change(robot: Robot, a: float) -> Robot:
        sensor = robot.joint(place.joint).effort_sensor
        return _updated(robot, place.joint, effort_sensor=sensor.model_copy(update={"scale": 1.0 + way * a}))

    return _on_joint("drive.torque_constant", place, change, 0.1, 0.4)


def offset(rng: np.random.Generator, place: Place) -> Effect:
    """A constant in the reading."""
    way = _sign(rng) * place.coulomb

    def change(robot: Robot, a: float) -> Robot:
        sensor = robot.joint(place.joint).effort_sensor
        return _updated(robot, place.joint, effort_sensor=sensor.model_copy(update={"offset": way * a}))

    return _on_joint("drive.offset", place, change, 0.2, 2.0)


def backlash(rng: np.random.Generator, place: Place) -> Effect:
    """Play in the transmission."""
    del rng

    def change(robot: Robot, a: float) -> Robot:
        own = robot.joint(place.joint).transmission
        return _updated(robot, place.joint, transmission=own.model_copy(update={"backlash": a}))

    return _on_joint("drive.backlash", place, change, 0.01, 0.06)


def elasticity(rng: np.random.Generator, place: Place) -> Effect:
    """A transmission that gives, stiff enough that the link does not swing on it in the motion's own band."""
    del rng
    body = place.robot.body()
    index = place.robot.joints.index(place.joint)
    link = float(inertia_at(body, np.zeros(len(place.robot.joints)))[index] - body.armature[index])
    softest = place.coulomb / (link * (2.0 * np.pi * SLOWEST_SWING) ** 2)

    def change(robot: Robot, a: float) -> Robot:
        own = robot.joint(place.joint).transmission
        return _updated(robot, place.joint, transmission=own.model_copy(update={"compliance": a / place.coulomb}))

    return _on_joint("drive.elasticity", place, change, min(1e-3, 0.5 * softest), softest)


def rotor_inertia(rng: np.random.Generator, place: Place) -> Effect:
    """A rotor that is heavier or lighter than stated."""
    way = 1.0 if rng.random() < 0.6 else -0.6

    def change(robot: Robot, a: float) -> Robot:
        drive = robot.joint(place.joint).actuator
        inertia = drive.rotor_inertia * max(0.05, 1.0 + way * a)
        return _updated(robot, place.joint, actuator=drive.model_copy(update={"rotor_inertia": inertia}))

    return _on_joint("drive.rotor_inertia", place, change, 0.4, 4.0)


def coupling(rng: np.random.Generator, place: Place) -> Effect:
    """What a neighbour's motion or effort brings, or a drive shared with it."""
    names = place.robot.joints
    i = names.index(place.joint)
    other = names[i + 1] if i + 1 < len(names) else names[i - 1]
    kind = rng.choice(["friction", "effort", "drive"])
    if kind == "drive" and i + 1 < len(names):
        ratio = _sign(rng)

        def shared(robot: Robot, a: float) -> Robot:
            own = CommonDrive(joint=place.joint, ratio=ratio, coulomb=a * place.coulomb, viscous=a * place.viscous)
            return _updated(robot, other, common_drive=(own,))

        return _on_joint("drive.coupling", place, shared, 0.3, 2.0)
    way = _sign(rng)

    def change(robot: Robot, a: float) -> Robot:
        if kind == "effort":
            own = Coupling(joint=other, effort=0.2 * way * a)
        else:
            own = Coupling(joint=other, coulomb=way * a * place.coulomb, viscous=way * a * place.viscous)
        return _updated(robot, place.joint, coupling=(own,))

    return _on_joint("drive.coupling", place, change, 0.3, 3.0)


def payload(rng: np.random.Generator, place: Place) -> Effect:
    """A mass at the flange."""
    com = tuple(float(x) for x in rng.uniform([-0.06, -0.06, 0.0], [0.06, 0.06, 0.12]))
    parent = tip_link(place.robot.body())

    def change(robot: Robot, a: float) -> Robot:
        held = Payload(mass=a, com=com, parent=parent)
        return Robot(robot.table.model_copy(update={"payload": held}), robot.folder)

    return Effect("body.payload", None, change, 0.5, 8.0, {})


def link_inertia(rng: np.random.Generator, place: Place) -> Effect:
    """A link that is heavier or lighter than stated."""
    way = 1.0 if rng.random() < 0.6 else -0.7

    def change(robot: Robot, a: float) -> Robot:
        scale = {place.joint: max(0.2, 1.0 + way * a)}
        return Robot(robot.table.model_copy(update={"link_scale": scale}), robot.folder)

    return Effect("body.link_inertia", None, change, 0.3, 1.5, {})


def gravity_direction(rng: np.random.Generator, place: Place) -> Effect:
    """A tilted base."""
    turn = rng.uniform(0.0, 2.0 * np.pi)
    stated = place.robot.body().gravity
    size = float(np.linalg.norm(stated))

    def change(robot: Robot, a: float) -> Robot:
        gravity = (size * np.sin(a) * np.cos(turn), size * np.sin(a) * np.sin(turn), -size * np.cos(a))
        return Robot(robot.table.model_copy(update={"gravity": tuple(map(float, gravity))}), robot.folder)

    return Effect("body.gravity_direction", None, change, 0.04, 0.4, {})


def spring(rng: np.random.Generator, place: Place) -> Effect:
    """A balancer, hose or cable."""
    rest = place.centre + place.stroke * rng.uniform(-0.4, 0.4)

    def change(robot: Robot, a: float) -> Robot:
        stiffness = a * place.coulomb / place.stroke
        return _updated(robot, place.joint, spring=Spring(stiffness=stiffness, preload=-stiffness * rest))

    return _on_joint("body.spring", place, change, 0.5, 10.0)


def delay(rng: np.random.Generator, place: Place) -> Effect:
    """An effort that comes late, on one joint or all."""
    everywhere = rng.random() < 0.5
    names = place.robot.joints if everywhere else (place.joint,)

    def change(robot: Robot, a: float) -> Robot:
        for name in names:
            sensor = robot.joint(name).effort_sensor
            robot = _updated(robot, name, effort_sensor=sensor.model_copy(update={"delay": a}))
        return robot

    return Effect("sensor.delay", None if everywhere else place.joint, change, 0.01, 0.06, {})


def encoder_offset(rng: np.random.Generator, place: Place) -> Effect:
    """A joint whose zero is off."""
    way = _sign(rng)

    def change(robot: Robot, a: float) -> Robot:
        sensor = robot.joint(place.joint).position_sensor
        return _updated(robot, place.joint, position_sensor=sensor.model_copy(update={"offset": way * a}))

    return _on_joint("sensor.encoder_offset", place, change, 0.03, 0.3)


def step(rng: np.random.Generator, place: Place) -> Effect:
    """Friction that steps at one moment."""
    moment = float(place.time[0] + np.ptp(place.time) * rng.uniform(0.2, 0.8))
    levels = np.array([place.coulomb, place.viscous]) * rng.uniform(0.4, 1.0, 2)

    def change(robot: Robot, a: float) -> Robot:
        event = Event(time=moment, coulomb=a * levels[0], viscous=a * levels[1])
        return _updated(robot, place.joint, events=(event,))

    return _on_joint("event.change", place, change, 0.3, 2.0)


def pressure(rng: np.random.Generator, place: Place) -> Effect:
    """Seals that the chambers press on."""
    slow = 2.0 * np.pi * rng.uniform(0.05, 0.3, (2, 3))
    phase = rng.uniform(0.0, 2.0 * np.pi, (2, 3))
    courses = 4e6 + 8e5 * np.sin(place.time[:, None, None] * slow + phase).sum(axis=2)
    shares = rng.uniform(0.2, 1.0, 2)

    def change(robot: Robot, a: float) -> Robot:
        head, rod = a * place.coulomb * shares / 4e6
        return _updated(robot, place.joint, pressure_friction=PressureFriction(head=float(head), rod=float(rod)))

    ambient = {f"pressure_{side}.{place.joint}": courses[:, i] for i, side in enumerate(("head", "rod"))}
    return _on_joint("hydraulic.pressure", place, change, 0.5, 4.0, ambient)


EFFECTS: tuple[Draw, ...] = (
    coulomb_viscous,
    stribeck,
    viscous_nonlinear,
    asymmetry,
    load,
    presliding,
    position,
    temperature,
    cogging,
    torque_constant,
    offset,
    backlash,
    elasticity,
    rotor_inertia,
    coupling,
    payload,
    link_inertia,
    gravity_direction,
    spring,
    delay,
    encoder_offset,
    step,
    pressure,
)
