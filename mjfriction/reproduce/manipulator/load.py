"""Extension (30) to (32): what a payload's torque adds to friction, from passes with and without it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mjfriction.body.inverse import inverse_dynamics
from mjfriction.identify.friction_map import FrictionMap
from mjfriction.identify.map_fit import on_side
from mjfriction.identify.phases import constant_speed_phases
from mjfriction.laws.law import Floats
from mjfriction.record.motion import estimate_motion
from mjfriction.reproduce.manipulator.arm import (
    PER_LOAD,
    JointFit,
    maps_of,
    record_passes,
    stated_arm,
    with_payload,
)
from mjfriction.robot.bandwidth import choose_cutoff

PAYLOAD = {"comau_ns12": 12.0, "comau_nj60": 60.0}  # kg, what the arms are made for
JOINTS = (1, 2)  # that gravity loads in every pose
SPEEDS = 8
FASTEST_TOLD = 50.0  # rad/s of the motor: past it the bend of the viscous term carries the load too
SAME_SPEED = 0.1  # relative


@dataclass(frozen=True)
class LoadExtension:
    """One joint, on the motor's side: the mean ``load`` without and with the payload, N·m, and what each newton metre
    of it adds to τ_s and τ_sc, found and true.
    """

    joint: int
    load: tuple[float, float]
    static: tuple[float, float]
    fall: tuple[float, float]


def load_extension(name: str, fits: list[JointFit], seed: int) -> list[LoadExtension]:
    """Return what the payload adds at the joints that carry it.

    At every speed the difference of both maps over that of the loads is τ_s,m + τ_sc,m·atan(δv), linear in both.
    """
    light, heavy = (_passes(name, mass, seed + k) for k, mass in enumerate((0.0, PAYLOAD[name])))
    truth, out = stated_arm(name), []
    for joint in JOINTS:
        ratio = fits[joint].ratio
        speed, friction, _ = on_side(light[0][joint], "motor", ratio)
        other, loaded, _ = on_side(heavy[0][joint], "motor", ratio)
        slow = speed < FASTEST_TOLD
        loads = light[1][joint] / ratio, np.interp(speed, other, heavy[1][joint] / ratio)
        more = (np.interp(speed, other, loaded) - friction) / (loads[1] - loads[0])
        fall = np.arctan(fits[joint].static.values["stribeck_steepness"] * speed)
        columns = np.column_stack([np.ones(speed.size), fall])[slow]
        (static, falling), *_ = np.linalg.lstsq(columns, more[slow], rcond=None)
        (law,) = truth.table.joint[joint].friction or ()
        true = PER_LOAD * law.value("static"), PER_LOAD * law.value("stribeck_fall")
        mean = float(np.mean(loads[0][slow])), float(np.mean(loads[1][slow]))
        out.append(LoadExtension(joint, mean, (float(static), true[0]), (float(falling), true[1])))
    return out


def _passes(name: str, mass: float, seed: int) -> tuple[dict[int, FrictionMap], dict[int, Floats]]:
    # The maps, and the mean load at each of their speeds: slow passes go over a part of the stroke.
    robot = with_payload(stated_arm(name), mass)
    log = record_passes(name, SPEEDS, [robot.joints[joint] for joint in JOINTS], seed, mass)
    body = robot.body()
    motion = estimate_motion(log, robot.joints, choose_cutoff(log, robot, body))
    carried = np.abs(inverse_dynamics(body, motion.position, motion.velocity, 0.0 * motion.acceleration))
    maps, phases = maps_of(log, robot), constant_speed_phases(motion)
    loads = {}
    for joint in JOINTS:
        own = [phase for phase in phases if phase.joint == joint]
        speed = np.array([abs(phase.velocity) for phase in own])
        load = np.array([np.mean(carried[phase.first : phase.past, joint]) for phase in own])
        near = np.abs(np.log(speed[None, :] / maps[joint].speed[:, None])) < SAME_SPEED
        loads[joint] = np.asarray((near @ load) / np.sum(near, axis=1))
    return maps, loads
