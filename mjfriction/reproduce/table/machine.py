"""The machine-tool table of the pre-sliding document: richer than every law under test, and its control."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from mjfriction.control.disturbance import disturbance_observer
from mjfriction.control.servo import Control
from mjfriction.laws.law import Floats
from mjfriction.robot.files import read_robot
from mjfriction.robot.friction_tables import FrictionTerm, LevelTable
from mjfriction.robot.robot import Robot
from mjfriction.robot.table import Wave

JOINT = "axis"
PITCH = 0.05  # m of the screw
TRAVELS = (23e-6, 120e-6)  # m: half of the contacts yield as 1 − exp(−x/23 µm), half as 1 − exp(−x/120 µm)
ELEMENTS = 61
PLACE_WAVE = Wave(wavenumber=2.0 * np.pi / 0.0123, cosine=0.02, sine=0.03)  # shares of the level, along the stroke
RESIDUE = Wave(wavenumber=2.0 * np.pi / PITCH * 13.5, cosine=0.15, sine=0.1)  # N, at no harmonic of the screw
RATE = 1000.0  # Hz of the controller
VELOCITY_BANDWIDTH = 200.0  # Hz; bandwidth of its velocity estimate from the interferometer's readings

AMPLITUDE, PERIOD = 100e-6, 10.0  # m, s of the reference with two inner loops
FASTER = 10.0

WEAK, OBSERVER = 20.0, 2.5  # Hz of the weak PD and of the disturbance observer behind it
STIFF, STIFF_OBSERVER = 60.0, 10.0  # Hz, for the experiments of identification


def true_table() -> Robot:
    """Return the machine: a distribution of 61 elements, a level that varies along the stroke, an unmodelled wave."""
    stated = read_robot("machine_table")
    joint = stated.joint(JOINT)
    (gms,) = joint.friction or ()
    travel, share = _distribution()
    stiffness = gms.value("static") * share / travel
    parameters = {**gms.parameters, "share": tuple(share.tolist()), "stiffness": tuple(stiffness.tolist())}
    changes = {
        "friction": (FrictionTerm(law="gms", parameters=parameters, level=LevelTable(waves=(PLACE_WAVE,))),),
        "cogging": (*joint.cogging, RESIDUE),
        "position_sensor": joint.position_sensor.model_copy(update={"velocity_bandwidth": VELOCITY_BANDWIDTH}),
    }
    return stated.with_joint(joint.model_copy(update=changes))


def blank_table() -> Robot:
    """Return what is known of the machine before any experiment: mass and drive, no friction or cogging."""
    stated = read_robot("machine_table")
    return stated.with_joint(stated.joint(JOINT).model_copy(update={"friction": (), "cogging": ()}))


def weak_control(*, friction: bool, observer: bool) -> Control:
    """Return the weak PD of the comparison, optionally with friction fed forward by a law and with an observer."""
    control = Control(
        bandwidth=WEAK,
        feedforward="dynamics",
        friction="law" if friction else "none",
        cancels_cogging=True,
        sensed=True,
    )
    return replace(control, observer=disturbance_observer(OBSERVER)) if observer else control


def stiff_control() -> Control:
    """Return the stiff control under which the table is identified."""
    return Control(bandwidth=STIFF, friction="none", observer=disturbance_observer(STIFF_OBSERVER), sensed=True)


def _distribution() -> tuple[Floats, Floats]:
    # Elements trace a virgin curve F(x) = 1 − exp(−x/λ) where their shares of the level are distributed over breakaway
    # travels u with density u/λ²·exp(−u/λ).  Together the two kinds are as stiff at rest as the document says,
    # 1.4 N/µm.
    travel = np.geomspace(0.05 * TRAVELS[0], 12.0 * TRAVELS[1], ELEMENTS)
    edges = np.concatenate([[0.0], np.sqrt(travel[:-1] * travel[1:])])
    below = np.mean([1.0 - np.exp(-edges / own) * (1.0 + edges / own) for own in TRAVELS], axis=0)
    return travel, np.diff(np.append(below, 1.0))
