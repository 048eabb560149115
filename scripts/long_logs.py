"""Measure what a diagnosis costs as logs grow to an hour, and write docs/long_logs.md; some twenty minutes.

Run: python -m scripts.long_logs
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from mjfriction.plant.machine import simulate
from mjfriction.plant.motions import excitation
from mjfriction.plant.sensors import Recorder
from mjfriction.robot.files import read_robot
from mjfriction.robot.robot import Robot

PAGE = Path(__file__).resolve().parent.parent / "docs/long_logs.md"
MINUTES = (70.0 / 60.0, 10.0, 60.0)
RATE = 500.0
HOME = np.array([0.0, -1.2, 1.0, 0.0, 0.6, 0.0])
NOISE = 0.3  # N·m
LOADED = 0.015  # share of the Coulomb level that each newton metre of load adds
DIAGNOSE = "from mjfriction.cli.main import run; run()"

TEXT = """# Long logs

Written by `python -m scripts.long_logs` on one machine of {cores} cores, of which a diagnosis uses one. A UR5, sums of
sines on all six axes, 500 Hz, with friction that grows with the load of its elbow. Time and memory are those of
`mjfriction diagnose`, its start, the report page and the recording included.

{table}

Beyond what the program itself takes, both grow with the log: {per_minute:.0f} MB and {seconds_per_minute:.1f} s a
minute. Only the load's part of the friction was hidden: what else is named is a false alarm.
"""


@dataclass(frozen=True)
class Cost:
    """The cost of diagnosing a log of some minutes: seconds, peak memory in MB, and what it found, in words."""

    minutes: float
    seconds: float
    megabytes: float
    found: str


def write_log(robot: Robot, minutes: float, folder: Path) -> Path:
    """Simulate a machine with something hidden in it, and write its log."""
    elbow = robot.joint("elbow_joint")
    (term,) = elbow.friction or ()
    loaded = term.model_copy(update={"level": term.level.model_copy(update={"per_load": LOADED})})
    machine = robot.with_joint(elbow.model_copy(update={"friction": (loaded,)}))
    for joint in machine.table.joint:
        sensor = joint.effort_sensor.model_copy(update={"noise": NOISE})
        machine = machine.with_joint(joint.model_copy(update={"effort_sensor": sensor}))
    motion = excitation(robot.joints, HOME, np.full(6, 0.6), np.full(6, 1.0), 60.0 * minutes)
    log = simulate(machine, motion, recorder=Recorder(RATE), seed=1)
    path = folder / "log.parquet"
    pq.write_table(pa.table(log), path)
    return path


def diagnosed(minutes: float) -> Cost:
    """Return the cost of one diagnosis in a process of its own."""
    with tempfile.TemporaryDirectory() as folder:
        log, out = write_log(read_robot("ur5"), minutes, Path(folder)), Path(folder) / "out"
        command = [sys.executable, "-c", DIAGNOSE, "diagnose", str(log), "--robot", "ur5", "--out", str(out)]
        begun = time.perf_counter()
        child = subprocess.Popen(command, stdout=subprocess.PIPE, text=True, env={**os.environ, "OMP_NUM_THREADS": "1"})
        assert child.stdout is not None
        said = child.stdout.read()
        _, status, usage = os.wait4(child.pid, 0)
        if status:
            raise SystemExit(f"the diagnosis of {minutes:.3g} minutes ended with {status}: {said}")
        report = json.loads((out / "report.json").read_text(encoding="utf-8"))
        found = ", ".join(f"`{one['cause']}` at {one['joint']}" for one in report["findings"]) or "nothing"
        return Cost(minutes, time.perf_counter() - begun, usage.ru_maxrss * 1024 / 1e6, found)


def page(costs: list[Cost]) -> str:
    """Return the page."""
    lines = ["| log | samples | time, s | memory, MB | found |", "|---|---:|---:|---:|---|"]
    for cost in costs:
        length = f"{60.0 * cost.minutes:.0f} s" if cost.minutes < 2.0 else f"{cost.minutes:.0f} min"
        samples = 60.0 * cost.minutes * RATE
        lines.append(f"| {length} | {samples:,.0f} | {cost.seconds:.0f} | {cost.megabytes:.0f} | {cost.found} |")
    first, last = costs[0], costs[-1]
    span = last.minutes - first.minutes
    return TEXT.format(
        cores=os.cpu_count(),
        table="\n".join(lines),
        per_minute=(last.megabytes - first.megabytes) / span,
        seconds_per_minute=(last.seconds - first.seconds) / span,
    )


if __name__ == "__main__":
    text = page([diagnosed(minutes) for minutes in MINUTES])
    PAGE.write_text(text, encoding="utf-8")
    print(text)
