"""A clock that was set while the machine went on is put right; where rows are missing there is a gap."""

from __future__ import annotations

import numpy as np
import pyarrow as pa
import pytest

from mjfriction.errors import LogError
from mjfriction.record.log import Floats, Log
from mjfriction.record.readers.table import log_from_table
from mjfriction.record.resample import read_clock

STEP, COUNT, AT = 2e-3, 6000, 2500


def log_of(time: Floats, kept: np.ndarray | None = None, still: float | None = None) -> Log:
    true = STEP * np.arange(COUNT)
    place = np.sin(1.3 * (true if still is None else np.minimum(true, still)))
    position = place + 1e-5 * np.random.default_rng(0).normal(size=COUNT)
    columns = {"time": time, "position.axis": position, "effort.axis": np.cos(1.3 * true)}
    rows = slice(None) if kept is None else kept
    return log_from_table(pa.table({name: values[rows] for name, values in columns.items()}), "log")


@pytest.mark.parametrize("by", [-0.0934, -4.0, 1.13, 0.05])
def test_a_clock_that_was_set_is_put_right(by: float) -> None:
    true = STEP * np.arange(COUNT)
    log = log_of(true + np.where(np.arange(COUNT) > AT, by, 0.0))
    np.testing.assert_allclose(log.time, true, atol=1e-9)
    (fault,) = log.faults
    assert fault.kind == "data.clock"
    assert f"{true[AT]:.6g} s" in fault.where
    assert not read_clock(log).gaps
    assert log.recorded is not None
    assert log.as_recorded(log.time).size == COUNT


@pytest.mark.parametrize("missing", [0.05, 1.13])
def test_rows_that_are_missing_are_a_gap(missing: float) -> None:
    true = STEP * np.arange(COUNT)
    rows = np.arange(COUNT)
    log = log_of(true, kept=(rows <= AT) | (rows > AT + round(missing / STEP)))
    assert log.faults == ()
    assert len(read_clock(log).gaps) == 1


def test_two_motions_in_one_file_are_no_clock_that_was_set() -> None:
    first = STEP * np.arange(COUNT)
    position = np.append(np.sin(1.3 * first), 0.3 + np.cos(2.1 * first))
    table = {"time": np.tile(first, 2), "position.axis": position, "effort.axis": np.cos(position)}
    with pytest.raises(LogError, match="number separate motions"):
        log_from_table(pa.table(table), "log")


def test_a_pause_of_the_recording_while_nothing_moves_is_a_gap() -> None:
    true = STEP * np.arange(COUNT)
    log = log_of(true + np.where(np.arange(COUNT) > AT, 1.13, 0.0), still=STEP * (AT - 200))
    assert "data.clock" not in {fault.kind for fault in log.faults}
    assert len(read_clock(log).gaps) == 1


def test_a_motion_that_begins_right_after_a_pause_of_the_recording_did_not_go_on() -> None:
    # Of a good encoder: what little noise it has hides no motion, and what moves is not where it would have gone to.
    true, noise = STEP * np.arange(COUNT), 1e-9 * np.random.default_rng(0).normal(size=COUNT)
    begun = np.maximum(true - true[AT + 1], 0.0)
    columns = {"position.axis": 0.2 * begun**2 + noise, "effort.axis": begun}
    log = log_from_table(pa.table({"time": true + np.where(np.arange(COUNT) > AT, 0.3, 0.0), **columns}), "log")
    assert log.faults == ()
    assert len(read_clock(log).gaps) == 1


@pytest.mark.parametrize(("elsewhere", "set_"), [(0.0, True), (1.2, False)])
def test_one_joint_that_goes_on_says_nothing_where_another_rests_elsewhere(elsewhere: float, set_: bool) -> None:
    # A transition that was left out: one joint happens to be where it was, the other went from pose to pose.
    true = STEP * np.arange(COUNT)
    later = np.arange(COUNT) > AT
    noise = 1e-5 * np.random.default_rng(0).normal(size=(2, COUNT))
    going, resting = np.sin(1.3 * true) + noise[0], np.where(later, elsewhere, 0.0) + noise[1]
    columns = {"position.axis": going, "position.other": resting, "effort.axis": going, "effort.other": noise[1]}
    log = log_from_table(pa.table({"time": true + np.where(later, 4.6, 0.0), **columns}), "log")
    assert ("data.clock" in {fault.kind for fault in log.faults}) is set_
    assert bool(read_clock(log).gaps) is not set_
