"""A robot of your own, from its URDF alone: a robot file, a machine that differs, a log, and the difference named.

Run: python -m scripts.own_robot FOLDER [--seconds 60]
"""

from __future__ import annotations

import argparse
from pathlib import Path

import pyarrow as pa
import pyarrow.parquet

import mjfriction as mjf
from mjfriction.identify.protocol import plan_excitation
from mjfriction.plant.sensors import Recorder
from mjfriction.robot.draft import draft_robot
from mjfriction.robot.friction import with_term

URDF = "package://example-robot-data/z1_description/urdf/z1.urdf"
JOINTS = tuple(f"joint{k}" for k in range(1, 7))
SENSOR_NOISE = 0.05  # N·m


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--seconds", type=float, default=60.0)
    asked = parser.parse_args()
    asked.folder.mkdir(parents=True, exist_ok=True)

    # What `mjfriction new` does; on a real arm this is the moment to write down gears and motors.
    path = asked.folder / "z1.toml"
    path.write_text(draft_robot(URDF, asked.folder, JOINTS), encoding="utf-8")
    robot = mjf.read_robot(path)

    # A machine that differs from its robot file: its third joint's friction grows with the load that it carries.
    rubbing = {"coulomb": 0.0, "viscous": 0.0, "load": 0.1}
    machine = with_term(robot.with_stated_friction(robot.body()), "joint3", "load_dependent", rubbing)
    for joint in machine.table.joint:
        sensor = joint.effort_sensor.model_copy(update={"noise": SENSOR_NOISE})
        machine = machine.with_joint(joint.model_copy(update={"effort_sensor": sensor}))

    # With a real arm, run the motion on it and record its log instead.
    motion = plan_excitation(robot, asked.seconds, seed=1).trajectory
    columns = mjf.simulate(machine, motion, recorder=Recorder(500.0), controller_robot=robot, seed=2)
    pyarrow.parquet.write_table(pa.table(columns), asked.folder / "run.parquet")

    diagnosis = mjf.diagnose_log(mjf.read_log(asked.folder / "run.parquet"), robot)
    mjf.save_diagnosis(diagnosis, asked.folder / "result")
    print(diagnosis.summary)
    for finding in diagnosis.findings:
        for value in finding.parameters:
            unit = "" if value.unit == "1" else f" {value.unit}"
            print(f"  {value.name} = {value.value:.3g}{unit} (95 %: {value.low:.3g} to {value.high:.3g})")
    print(f"open {asked.folder / 'result' / 'report.html'}")


if __name__ == "__main__":
    main()
