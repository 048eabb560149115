"""Friction compensated on a six-axis arm in MuJoCo: stated levels, the arm's law, an observer, and both.

Prints how far every joint strays from its course, writes the table into docs/compensation.md, and, with --recording,
the run of the last controller for Rerun.  Run: python -m scripts.compensation [--recording run.rrd]
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np

from mjfriction.control.disturbance import disturbance_observer
from mjfriction.control.servo import Control
from mjfriction.plant.machine import Run, run_machine
from mjfriction.plant.trajectory import Trajectory
from mjfriction.report.run_view import write_run
from mjfriction.robot.files import read_robot
from scripts.marked import write_marked

ROOT = Path(__file__).resolve().parent.parent
ARM, BANDWIDTH, OBSERVER = "comau_ns12", 20.0, 6.0  # Hz
CONTROLLERS = {
    "PD and dynamics alone": Control(bandwidth=BANDWIDTH, friction="none"),
    "stated Coulomb-viscous levels": Control(bandwidth=BANDWIDTH, friction="coulomb_viscous"),
    "the arm's law": Control(bandwidth=BANDWIDTH, friction="law"),
    "observer": Control(bandwidth=BANDWIDTH, friction="none", observer=disturbance_observer(OBSERVER)),
    "law and observer": Control(bandwidth=BANDWIDTH, friction="law", observer=disturbance_observer(OBSERVER)),
}


def course(joints: tuple[str, ...]) -> Trajectory:
    """Return slow sines of all joints, each at its own phase, that fade in and out."""
    time = np.arange(0.0, 8.0, 0.004)
    swell = np.clip(np.minimum(time, 8.0 - time), 0.0, 1.0) ** 2
    phases = 2.0 * np.pi * (0.25 * time[:, None] + np.arange(len(joints)) / len(joints))
    return Trajectory(joints, time, 0.1 * swell[:, None] * np.sin(phases))


def strays(run: Run) -> np.ndarray:
    """Return the RMS deviation of every joint from its course, mrad."""
    return 1e3 * np.sqrt(np.mean(np.square(run.wanted - run.played.position), axis=0))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--recording", type=Path)
    wanted = parser.parse_args()
    arm = read_robot(ARM)
    lines = [f"| controller of `{ARM}` | {' | '.join(arm.joints)} |", f"|---|{'---:|' * len(arm.joints)}"]
    for name, control in CONTROLLERS.items():
        run = run_machine(arm, course(arm.joints), 1000.0, control, arm, whole=True)
        lines.append(f"| {name} | {' | '.join(f'{value:.3g}' for value in strays(run))} |")
    if wanted.recording:
        write_run(arm, run, wanted.recording)
    table = "\n".join(lines)
    print(table)
    write_marked(ROOT / "docs/compensation.md", "table", table)


if __name__ == "__main__":
    main()
