"""Results of identification and diagnosis on six real machines, beside the published ones: docs/real_machines.md.

MJFRICTION_DATA=folder-of-the-measured-logs python -m scripts.real_machines
"""

from __future__ import annotations

import os
import tempfile
from collections.abc import Sequence
from pathlib import Path

import numpy as np

import mjfriction as mjf
from mjfriction.diagnose.tell.outcome import Diagnosis
from mjfriction.identify.identification import identify_log
from mjfriction.identify.map_choice import choose_on_map
from mjfriction.laws.catalog import find_law
from mjfriction.record.merge import merge_logs
from scripts.real_runs import emps, screw_drives, tx40, ur10, xl330

PAGE = Path(__file__).resolve().parent.parent / "docs/real_machines.md"
SWING = 1.0  # s; length of each simulation of the pendulum under its measured efforts


def table(heads: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """Return a table of a page."""
    lines = [heads, ["---", *["---:"] * (len(heads) - 1)], *rows]
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)


def told(diagnosis: Diagnosis) -> str:
    """Return the findings of a diagnosis, in words."""
    findings = [f"`{one.cause}`" + (f" at {one.joint}" if one.joint else "") for one in diagnosis.findings]
    return ", ".join(findings) or "nothing"


def emps_axis(data: Path) -> str:
    """Force and position of both runs, fitted to one."""
    stated = mjf.read_robot(data / "emps/robot.toml")
    logs = [mjf.read_log(data / f"emps/{run}.parquet") for run in emps.RUNS]
    rows = []
    for law, published in (("coulomb_viscous", (4.083, 5.982)), ("asymmetric", (3.112, 5.34))):
        robot = identify_log(logs[0], stated, law=law).robot
        refined = identify_log(logs[0], stated, law=law, simulated=np.inf).robot
        errors = [emps.force_error(log, robot) for log in logs]
        missed = [1e3 * emps.open_loop_error(own, logs[1]) for own in (robot, refined)]
        cells = [f"{own:.2f} ({paper:.4g})" for own, paper in zip(errors, published, strict=True)]
        rows.append([f"`{law}`", *cells, *(f"{own:.2f}" for own in missed)])
    heads = (
        "law",
        "force, fitted run, %",
        "force, pulses, %",
        "position, pulses, mm",
        "refined on simulated motion, mm",
    )
    alone, together = mjf.diagnose_log(logs[0], stated), mjf.diagnose_log(merge_logs(logs), stated)
    return f"""## EMPS, a linear axis

Fitted to one run (`estimation`); `pulses` is not fitted. In brackets what its authors published. Position is simulated
open loop under the measured force.

{table(heads, rows)}

Diagnosed from the first run: {told(alone)}. From both: {told(together)}."""


def screws(data: Path) -> str:
    """The error of each law at speeds that are left out."""
    rows = []
    for drive, (plain, with_stribeck) in screw_drives.PUBLISHED.items():
        points = screw_drives.map_of(data / f"screw_drives/drive{drive}_steady.parquet")
        tried = choose_on_map(points, [find_law(name) for name in screw_drives.LAWS], "joint", 1.0)
        size = float(np.sqrt(np.mean(np.square(points.friction))))
        missed = {one.law.name: 100.0 * float(np.sqrt(np.mean(np.square(one.missed)))) / size for one in tried}
        rows.append(
            [
                str(drive),
                f"{missed['coulomb_viscous']:.2f} ({plain})",
                f"{missed['stribeck']:.2f} ({with_stribeck})" if missed["stribeck"] < 100.0 else "not told",
                f"`{tried[0].law.name}`",
            ]
        )
    heads = ("drive", "Coulomb-viscous, %", "Stribeck, %", "chosen")
    return f"""## Three screw drives

Steady speeds, one left out at a time; in brackets what was published, with one run left out at a time. Not told is a
curve that one speed alone decides.

{table(heads, rows)}"""


def servo(data: Path, folder: Path) -> str:
    """Position errors at gains that were not fitted."""
    stated, rows = xl330.xl330(folder), []
    for fitted, simulated, seconds in (("400", "100", None), ("100", "400", 1.5)):
        logs = [xl330.xl330_log(path) for path in sorted((data / "xl330").glob(f"*kp{fitted}.json"))]
        found = identify_log(merge_logs(logs), stated, law="load_dependent", links=False, simulated=seconds)
        runs = sorted((data / "xl330").glob(f"*kp{simulated}.json"))
        errors = [float(np.mean([xl330.xl330_error(robot, run) for run in runs])) for robot in (stated, found.robot)]
        rows.append([fitted, simulated, *(f"{error:.3f}" for error in errors)])
    whole = [xl330.xl330_log(path) for path in sorted((data / "xl330").glob("*.json"))]
    heads = ("fitted at gain", "simulated at gain", "published Coulomb-viscous, rad", "friction of the load, rad")
    return f"""## XL330, a hobby servo with a pendulum

Mean absolute position error, simulated under the drive's own control, friction fitted at the other gain. Published over
all runs: {xl330.COULOMB_VISCOUS} rad with Coulomb-viscous friction, {xl330.PUBLISHED} rad where it grows with the load.

{table(heads, rows)}

Diagnosed: {told(mjf.diagnose_log(merge_logs(whole), stated))}."""


