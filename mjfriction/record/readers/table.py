"""From a table of columns, whatever file it came from, to a checked and repaired log."""

from __future__ import annotations

import numpy as np
import pyarrow as pa

from mjfriction.errors import LogError, suggestion
from mjfriction.record.clock_bursts import without_bursts
from mjfriction.record.clock_order import with_time_in_order
from mjfriction.record.clock_rate import without_clock_drift
from mjfriction.record.clock_resolution import without_coarse_clock
from mjfriction.record.clock_restarts import with_running_clock
from mjfriction.record.clock_steps import without_clock_steps
from mjfriction.record.fault import moment
from mjfriction.record.log import CURRENT, EFFORT, HELD_MASS, OF_JOINTS, OF_MACHINE, VELOCITY, Floats, Integers, Log
from mjfriction.record.repair import in_seconds, repaired, without_repeats

FEWEST_ROWS = 100


def log_from_table(table: pa.Table, source: str) -> Log:
    """Check a table against the log format and return it as a :class:`Log`.

    Raises :class:`LogError` for an empty table, a table too short to differentiate, a missing or non-numeric time or
    position column, NaN or infinite values, a held mass below zero, and time that does not increase within a segment.
    Columns that the format does not define are kept where they hold finite numbers, and left out where they do not.
    """
    table = table.rename_columns([name.strip() for name in table.schema.names])
    names = table.schema.names
    if table.num_rows == 0:
        raise LogError(f"{source}: the table is empty; a log needs rows of 'time' and 'position.<joint>'")
    if "time" not in names:
        raise LogError(f"{source}: column 'time' is missing{suggestion('time', names)} Found: {_listed(names)}")
    joints = tuple(name.removeprefix("position.") for name in names if name.startswith("position."))
    if not joints:
        raise LogError(f"{source}: no 'position.<joint>' column. Found: {_listed(names)}")
    if table.num_rows < FEWEST_ROWS:
        raise LogError(
            f"{source}: {table.num_rows} rows are too few; a diagnosis needs at least {FEWEST_ROWS}, "
            "and some tens of seconds of motion to say anything"
        )
    columns = {}
    for name in names:
        values = _numbers(table[name])
        wrong = _of_format(name, joints) and _wrong(table[name], values, name)
        if wrong:
            raise LogError(f"{source}: {wrong}")
        if values is not None and np.all(np.isfinite(values)):
            columns[name] = values
    time = columns.pop("time")
    segment = _segment(columns.pop("segment", None), time, source)
    log = in_seconds(Log(source=source, time=time, segment=segment, joints=joints, columns=columns))
    log = without_coarse_clock(with_time_in_order(with_running_clock(log)))
    whole = without_clock_drift(without_clock_steps(without_bursts(without_repeats(log))))
    _check_time(whole.time, whole.segment, source)
    return repaired(whole)


def _of_format(name: str, joints: tuple[str, ...]) -> bool:
    quantity, dot, joint = name.partition(".")
    if not dot:
        return name in {"time", "segment", *OF_MACHINE}
    return quantity in (VELOCITY, EFFORT, CURRENT) or (quantity in OF_JOINTS and joint in joints)


def _numbers(column: pa.ChunkedArray) -> Floats | None:
    if not (pa.types.is_floating(column.type) or pa.types.is_integer(column.type)):
        return None
    return np.array(column.to_numpy(), dtype=np.float64)


def _wrong(column: pa.ChunkedArray, values: Floats | None, name: str) -> str:
    # What is wrong with a column of the format, "" where nothing is.
    if pa.types.is_null(column.type):
        return f"column '{name}' is empty; delete it if nothing was recorded"
    if values is None:
        text = next((value for value in column.to_pylist() if not _is_number(value)), None)
        return f"column '{name}' holds {text!r}, which is not a number"
    bad = np.flatnonzero(~np.isfinite(values))
    if bad.size:
        return (
            f"row {bad[0] + 1}, column '{name}' is {values[bad[0]]} ({bad.size} such rows); "
            "drop those rows, or fill them if the gap is short"
        )
    light = np.flatnonzero(values < 0.0) if name == HELD_MASS else bad
    if light.size:
        return f"row {light[0] + 1}, column '{name}' is {values[light[0]]:g}; a mass is 0 kg or more"
    return ""


def _is_number(value: object) -> bool:
    try:
        float(value)  # type: ignore[arg-type]
    except (TypeError, ValueError):
        return False
    return True


def _segment(values: Floats | None, time: Floats, source: str) -> Integers:
    if values is None:
        return np.zeros(time.size, dtype=np.int64)
    if np.any(values != np.round(values)):
        raise LogError(f"{source}: column 'segment' must hold whole numbers, one per motion")
    return values.astype(np.int64)


def _check_time(time: Floats, segment: Integers, source: str) -> None:
    step = np.diff(time)
    wrong = np.flatnonzero((step <= 0.0) & (np.diff(segment) == 0))
    if wrong.size == 0:
        return
    row = int(wrong[0])
    what = "is doubled" if step[row] == 0.0 else f"runs backwards (after {moment(time[row])} s)"
    raise LogError(
        f"{source}: row {row + 2}: time {moment(time[row + 1])} s {what} ({wrong.size} such rows); "
        "time must increase; number separate motions in a 'segment' column, or drop the doubled rows"
    )


def _listed(names: list[str]) -> str:
    return ", ".join(names) if len(names) <= 12 else ", ".join(names[:12]) + f", … ({len(names)} columns)"
