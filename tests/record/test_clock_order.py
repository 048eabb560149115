"""A clock that ran to and fro: rows stamped at random are spread evenly, rows out of order are put in order."""

from __future__ import annotations

import numpy as np
import pyarrow as pa
import pytest

from mjfriction.errors import LogError
from mjfriction.record.log import Floats, Log
from mjfriction.record.readers.table import log_from_table

STEP, COUNT = 4e-3, 4000
TRUE = STEP * np.arange(COUNT)


def log_of(clock: Floats, order: np.ndarray, *, segment: np.ndarray | None = None, still: bool = False) -> Log:
    """Return a log whose rows were sampled at ``TRUE[order]`` and stamped with ``clock``."""
    rng, true = np.random.default_rng(0), TRUE[order]
    place = (0.0 if still else 0.4) * np.sin(2.1 * true) + 2e-5 * rng.normal(size=COUNT)
    columns = {"time": clock, "position.axis": place, "effort.axis": np.cos(true) + 0.1 * rng.normal(size=COUNT)}
    return log_from_table(pa.table(columns | ({} if segment is None else {"segment": segment})), "log")


def stamped_at_random(rows: slice, spread: float) -> Floats:
    clock = TRUE.copy()
    clock[rows] += spread * STEP * np.random.default_rng(1).normal(size=TRUE[rows].size)
    return clock


@pytest.mark.parametrize("still", [False, True])
@pytest.mark.parametrize("rows", [slice(600, 1800), slice(1, COUNT - 1)])
@pytest.mark.parametrize("spread", [0.7, 3.0])
def test_rows_that_were_stamped_at_random_are_spread_evenly(rows: slice, spread: float, *, still: bool) -> None:
    clock = stamped_at_random(rows, spread)
    log = log_of(clock, np.arange(COUNT), still=still)
    np.testing.assert_allclose(log.time, TRUE, atol=2.0 * STEP)
    assert np.all(np.diff(log.time) > 0.0)
    assert [fault.kind for fault in log.faults] == ["data.clock"]
    assert "time ran to and fro" in log.faults[0].action
    assert log.recorded is not None
    np.testing.assert_allclose(log.recorded, clock)


def test_rows_that_are_stamped_too_far_off_are_refused() -> None:
    with pytest.raises(LogError, match="runs backwards"):
        log_of(stamped_at_random(slice(600, 1800), 30.0), np.arange(COUNT))


@pytest.mark.parametrize("packet", [40, 200])
def test_rows_out_of_order_are_put_in_the_order_of_their_time(packet: int) -> None:
    order = np.arange(COUNT)
    for first in range(500, 900, packet):
        order[first : first + packet] = np.random.default_rng(first).permutation(order[first : first + packet])
    log = log_of(TRUE[order], order)
    np.testing.assert_allclose(log.time, TRUE)
    np.testing.assert_allclose(log.columns["position.axis"], 0.4 * np.sin(2.1 * TRUE), atol=2e-4)
    (fault,) = log.faults
    assert (fault.kind, fault.action) == ("data.clock", "rows were out of order: put in the order of their time")


def test_two_motions_without_a_segment_number_are_refused() -> None:
    half = COUNT // 2
    with pytest.raises(LogError, match="runs backwards"):
        log_of(np.tile(TRUE[:half], 2), np.concatenate([np.arange(half), np.arange(700, half + 700)]))


def test_a_clock_that_starts_again_with_a_segment_is_no_scramble() -> None:
    half = COUNT // 2
    clock, segment = np.concatenate([TRUE[:half], TRUE[:half]]), np.repeat([0, 1], half)
    log = log_of(clock, np.arange(COUNT), segment=segment)
    (fault,) = log.faults
    assert "the clock starts again" in fault.action
