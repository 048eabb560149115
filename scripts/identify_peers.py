"""Identification compared with two peers, MuJoCo's sysid toolbox on EMPS and BAM on the XL330: docs/identification.md.

MJFRICTION_DATA=folder-of-the-measured-logs python -m scripts.identify_peers

Both fits of a pair run here, one after the other in one process, except BAM's.  BAM searches by simulation with a
default number of trials, and the time of one trial was measured by its users.
"""

from __future__ import annotations

import os
import tempfile
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pyarrow as pa

from mjfriction.identify.identification import identify_log
from mjfriction.identify.measure import measure_gap
from mjfriction.identify.protocol import plan_passes
from mjfriction.plant.machine import simulate
from mjfriction.plant.sensors import Recorder
from mjfriction.record.merge import merge_logs
from mjfriction.record.readers import read_log
from mjfriction.record.readers.table import log_from_table
from mjfriction.robot.files import read_robot
from mjfriction.robot.robot import Robot
from scripts.marked import write_marked
from scripts.real_runs.emps import open_loop_error
from scripts.real_runs.xl330 import PUBLISHED, xl330, xl330_error, xl330_log
from scripts.sysid_baseline import fit, fitted_robot

ROUNDS = 3  # runs of every fit, of which the fastest counts
EMPS_KINDS = ("damping", "frictionloss", "mass", "zero")
TRIALS, TRIAL = 100_000, 0.033  # BAM's default, and the shortest time measured for one trial (s)
EMPS_TIMES, BAM_TIMES, PROTOCOL_SECONDS = 10.0, 100.0, 10.0  # required speed-ups over the peers, and largest s
SPEEDS, PROTOCOL_RATE = 12, 125.0  # number of speeds of every joint's passes, and Hz of their log


@dataclass(frozen=True)
class Fit:
    """One tool's fit: its seconds, and its errors on runs that were not fitted."""

    tool: str
    seconds: float
    position: float
    force: float = np.nan


def emps(data: Path) -> list[Fit]:
    """Fit four parameters (mass, damping, dry friction, zero) to one run of the axis and evaluate them on the other.

    The errors are RMS position (m) in open loop, and force while the axis moves, relative to the measured force.
    """
    stated = read_robot(data / "emps/robot.toml")
    log, other = (read_log(data / f"emps/{run}.parquet") for run in ("estimation", "pulses"))

    def toolbox(seconds: float) -> Callable[[], Robot]:
        def fitted() -> Robot:
            gap = measure_gap(log, stated)
            found = fit(gap, seconds=seconds, longest_step=1.0 / gap.motion.rate, kinds=EMPS_KINDS)
            return fitted_robot(gap.robot, found)

        return fitted

    ways = {
        "mjfriction": lambda: identify_log(log, stated, law="coulomb_viscous").robot,
        "mujoco.sysid, the whole run": toolbox(np.inf),
        "mujoco.sysid, stretches of 0.5 s": toolbox(0.5),
    }
    out = []
    for name, way in ways.items():
        seconds, robot = _quickest(way)
        gap = measure_gap(other, robot)
        force = gap.rms(gap.residual[:, 0], 0) / gap.rms(gap.measured[:, 0], 0)
        out.append(Fit(name, seconds, open_loop_error(robot, other), force))
    return out


def bam(data: Path) -> list[Fit]:
    """Fit friction that grows with the load to the XL330's runs at a gain of 400, and simulate those at 100.

    The pendulum's mass properties are held as its authors measured them, as in BAM.
    """
    with tempfile.TemporaryDirectory() as folder:
        stated = xl330(Path(folder))
        log = merge_logs([xl330_log(path) for path in sorted((data / "xl330").glob("*kp400.json"))])
        runs = sorted((data / "xl330").glob("*kp100.json"))
        seconds, robot = _quickest(lambda: identify_log(log, stated, law="load_dependent", links=False).robot)
        return [
            Fit("mjfriction", seconds, float(np.mean([xl330_error(robot, run) for run in runs]))),
            Fit("BAM, its default number of trials", TRIALS * TRIAL, PUBLISHED),
        ]


@dataclass(frozen=True)
class Protocol:
    """Passes of all joints of an arm.

    ``length`` of the log is in s, ``by`` has the seconds of its identification by law, and ``missed`` is the largest
    relative error of the Coulomb levels of the Coulomb-viscous law.
    """

    length: float
    by: dict[str, float]
    missed: float


