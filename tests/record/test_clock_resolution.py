"""Rows that share a stamp, for the clock reads coarsely, are put where they were sampled."""

from __future__ import annotations

import numpy as np
import pyarrow as pa
import pytest

from mjfriction.errors import LogError
from mjfriction.record.log import Floats, Log
from mjfriction.record.readers.table import log_from_table

STEP, COUNT = 4e-3, 4000
TRUE = STEP * np.arange(COUNT)


def log_of(clock: Floats, true: Floats = TRUE, *, rests: float = 0.0, times: int = 1) -> Log:
    rng = np.random.default_rng(0)
    place = 0.4 * np.sin(2.1 * np.maximum(true - rests, 0.0))
    counts = 1e-4 * np.round(place / 1e-4)
    effort = np.round(
        np.cos(2.1 * np.maximum(true - rests, 0.0)) + 0.1 * rng.normal(size=true.size) * (true > rests), 3
    )
    table = {"time": clock, "position.axis": counts, "effort.axis": effort}
    return log_from_table(pa.table({name: np.repeat(values, times) for name, values in table.items()}), "log")


@pytest.mark.parametrize("rows", [1.25, 2.5, 12.516])
@pytest.mark.parametrize("rests", [0.0, 3.0])
def test_time_is_even_where_the_clock_reads_coarsely(rows: float, rests: float) -> None:
    clock = np.ceil(TRUE / (rows * STEP)) * rows * STEP
    log = log_of(clock, rests=rests)
    assert log.time.size == COUNT
    np.testing.assert_allclose(np.diff(log.time), STEP, rtol=2e-3)
    assert np.ptp(log.time - TRUE) < rows * STEP
    (fault,) = log.faults
    assert fault.kind == "data.clock"
    assert f"a row came every {STEP:.3g}" in fault.action
    assert log.recorded is not None
    np.testing.assert_allclose(log.recorded, clock)


def test_stamps_of_whole_milliseconds_that_come_as_they_may_are_evened_out() -> None:
    clock = STEP * np.maximum.accumulate(np.round(np.arange(COUNT) + np.random.default_rng(1).normal(0.0, 0.4, COUNT)))
    assert {0, 1, 2} <= set(np.round(np.diff(clock) / STEP).astype(int).tolist())
    log = log_of(clock)
    np.testing.assert_allclose(np.diff(log.time), STEP, rtol=2e-3)
    assert [fault.kind for fault in log.faults] == ["data.clock"]


def test_a_gap_stays_one() -> None:
    true = np.where(np.arange(COUNT) < 1500, TRUE, TRUE + 0.7)
    log = log_of(np.floor(true / 0.01) * 0.01, true)
    step = np.diff(log.time)
    assert step[1499] == pytest.approx(0.7 + STEP, abs=0.01)
    np.testing.assert_allclose(np.delete(step, 1499), STEP, rtol=5e-3)


def test_rows_that_were_written_twice_share_a_stamp_for_another_reason() -> None:
    log = log_of(TRUE, times=2)
    assert {fault.kind for fault in log.faults} == {"data.duplicate"}
    assert log.time.size == COUNT


def test_samples_that_differ_at_one_instant_are_refused() -> None:
    clock = TRUE.copy()
    clock[1000] = clock[999]
    with pytest.raises(LogError, match="is doubled"):
        log_of(clock)
