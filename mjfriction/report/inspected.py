"""What is in a log, as data and on a terminal."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from rich.console import Console
from rich.table import Table

from mjfriction.diagnose.audit import find_faults
from mjfriction.diagnose.causes.catalog import STRUCTURAL
from mjfriction.diagnose.visible import Visible, visible_causes
from mjfriction.identify.gap import Gap, measure_gap
from mjfriction.record.log import CURRENT, EFFORT, KNOWN, VELOCITY, Log
from mjfriction.record.mapping import Mapping
from mjfriction.record.motion import Motion, estimate_motion
from mjfriction.record.resample import read_clock
from mjfriction.robot.robot import Robot

PLAIN_CUTOFF = 10.0  # Hz, of derivatives where no robot says how fast its joints can be
FASTEST = 0.99  # quantile of the speed that counts as the top
COLUMNS = 8  # of the table of causes, in 80 characters
HIDDEN = 0.3  # of a joint's effort; a cause that has to make more to be found is as good as invisible


def inspected_table(log: Log, robot: Robot | None) -> dict[str, Any]:
    """Return what a log holds as plain data and, with a robot, the least effect of every cause that could be found.

    Raises :class:`~mjfriction.errors.LogError` or :class:`~mjfriction.errors.RobotError` when either cannot be used.
    """
    clock = read_clock(log)
    gap = measure_gap(log, robot) if robot is not None else None
    motion = gap.motion if gap is not None else estimate_motion(log, log.joints, min(PLAIN_CUTOFF, 0.1 / clock.step))
    known = {f"{quantity}.{joint}" for quantity in KNOWN for joint in log.joints}
    told: dict[str, Any] = {
        "log": log.source,
        "rows": int(log.time.size),
        "seconds": round(sum(float(np.ptp(log.time[log.segment == k])) for k in np.unique(log.segment)), 6),
        "rate": round(1.0 / clock.step, 4),
        "jitter": round(clock.jitter, 6),
        "segments": int(np.unique(log.segment).size),
        "gaps": [[float(log.time[a]), float(log.time[b])] for a, b in clock.gaps],
        "joints": [_joint(log, motion, i, gap) for i in range(len(motion.joints))],
        "other_columns": sorted(set(log.columns) - known),
        "data_problems": [
            {"kind": fault.kind, "where": fault.where, "action": fault.action}
            for fault in (*log.faults, *(find_faults(gap) if gap is not None else ()))
        ],
    }
    if gap is not None:
        told["could_show"] = [_visible(gap, one) for one in visible_causes(gap)]
    return told


def _joint(log: Log, motion: Motion, index: int, gap: Gap | None) -> dict[str, Any]:
    name = motion.joints[index]
    position, velocity = motion.position[:, index], motion.velocity[:, index]
    sure = np.abs(velocity) > 3.0 * motion.velocity_noise[index]
    turns = int(np.count_nonzero(np.diff(np.sign(velocity[sure])) != 0)) if motion.moving[index] else 0
    quantity = motion.quantity[index]
    entry: dict[str, Any] = {
        "joint": name,
        "range": [float(f"{value:.6g}") for value in (np.min(position), np.max(position))],
        "top_speed": float(f"{np.quantile(np.abs(velocity), FASTEST):.4g}"),
        "reversals": turns,
        "measured": [one for one in (VELOCITY, EFFORT, CURRENT) if f"{one}.{name}" in log.columns],
    }
    if quantity is not None:
        entry["rms"] = float(f"{np.sqrt(np.nanmean(np.square(motion.torque[:, index]))):.4g}")
        entry["unit"] = "A" if quantity == CURRENT else _unit(gap, index)
    return entry


def _unit(gap: Gap | None, joint: int) -> str:
    if gap is None:
        return "N·m or N"
    return "N" if gap.body.sliding[joint] else "N·m"


def _visible(gap: Gap, one: Visible) -> dict[str, Any]:
    unit = None if one.joint is None else _unit(gap, gap.robot.joints.index(one.joint))
    return {
        "cause": one.cause,
        "joint": one.joint,
        "least": float(f"{one.size:.3g}"),
        "unit": unit,
        "share": round(one.share, 4),
    }


def print_mapping(guess: Mapping, log: Path, written: Path | None, console: Console) -> None:
    """Print a guess of a file's columns, and how to take it."""
    console.print(f"The columns of {log} have other names. They look like this:", style="bold")
    for own, source in guess.sources.items():
        scaled = "" if source.scale == 1.0 else f" times {source.scale:.6g}"
        console.print(f"  {own}  from '{source.column}'{scaled}", markup=False)
    kept = f"--map {written}" if written is not None else "--map guess"
    console.print(f"If that is right, add {kept} to the command; below, the log is read so.\n")


def print_inspected(told: dict[str, Any], console: Console) -> None:
    """Print what a log holds, and what it could show."""
    segments = f", {told['segments']} segments" if told["segments"] > 1 else ""
    jitter = f", steps uneven by {100 * told['jitter']:.2g} %" if told["jitter"] > 1e-3 else ""
    console.print(told["log"], soft_wrap=True)
    console.print(f"{told['rows']} rows, {told['seconds']:.4g} s at {told['rate']:.4g} Hz{jitter}{segments}")
    for begin, end in told["gaps"]:
        console.print(f"  a gap from {begin:.4g} to {end:.4g} s")
    for problem in told["data_problems"]:
        console.print(f"  {problem['kind']}: {problem['where']}; {problem['action']}")
    table = Table(box=None, padding=(0, 2, 0, 0))
    table.add_column("")
    table.add_column("joint", overflow="fold")
    for head in ("from", "to", "top speed", "reversals", "RMS"):
        table.add_column(head, justify="right")
    table.add_column("")
    for number, joint in enumerate(told["joints"], start=1):
        numbers = [f"{value:.3g}" for value in (*joint["range"], joint["top_speed"])]
        rms = f"{joint['rms']:.3g}" if "rms" in joint else "not measured"
        table.add_row(str(number), joint["joint"], *numbers, str(joint["reversals"]), rms, joint.get("unit", ""))
    console.print(table)
    if told["other_columns"]:
        console.print(f"Besides: {', '.join(told['other_columns'])}")
    if "could_show" not in told:
        console.print("\nWith --robot R this also says what the log could show.")
        return
    _print_visible(told, console)


def _print_visible(told: dict[str, Any], console: Console) -> None:
    console.print(
        "\nWhat it could show: the effect, in % of the joint's RMS effort, from which on a cause is found; joints by "
        "their numbers above, with what concerns the whole arm first"
    )
    places = [None, *(joint["joint"] for joint in told["joints"])]
    least = {(one["cause"], one["joint"]): one["share"] for one in told["could_show"] if one["share"] < HIDDEN}
    causes = list(dict.fromkeys(cause.name for cause in STRUCTURAL))
    for first in range(0, len(places), COLUMNS):
        own = places[first : first + COLUMNS]
        table = Table(box=None, padding=(0, 1, 0, 0))
        table.add_column("")
        for place in own:
            table.add_column("arm" if place is None else str(places.index(place)), justify="right", min_width=5)
        for cause in causes:
            shares = [least.get((cause, place)) for place in own]
            if any(share is not None for share in shares):
                table.add_row(cause, *("" if share is None else f"{100 * share:.2g}" for share in shares))
        console.print(table)
    hidden = [cause for cause in causes if cause not in {name for name, _ in least}]
    if hidden:
        console.print(f"Not on this motion, or for want of a column: {', '.join(hidden)}")
