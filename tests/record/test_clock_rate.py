"""A clock that ran at another rate for a while is put right; rows that really came at another rate keep their time."""

from __future__ import annotations

import numpy as np
import pyarrow as pa
import pytest

from mjfriction.record.log import Floats, Log
from mjfriction.record.readers.table import log_from_table

STEP, COUNT = 5e-3, 4000
STRETCH = slice(1500, 2300)
RATES = [0.8, 1.3]


def log_of(clock: Floats, true: Floats, *, still: bool = False, measured: bool = False) -> Log:
    """A joint on a sine, at rest through both edges of the stretch if ``still``, seen at the ``true`` times."""
    rng = np.random.default_rng(0)
    low, high = true[STRETCH][[0, -1]]
    inside = np.clip((true - low - 0.5) / (high - low - 1.0), 0.0, 1.0)
    place = 0.4 * np.sin(np.pi * inside) ** 4 if still else 0.4 * np.sin(2.1 * true)
    table = {"time": clock, "position.axis": place + 2e-5 * rng.normal(size=COUNT), "effort.axis": np.cos(true)}
    if measured:
        table["velocity.axis"] = np.gradient(place, true) + 1e-3 * rng.normal(size=COUNT)
    return log_from_table(pa.table(table), "log")


def at_rate(rate: float) -> Floats:
    step = np.full(COUNT - 1, STEP)
    step[STRETCH] *= rate
    return np.concatenate([[0.0], np.cumsum(step)])


@pytest.mark.parametrize("rate", RATES)
@pytest.mark.parametrize(("still", "measured"), [(False, False), (True, True)])
def test_a_clock_that_ran_otherwise_is_put_right(rate: float, *, still: bool, measured: bool) -> None:
    true = STEP * np.arange(COUNT)
    log = log_of(at_rate(rate), true, still=still, measured=measured)
    np.testing.assert_allclose(log.time, true, atol=1e-9)
    (fault,) = log.faults
    assert fault.kind == "data.clock"
    assert f"{true[STRETCH.start]:.6g} s" in fault.where
    assert f"{rate:.4g} times as fast" in fault.action
    assert log.recorded is not None
    np.testing.assert_allclose(log.recorded, at_rate(rate))


@pytest.mark.parametrize("rate", RATES)
@pytest.mark.parametrize(("still", "measured"), [(False, False), (True, True)])
def test_rows_that_came_at_another_rate_keep_their_time(rate: float, *, still: bool, measured: bool) -> None:
    log = log_of(at_rate(rate), at_rate(rate), still=still, measured=measured)
    np.testing.assert_allclose(log.time, at_rate(rate))
    assert log.faults == ()


def test_where_nothing_tells_the_clock_is_kept() -> None:
    log = log_of(at_rate(1.3), STEP * np.arange(COUNT), still=True)
    np.testing.assert_allclose(log.time, at_rate(1.3))
    assert log.faults == ()


def test_a_clock_that_jitters_has_no_rate() -> None:
    true = STEP * np.arange(COUNT)
    clock = true + 0.2 * STEP * np.random.default_rng(1).uniform(-1.0, 1.0, COUNT)
    np.testing.assert_allclose(log_of(clock, true).time, clock)
