"""From a report to a controller: the friction of the extended robot fed forward, on the machine that the log came from.

A UR5 whose elbow sticks harder than its robot file says is recorded, diagnosed, and then made to follow another
motion: with the friction as stated, and with that of the extended robot.  The script prints each joint's deviation.

Run: python -m scripts.report_to_controller [--seconds 60]
"""

from __future__ import annotations

import argparse

import numpy as np
import pyarrow as pa

import mjfriction as mjf
from mjfriction.control.servo import Control
from mjfriction.identify.protocol import plan_excitation
from mjfriction.plant.machine import run_machine
from mjfriction.plant.sensors import Recorder
from mjfriction.record.readers.table import log_from_table
from mjfriction.robot.friction_tables import FrictionTerm
from mjfriction.robot.robot import Robot

STICKS = {"coulomb": 10.0, "static": 16.0, "stribeck_velocity": 0.15, "stribeck_exponent": 2.0, "viscous": 12.0}
SENSOR_NOISE = 0.1  # N·m
CONTROL = Control(bandwidth=4.0, friction="law")


def machine_of(stated: Robot) -> Robot:
    """Return the machine: the stated robot with a Stribeck elbow and noise on its efforts."""
    elbow = stated.joint("elbow_joint").model_copy(
        update={"friction": (FrictionTerm(law="stribeck", parameters=STICKS),)}
    )
    machine = stated.with_joint(elbow)
    for joint in machine.table.joint:
        sensor = joint.effort_sensor.model_copy(update={"noise": SENSOR_NOISE})
        machine = machine.with_joint(joint.model_copy(update={"effort_sensor": sensor}))
    return machine


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seconds", type=float, default=60.0)
    asked = parser.parse_args()
    stated = mjf.read_robot("ur5")
    machine = machine_of(stated)
    recorded = plan_excitation(stated, asked.seconds, seed=1).trajectory
    columns = mjf.simulate(machine, recorded, recorder=Recorder(500.0), controller_robot=stated, seed=3)
    diagnosis = mjf.diagnose_log(log_from_table(pa.table(columns), "the log"), stated)
    print(diagnosis.summary)

    other = plan_excitation(stated, 20.0, seed=2).trajectory
    print(f"{'strays, mrad (RMS)':28s}{'as stated':>12s}{'as extended':>14s}")
    strays = []
    for model in (stated, diagnosis.robot):
        run = run_machine(machine, other, 1000.0, CONTROL, model)
        strays.append(1e3 * np.sqrt(np.mean(np.square(run.wanted - run.played.position), axis=0)))
    for name, before, after in zip(stated.joints, *strays, strict=True):
        print(f"  {name:26s}{before:12.3f}{after:14.3f}")


if __name__ == "__main__":
    main()
