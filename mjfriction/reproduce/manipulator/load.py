"""Extension (30) to (32): what a payload's torque adds to friction, from passes with and without it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mjfriction.identify.map_fit import MapFit, fit_map
from mjfriction.laws.arctan_load import ARCTAN_LOAD
from mjfriction.record.merge import merge_logs
from mjfriction.reproduce.manipulator.arm import PER_LOAD, maps_of, record_passes, stated_arm

PAYLOAD = {"comau_ns12": 12.0, "comau_nj60": 60.0}  # kg; the rated payloads
JOINTS = (1, 2)  # the joints that gravity loads in every pose
SPEEDS = 8
FASTEST_TOLD = 50.0  # rad/s of the motor; above it the bend of the viscous term depends on the load too


@dataclass(frozen=True)
class LoadExtension:
    """The load dependence of one joint, on the motor's side.

    ``load`` is the mean load without and with the payload, N·m; ``found`` is the fitted law with levels (31) and (32).
    ``static`` and ``fall`` are what each newton metre of load truly adds to τ_s and τ_sc.
    """

    joint: int
    load: tuple[float, float]
    found: MapFit
    static: float
    fall: float


def load_extension(name: str, seed: int) -> list[LoadExtension]:
    """Return what the payload adds at the joints that carry it, from one map of passes without it and with it."""
    robot, out = stated_arm(name), []
    joints = [robot.joints[joint] for joint in JOINTS]
    masses = (0.0, PAYLOAD[name])
    log = merge_logs([record_passes(name, SPEEDS, joints, seed + k, mass) for k, mass in enumerate(masses)])
    maps = maps_of(log, robot)
    for joint in JOINTS:
        ratio = robot.table.joint[joint].actuator.gear_ratio
        points = maps[joint].up_to(FASTEST_TOLD / abs(ratio))
        (law,) = robot.table.joint[joint].friction or ()
        middle = 0.5 * (np.min(points.load) + np.max(points.load))
        light, heavy = (float(np.mean(points.load[own])) for own in (points.load < middle, points.load >= middle))
        out.append(
            LoadExtension(
                joint=joint,
                load=(light / abs(ratio), heavy / abs(ratio)),
                found=fit_map(points, ARCTAN_LOAD, "motor", ratio),
                static=PER_LOAD * law.value("static"),
                fall=PER_LOAD * law.value("stribeck_fall"),
            )
        )
    return out
