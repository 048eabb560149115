"""Repair of a log: the faults of its recording are removed and reported."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from mjfriction.record.clipped import clipped, stands_at_limits
from mjfriction.record.clock import steps_of
from mjfriction.record.clock_bursts import burst_step
from mjfriction.record.fault import Fault, in_words
from mjfriction.record.glitches import felt, glitches
from mjfriction.record.log import CURRENT, EFFORT, POSITION, VELOCITY, Floats, Integers, Log
from mjfriction.record.motion import HELD
from mjfriction.record.repeats import held_rows, repeated_rows, written_again
from mjfriction.record.resample import GAP_STEPS
from mjfriction.record.runs import Mask, spans
from mjfriction.record.stuck import frozen, stuck
from mjfriction.record.ticks import TICKS, tick_of

# s; longer steps are not in seconds: steps of 1 or more in milliseconds are those of a log of 1 kHz at most.
SLOWEST_CLOCK = 1.0
FASTEST = 30.0  # rad/s or m/s, beyond the usual speed of any joint
ENDS = 0.01  # share of a joint's samples at either end of its travel that are ignored, as they may be glitches
FEW_COUNTS = 20  # distinct readings of a channel; with no more, its sensor is too coarse to detect clipping at rest
MOST_CLIPPED = 0.8  # of a channel's samples; beyond this the channel is not a recording of a torque


def in_seconds(log: Log) -> Log:
    """Return the log with its clock read in milli-, micro- or nanoseconds where its steps are too long for seconds, and
    a fault that reports it.

    The clock is kept where a joint would then be faster than any real one: the log really has a row every second or
    more.
    """
    steps = steps_of(log)
    step = float(np.median(np.diff(log.time))) if steps is None else burst_step(steps) or steps.ordinary
    unit = tick_of(step)
    if not step >= SLOWEST_CLOCK or unit == "seconds":
        return log
    moved = [float(np.median(np.abs(np.diff(log.columns[f"{POSITION}.{joint}"])))) for joint in log.joints]
    if max(moved, default=0.0) > FASTEST * step * TICKS[unit]:
        return log
    fault = Fault("data.unit", "time", f"steps of {step:.4g} are none of seconds: read in {unit}")
    return replace(log, time=log.time * TICKS[unit], faults=(*log.faults, fault))


def without_repeats(log: Log) -> Log:
    """Return the log without repeated rows, and faults that report them.

    Rows may be written twice, repeat an earlier stretch of rows, or hold one row while the machine moves on.
    """
    once = _without_repeated(log, written_again(log.time, log.segment, log.columns))
    return _without_repeated(once, repeated_rows(once.columns) | held_rows(once.columns, _unbroken(once)))


def _without_repeated(log: Log, repeated: Mask) -> Log:
    if not np.any(repeated):
        return log
    places = _places(log, repeated)
    count = int(np.count_nonzero(repeated))
    fault = Fault("data.duplicate", f"{in_words(places)} ({count} rows)", "dropped the repeated rows", places)
    return replace(without_rows(log, repeated), segment=log.segment[~repeated], faults=(*log.faults, fault))


def repaired(log: Log) -> Log:
    """Return the log with glitches bridged, stuck positions left out, and clipped or stuck efforts marked unusable."""
    columns = dict(log.columns)
    faults = list(log.faults)
    unusable = dict(log.unusable)
    dropped = np.zeros(log.time.size, dtype=bool)
    piece = _unbroken(log)
    travel = {joint: _travel(columns[f"{POSITION}.{joint}"]) for joint in log.joints}
    for joint in log.joints:
        for quantity in (POSITION, VELOCITY, EFFORT, CURRENT):
            name = f"{quantity}.{joint}"
            if name in columns:
                wild = glitches(columns[name])
                if quantity != POSITION:
                    wild &= ~felt(wild, columns[name], columns[f"{POSITION}.{joint}"], piece)
                columns[name], found = _bridged(log, name, wild)
                faults += found
        speed = _speed(log, columns, joint)
        effort = next((columns[f"{own}.{joint}"] for own in (EFFORT, CURRENT) if f"{own}.{joint}" in columns), None)
        course = np.cumsum(speed * np.diff(log.time, prepend=log.time[0]))
        still = stuck(columns[f"{POSITION}.{joint}"], speed, piece, effort, course)
        # A joint that is held, and only yields, moves by single counts of its encoder, which would look stuck.
        if np.any(still) and travel[joint] > HELD * max(travel.values()):
            fault = _found_at(log, "data.stuck", f"{POSITION}.{joint}", still, "those rows were left out")
            faults.append(replace(fault, spans=_places(log, still)))
            dropped |= still
        moving = np.abs(speed) > 0.05 * np.sqrt(np.mean(np.square(speed)))
        for quantity in (EFFORT, CURRENT):
            name = f"{quantity}.{joint}"
            if name not in columns:
                continue
            # Of a joint that is held, a coarse sensor reads only a few counts, so that it is often at its extremes.
            held_still = not np.any(moving) and np.unique(columns[name]).size > FEW_COUNTS
            flat = clipped(columns[name], ~moving if held_still else moving)
            held = frozen(columns[name], moving) & ~flat
            limited = stands_at_limits(columns[name], held)
            flat, held = flat | limited, held & ~limited
            said = {
                "data.saturation": (
                    flat,
                    "those samples say only that the drive gave no more, and were not used: record slower motion",
                ),
                "data.stuck": (held, "those samples were not used"),
            }
            for kind, (mask, action) in said.items():
                if 0.0 < np.mean(mask) < MOST_CLIPPED:
                    unusable[name] = unusable.get(name, np.zeros(mask.size, dtype=bool)) | mask
                    faults.append(_found_at(log, kind, name, mask, action))
    changed = replace(log, columns=columns, faults=tuple(faults), unusable=unusable)
    return without_rows(changed, dropped) if np.any(dropped) else changed


def _unbroken(log: Log) -> Integers:
    # The number of the unbroken stretch that each row belongs to: segments, cut at their gaps.
    steps = steps_of(log)
    if steps is None:
        return log.segment
    ordinary = steps.ordinary
    if (sampled := burst_step(steps)) is not None:
        ordinary = max(sampled, float(np.max(steps.length[steps.joined])) / GAP_STEPS)  # pauses of bursts are no gaps
    return np.append(0, np.cumsum(~steps.joined | (np.abs(steps.length) > GAP_STEPS * ordinary)))


def _travel(position: Floats) -> float:
    low, high = np.quantile(position, [ENDS, 1.0 - ENDS])
    return float(high - low)


def _bridged(log: Log, name: str, wild: Mask) -> tuple[Floats, list[Fault]]:
    values = log.columns[name]
    if not np.any(wild):
        return values, []
    index = np.arange(values.size)
    mended = values.copy()
    mended[wild] = np.interp(index[wild], index[~wild], values[~wild])
    return mended, [_found_at(log, "data.glitch", name, wild, "bridged by the samples beside it")]


def _speed(log: Log, columns: dict[str, Floats], joint: str) -> Floats:
    measured = columns.get(f"{VELOCITY}.{joint}")
    if measured is not None and np.ptp(measured) > 0.0:
        return measured
    position = columns[f"{POSITION}.{joint}"]
    step = np.diff(log.time, append=2.0 * log.time[-1] - log.time[-2])
    change = np.diff(position, append=position[-1])
    joined = np.diff(log.segment, append=log.segment[-1]) == 0
    ordinary = float(np.median(step))
    return np.where(joined & (step > 0.0), change / np.maximum(step, 0.1 * ordinary), 0.0)


def _found_at(log: Log, kind: str, name: str, mask: np.ndarray, action: str) -> Fault:
    return Fault(kind, f"{name}, {in_words(_places(log, mask))}", action)


def _places(log: Log, mask: np.ndarray) -> tuple[tuple[float, float], ...]:
    return tuple((float(log.time[a]), float(log.time[b - 1])) for a, b in spans(mask))


def without_rows(log: Log, rows: Mask) -> Log:
    """Return the log without some of its rows, (n,)."""
    kept = ~rows
    # A new segment begins after every stretch left out, however short: the rows on either side are not one motion.
    piece = np.cumsum(np.append(0, np.diff(log.segment) != 0) | np.append(False, rows[:-1] & ~rows[1:]))
    return replace(
        log,
        time=log.time[kept],
        segment=piece[kept].astype(np.int64),
        columns={name: values[kept] for name, values in log.columns.items()},
        unusable={name: mask[kept] for name, mask in log.unusable.items()},
        recorded=log.time if log.recorded is None else log.recorded,
        kept=log.as_recorded(kept.astype(np.float64)) == 1.0,
    )