def staubli(data: Path, folder: Path) -> str:
    """What is found about the wrist's shared drive."""
    diagnosis = mjf.diagnose_log(tx40.tx40_log(data), tx40.tx40(data, folder))
    coupling = next(one for one in diagnosis.findings if one.cause == "drive.coupling")
    published = {"coulomb": 1.95, "viscous": 0.616, "inertia": 0.00964}
    rows = [
        [own.name, f"{own.value:.4g}", f"{own.low:.4g} to {own.high:.4g}", f"{published[own.name]}", own.unit]
        for own in coupling.parameters
        if own.name in published
    ]
    return f"""## Stäubli TX40

Motor 6 turns with joints 5 and 6; the stated model says nothing of it. Diagnosed: {told(diagnosis)}. The coupling:

{table(("", "found", "95 %", "published", "unit"), rows)}"""


def universal(data: Path) -> str:
    """Errors on the part that is not fitted, by identification and by diagnosis."""
    first, rest = ur10.parts(data)
    stated = mjf.read_robot(data / "ur10/robot.toml")
    named = identify_log(first, stated, law=ur10.STRUCTURES).robot
    chosen = identify_log(first, stated).robot
    diagnosis = mjf.diagnose_log(first, stated)
    errors = [ur10.relative_errors(rest, robot) for robot in (stated, chosen, named, diagnosis.robot)]
    columns = [*errors, np.array(ur10.BASE_PARAMETERS)]
    rows = [[joint, *(f"{own[k]:.3g}" for own in columns)] for k, joint in enumerate(stated.joints)]
    heads = ("joint", "stated", "each joint the law it needs", "laws named", "diagnosed", "base parameters")
    laws = " and ".join(f"`{law}` at {joint}" for joint, law in ur10.STRUCTURES.items())
    curve = ur10.stribeck_as_reported(first, diagnosis.robot, 0)
    return f"""## UR10

Error of the effort, %, on the last 40 % of a log whose first 60 % were fitted. Named are {laws}.
The last column is what others reached with base parameters and Coulomb and viscous friction.

{table(heads, rows)}

Diagnosed from the first part: {told(diagnosis)}.

A Stribeck curve at {stated.joints[0]}, fitted to its efforts as they were reported, takes their error from
{curve.plain:.3g} to {curve.stribeck:.3g} %, but with {curve.excess:.3g} N·m near rest beside a level of
{curve.coulomb:.3g}: friction that is next to none there is what the filter of these efforts, of some 2 Hz, makes of one
that turns over at once. Compared below that filter, no Stribeck curve is left to be told."""


def pendulum(data: Path) -> str:
    """Where simulated pendulums end up on a run that is not fitted."""
    folder = data / "pendulum"
    stated = mjf.read_robot(folder / "robot.toml")
    log = mjf.read_log(folder / "ilqr.parquet")
    inverse = identify_log(log, stated, law="coulomb_viscous").robot
    forward = identify_log(log, stated, law="coulomb_viscous", simulated=SWING).robot
    robots = [("stated", stated), ("inverse", inverse), ("forward", forward)]
    (joint,) = mjf.compare_robots(mjf.read_log(folder / "ddp.parquet"), robots, simulated=SWING).joints
    cells = [f"{one.position:.3f}" for one in joint.errors if one.position is not None]
    heads = ("", "published parameters", "inverse dynamics", "simulated motion")
    return f"""## A torque-limited pendulum

Its efforts jump by six times what gravity makes, so that accelerations say little. Fitted to one run (`ilqr`); RMS
position error, rad, on another (`ddp`), {SWING:.0f} s of free swing at a time.

{table(heads, [["RMS, rad", *cells]])}"""


def main() -> None:
    data = Path(os.environ["MJFRICTION_DATA"])
    with tempfile.TemporaryDirectory() as servo_folder, tempfile.TemporaryDirectory() as arm_folder:
        sections = [
            emps_axis(data),
            screws(data),
            servo(data, Path(servo_folder)),
            staubli(data, Path(arm_folder)),
            universal(data),
            pendulum(data),
        ]
    head = """# Real machines

Written by `python -m scripts.real_machines` from logs that their owners published. The tests hold these figures against
what was published too, where the logs are at hand."""
    PAGE.write_text("\n\n".join([head, *sections]) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
