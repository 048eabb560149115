"""Drives, transmissions and sensors that differ from what is stated."""

from __future__ import annotations

import numpy as np

from mjfriction.benchmark.effects.effect import Effect, Place, on_joint, sign, updated, wave_along
from mjfriction.body.inverse import inertia_at
from mjfriction.robot.common_drives import with_drive_turned_too
from mjfriction.robot.friction import stated_levels
from mjfriction.robot.robot import Robot
from mjfriction.robot.schema import CommonDrive, Coupling

SLOWEST_SWING = 10.0  # Hz; lowest resonance of a link on its compliant transmission


def cogging(rng: np.random.Generator, place: Place) -> Effect:
    """A torque that repeats along the stroke."""
    wave = wave_along(rng, place, 12.0)

    def change(robot: Robot, a: float) -> Robot:
        return updated(robot, place.joint, cogging=(*robot.joint(place.joint).cogging, wave(a)))

    return on_joint("drive.cogging", place, change, 0.3, 2.0)


def torque_constant(rng: np.random.Generator, place: Place) -> Effect:
    """An effort reading that is off by a factor."""
    way = sign(rng)

    def change(robot: Robot, a: float) -> Robot:
        sensor = robot.joint(place.joint).effort_sensor
        return updated(robot, place.joint, effort_sensor=sensor.model_copy(update={"scale": 1.0 + way * a}))

    return on_joint("drive.torque_constant", place, change, 0.1, 0.4, of_stated=1.0)


def offset(rng: np.random.Generator, place: Place) -> Effect:
    """A constant offset in the effort reading."""
    way = sign(rng) * place.coulomb

    def change(robot: Robot, a: float) -> Robot:
        sensor = robot.joint(place.joint).effort_sensor
        return updated(robot, place.joint, effort_sensor=sensor.model_copy(update={"offset": way * a}))

    return on_joint("drive.offset", place, change, 0.2, 2.0)


def backlash(rng: np.random.Generator, place: Place) -> Effect:
    """Play in the transmission."""
    del rng

    def change(robot: Robot, a: float) -> Robot:
        own = robot.joint(place.joint).transmission
        return updated(robot, place.joint, transmission=own.model_copy(update={"backlash": a}))

    return on_joint("drive.backlash", place, change, 0.01, 0.06)


def elasticity(rng: np.random.Generator, place: Place) -> Effect:
    """A compliant transmission, stiff enough that the link does not resonate on it in the motion's own band."""
    del rng
    body = place.robot.body()
    index = place.robot.joints.index(place.joint)
    link = float(inertia_at(body, np.zeros(len(place.robot.joints)))[index] - body.armature[index])
    softest = place.coulomb / (link * (2.0 * np.pi * SLOWEST_SWING) ** 2)

    def change(robot: Robot, a: float) -> Robot:
        own = robot.joint(place.joint).transmission
        return updated(robot, place.joint, transmission=own.model_copy(update={"compliance": a / place.coulomb}))

    return on_joint("drive.elasticity", place, change, min(1e-3, 0.5 * softest), softest)


def rotor_inertia(rng: np.random.Generator, place: Place) -> Effect:
    """A rotor that is heavier or lighter than stated."""
    way = 1.0 if rng.random() < 0.6 else -0.6

    def change(robot: Robot, a: float) -> Robot:
        drive = robot.joint(place.joint).actuator
        inertia = drive.rotor_inertia * max(0.05, 1.0 + way * a)
        return updated(robot, place.joint, actuator=drive.model_copy(update={"rotor_inertia": inertia}))

    return on_joint("drive.rotor_inertia", place, change, 0.4, 4.0, of_stated=abs(way))


def coupling(rng: np.random.Generator, place: Place) -> Effect:
    """An effect of a neighbour's motion or effort, a shared drive, or a drive that turns with the neighbour too."""
    names = place.robot.joints
    i = names.index(place.joint)
    other = names[i + 1] if i + 1 < len(names) else names[i - 1]
    kind = rng.choice(["friction", "motion", "effort", "drive", "own drive"])
    if kind == "own drive":
        return turned_too(place, other, sign(rng))
    if kind == "drive" and i + 1 < len(names):
        ratio = sign(rng)

        def shared(robot: Robot, a: float) -> Robot:
            own = CommonDrive(joint=place.joint, ratio=ratio, coulomb=a * place.coulomb, viscous=a * place.viscous)
            return updated(robot, other, common_drive=(own,))

        return on_joint("drive.coupling", place, shared, 0.3, 2.0)
    way = sign(rng)

    def change(robot: Robot, a: float) -> Robot:
        if kind == "effort":
            own = Coupling(joint=other, effort=0.2 * way * a)
        elif kind == "motion":
            rotor = float(place.robot.body().armature[names.index(other)])
            own = Coupling(joint=other, viscous=way * a * place.viscous, inertia=way * a * rotor)
        else:
            own = Coupling(joint=other, coulomb=way * a * place.coulomb, viscous=way * a * place.viscous)
        return updated(robot, place.joint, coupling=(own,))

    return on_joint("drive.coupling", place, change, 0.3, 3.0)


def turned_too(place: Place, other: str, way: float) -> Effect:
    """A joint's drive that turns with a neighbour's motion too, with all of its friction and rotor inertia."""

    def change(robot: Robot, a: float) -> Robot:
        coulomb, viscous = stated_levels(robot.joint(place.joint))
        inertia = robot.joint(place.joint).actuator.reflected_inertia
        own = CommonDrive(joint=other, ratio=way * a, coulomb=coulomb, viscous=viscous, inertia=inertia)
        return with_drive_turned_too(robot, place.joint, own)

    return on_joint("drive.coupling", place, change, 0.1, 1.2)


def delay(rng: np.random.Generator, place: Place) -> Effect:
    """A delayed effort reading, on one joint or all."""
    everywhere = rng.random() < 0.5 and len(place.robot.joints) > 1
    names = place.robot.joints if everywhere else (place.joint,)

    def change(robot: Robot, a: float) -> Robot:
        for name in names:
            sensor = robot.joint(name).effort_sensor
            robot = updated(robot, name, effort_sensor=sensor.model_copy(update={"delay": a}))
        return robot

    return Effect("sensor.delay", None if everywhere else place.joint, change, 0.01, 0.06, {})


def encoder_offset(rng: np.random.Generator, place: Place) -> Effect:
    """A position reading whose zero is off."""
    way = sign(rng)

    def change(robot: Robot, a: float) -> Robot:
        sensor = robot.joint(place.joint).position_sensor
        return updated(robot, place.joint, position_sensor=sensor.model_copy(update={"offset": way * a}))

    return on_joint("sensor.encoder_offset", place, change, 0.03, 0.3)
