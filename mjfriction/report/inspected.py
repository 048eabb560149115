"""The contents of a log, as plain data."""

from __future__ import annotations

from typing import Any

import numpy as np

from mjfriction.diagnose.faults.mend import audited
from mjfriction.diagnose.tell.visible import Visible, visible_causes
from mjfriction.identify.gap import Gap
from mjfriction.progress import Tell, silently
from mjfriction.record.log import CURRENT, EFFORT, KNOWN, VELOCITY, Log
from mjfriction.record.motion import Motion, estimate_motion
from mjfriction.record.resample import read_clock
from mjfriction.robot.effort import reported_unit
from mjfriction.robot.robot import Robot

PLAIN_CUTOFF = 10.0  # Hz, cutoff of derivatives without a robot, whose joints' speeds would set it
_UNSURE = {CURRENT: "A", EFFORT: "N·m or N"}  # units without a robot, which would state whether a joint turns or slides
FASTEST = 0.99  # quantile of the speed that counts as the top speed


def inspected_table(log: Log, robot: Robot | None, tell: Tell = silently) -> dict[str, Any]:
    """Return the contents of a log, as it is written, as plain data, and, with a robot, what the log could show.

    That is the least effect of every cause that could be found; the list is empty where it is not certain how the log
    should have been read.  ``tell`` receives the progress.

    Raises :class:`~mjfriction.errors.LogError` or :class:`~mjfriction.errors.RobotError` when either cannot be used.
    """
    tell("measuring the log")
    clock = read_clock(log)
    audit = audited(log, robot) if robot is not None else None
    gap = audit.stated if audit is not None else None
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
            for fault in (*log.faults, *((*audit.faults, *audit.unused) if audit is not None else ()))
        ],
    }
    if audit is not None:
        # Nothing is listed for a log that cannot be read correctly: it would be about wrong data.
        told["could_show"] = (
            [] if audit.refused else [_visible(audit.gap, one) for one in visible_causes(audit.gap, tell)]
        )
    return told


def _joint(log: Log, motion: Motion, index: int, gap: Gap | None) -> dict[str, Any]:
    name = motion.joints[index]
    position, velocity = motion.position[:, index], motion.velocity[:, index]
    sure = np.abs(velocity) > motion.sure_speed[:, index]
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
        entry["unit"] = reported_unit(quantity, gap.body.sliding[index]) if gap is not None else _UNSURE[quantity]
    return entry


def _visible(gap: Gap, one: Visible) -> dict[str, Any]:
    unit = None
    if one.joint is not None:
        unit = reported_unit(EFFORT, gap.body.sliding[gap.robot.joints.index(one.joint)])
    return {
        "cause": one.cause,
        "joint": one.joint,
        "least": float(f"{one.size:.3g}"),
        "unit": unit,
        "share": round(one.share, 4),
    }
