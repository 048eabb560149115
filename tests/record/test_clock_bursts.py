"""Rows that came in bursts are put where they were sampled; rows that are missing stay so."""

from __future__ import annotations

import numpy as np
import pyarrow as pa
import pytest

from mjfriction.errors import LogError
from mjfriction.record.log import Floats, Log
from mjfriction.record.readers.table import log_from_table

STEP, COUNT, ROWS = 5e-3, 4000, 12
TRUE = STEP * np.arange(COUNT)


def in_bursts(rows: slice, apart: float, *, at_the_end: bool = False) -> Floats:
    """Return the clock of a recorder that stamps so many rows at once, where the first was sampled or the last."""
    clock = TRUE.copy()
    for first in range(rows.start, rows.stop, ROWS):
        own = np.arange(first, min(first + ROWS, COUNT))
        stamped = TRUE[own[-1]] - apart * (ROWS - 1) if at_the_end else TRUE[first]
        clock[own] = stamped + apart * np.arange(own.size)
    return clock


def log_of(clock: Floats, true: Floats = TRUE, *, kept: np.ndarray | None = None, still: bool = False) -> Log:
    kept = np.ones(true.size, dtype=bool) if kept is None else kept
    rng = np.random.default_rng(0)
    place = np.zeros(true.size) if still else 0.4 * np.sin(2.1 * true)
    place = place + 2e-5 * rng.normal(size=true.size)
    table = {"time": clock, "position.axis": place, "effort.axis": np.cos(true) + 0.1 * rng.normal(size=true.size)}
    return log_from_table(pa.table({name: values[kept] for name, values in table.items()}), "log")


@pytest.mark.parametrize("rows", [slice(600, 1800), slice(600, 612), slice(0, COUNT - 4)])
@pytest.mark.parametrize(
    ("apart", "at_the_end", "still"), [(2e-5, False, False), (0.0, True, False), (2e-5, True, True)]
)
def test_time_is_even_where_rows_came_in_bursts(rows: slice, apart: float, *, at_the_end: bool, still: bool) -> None:
    clock = in_bursts(rows, apart, at_the_end=at_the_end)
    log = log_of(clock, still=still)
    np.testing.assert_allclose(log.time, TRUE, atol=ROWS * STEP if rows.start == 0 else 1e-9)
    np.testing.assert_allclose(np.diff(log.time), STEP, rtol=0.01)
    (fault,) = log.faults
    assert fault.kind == "data.clock"
    assert f"up to {ROWS} rows came at once" in fault.action
    assert log.recorded is not None
    np.testing.assert_allclose(log.recorded, clock)


def test_packets_hold_a_row_more_or_less_by_turns() -> None:
    packet = np.ceil(TRUE / (12.516 * STEP))
    within = np.arange(COUNT) - np.searchsorted(packet, packet)
    log = log_of(packet * 12.516 * STEP + 2e-5 * within)
    np.testing.assert_allclose(np.diff(log.time), STEP, rtol=2e-3)
    (fault,) = log.faults
    assert fault.kind == "data.clock"


def test_rows_that_are_missing_between_bursts_are_a_gap() -> None:
    clock, kept = in_bursts(slice(600, 1800), 2e-5), np.ones(COUNT, dtype=bool)
    kept[600:1800] = np.arange(1200) % (2 * ROWS) < ROWS
    log = log_of(clock, kept=kept)
    assert not any("came at once" in fault.action for fault in log.faults)


def test_samples_that_were_taken_in_bursts_keep_their_time() -> None:
    clock = in_bursts(slice(600, 1800), 1e-3)
    log = log_of(clock, clock)
    np.testing.assert_allclose(log.time, clock)


def test_a_doubled_time_is_refused_where_no_burst_explains_it() -> None:
    clock = TRUE.copy()
    clock[1000] = clock[999]
    with pytest.raises(LogError, match="is doubled"):
        log_of(clock)


def test_a_clock_that_jitters_comes_in_no_bursts() -> None:
    clock = TRUE + 0.4 * STEP * np.random.default_rng(1).uniform(-1.0, 1.0, size=COUNT)
    assert log_of(clock, clock).faults == ()


@pytest.mark.parametrize("rows", [slice(600, 1800), slice(0, COUNT - 4)])
def test_a_burst_that_was_lost_is_a_gap(rows: slice) -> None:
    clock, kept = in_bursts(rows, 2e-5), np.ones(COUNT, dtype=bool)
    lost = slice(rows.start + 50 * ROWS, rows.start + 51 * ROWS)
    kept[lost] = False
    log = log_of(clock, kept=kept)
    step = np.diff(log.time)
    assert np.max(step) == pytest.approx(ROWS * STEP, rel=0.1)
    assert np.sort(step)[-2] == pytest.approx(STEP, rel=0.1)


@pytest.mark.parametrize("pause", [20.0, 60.0, 3600.0])
def test_a_pause_of_the_recording_is_no_burst(pause: float) -> None:
    clock = TRUE + pause * (np.arange(COUNT) >= COUNT // 2)
    log = log_of(clock, still=True)
    np.testing.assert_allclose(log.time, clock)
    assert log.faults == ()


@pytest.mark.parametrize("unit", [1e3, 1e9])
def test_the_unit_of_a_clock_is_told_by_the_rows_that_came_in_bursts(unit: float) -> None:
    log = log_of(unit * in_bursts(slice(0, COUNT - 4), 2e-5))
    np.testing.assert_allclose(np.diff(log.time), STEP, rtol=0.02)
    assert [fault.kind for fault in log.faults] == ["data.unit", "data.clock"]