def protocol() -> Protocol:
    """Identify a simulated UR5 from passes forward and backward of all its joints."""
    robot = read_robot("ur5")
    trajectory = plan_passes(robot, robot.joints, count=SPEEDS).trajectory
    columns = simulate(robot, trajectory, recorder=Recorder(PROTOCOL_RATE), seed=1)
    log = log_from_table(pa.table(columns), "passes")
    by, robots = {}, {}
    for name, law in (("coulomb_viscous", "coulomb_viscous"), ("arctan", "arctan"), ("the law each needs", None)):
        by[name], robots[name] = _quickest(lambda law=law: identify_log(log, robot, law=law).robot)
    found = robots["coulomb_viscous"]
    levels = [
        (own.friction[0].value("coulomb"), stated.friction[0].value("coulomb"))
        for own, stated in zip(found.table.joint, robot.table.joint, strict=True)
        if own.friction and stated.friction
    ]
    return Protocol(float(log.time[-1]), by, max(abs(own / stated - 1.0) for own, stated in levels))


def _quickest(way: Callable[[], Robot]) -> tuple[float, Robot]:
    spent = []
    for _ in range(ROUNDS):
        begin = time.perf_counter()
        robot = way()
        spent.append(time.perf_counter() - begin)
    return min(spent), robot


def words(axis: list[Fit], servo: list[Fit], passes: Protocol) -> str:
    """Return the results as a section of a page."""
    lines = ["| tool | fit | position error | force error |", "|---|---:|---:|---:|"]
    lines += [
        f"| {one.tool} | {one.seconds / axis[0].seconds:.3g} times | {1e3 * one.position:.2f} mm | "
        f"{100 * one.force:.1f} % |"
        for one in axis
    ]
    seconds = [axis[0].seconds, servo[0].seconds]
    return f"""EMPS, a measured linear axis: mass, damping, dry friction and zero fitted to one run; position in open
loop and force on the other. Fitting times are multiples of mjfriction's {seconds[0]:.2f} s.

{chr(10).join(lines)}

An XL330 servo with a pendulum: friction that grows with the load, fitted in {seconds[1]:.2f} s to the runs at a
position gain of 400, simulates those at 100 with a mean error of {servo[0].position:.3f} rad. BAM's published model
is {PUBLISHED} rad off over all runs; its default search of {TRIALS} trials, at the {1e3 * TRIAL:.0f} ms or more
that one takes, would last {servo[1].seconds / seconds[1]:.0f} times as long.

Passes of all six joints of a UR5 at {SPEEDS} speeds, {passes.length / 60:.0f} min of log at {PROTOCOL_RATE:.0f} Hz:
identified in {passes.by["coulomb_viscous"]:.1f} s as `coulomb_viscous`, the levels within {100 * passes.missed:.2g} %;
in {passes.by["arctan"]:.1f} s as `arctan`, and in {passes.by["the law each needs"]:.1f} s with each joint the law it
needs."""


def fallen_short(axis: list[Fit], servo: list[Fit], passes: Protocol) -> list[str]:
    """Return the requirements on speed and error that the fits do not meet."""
    own, toolbox = axis[0], axis[1:]
    short = []
    if min(other.seconds for other in toolbox) < EMPS_TIMES * own.seconds:
        short.append(f"EMPS: not {EMPS_TIMES:.0f} times as fast as mujoco.sysid")
    if own.position > min(other.position for other in toolbox) and own.force > min(other.force for other in toolbox):
        short.append("EMPS: a test error above that of mujoco.sysid")
    if servo[1].seconds < BAM_TIMES * servo[0].seconds or servo[0].position > PUBLISHED:
        short.append(f"XL330: not {BAM_TIMES:.0f} times as fast as BAM, or an error above its published")
    if max(passes.by["coulomb_viscous"], passes.by["arctan"]) > PROTOCOL_SECONDS:
        short.append(f"six-axis passes: not within {PROTOCOL_SECONDS:.0f} s")
    return short


def main() -> None:
    data = Path(os.environ["MJFRICTION_DATA"])
    came = emps(data), bam(data), protocol()
    told = words(*came)
    write_marked(Path(__file__).resolve().parent.parent / "docs/identification.md", "peers", told)
    print(told)
    short = fallen_short(*came)
    if short:
        raise SystemExit("; ".join(short))


if __name__ == "__main__":
    main()
