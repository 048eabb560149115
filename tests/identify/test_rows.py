"""The measurement chain and the blocks it is cut into."""

from __future__ import annotations

import numpy as np
import pyarrow as pa
import pytest

from mjfriction.errors import LogError
from mjfriction.identify import rows
from mjfriction.identify.blocks import cut_blocks
from mjfriction.identify.measure import measure_gap
from mjfriction.identify.regression import Rows
from mjfriction.identify.rows import make_chain
from mjfriction.record.log import Log
from mjfriction.record.motion import Motion, estimate_motion
from mjfriction.record.readers.table import log_from_table
from mjfriction.robot.files import read_robot
from mjfriction.robot.schema import EffortSensor
from tests.hidden.machine import Machine, record


def motion_of(time: np.ndarray, position: np.ndarray, segment: np.ndarray | None = None) -> Motion:
    segment = np.zeros(time.size, dtype=np.int64) if segment is None else segment
    log = Log("test", time, segment, ("a",), {"position.a": position, "effort.a": position})
    return estimate_motion(log, ["a"], 25.0)


def test_the_chain_is_linear_without_lag_and_passes_the_band() -> None:
    time = np.arange(5000) / 250.0
    motion = motion_of(time, np.sin(2.0 * np.pi * time))
    chain = make_chain(motion, "test")
    for frequency in (0.5, 2.0, 5.0):
        slow = np.sin(2.0 * np.pi * frequency * time + 0.4)
        np.testing.assert_allclose(chain.rows(slow), np.sin(2.0 * np.pi * frequency * chain.time + 0.4), atol=0.02)
    fast = np.sin(2.0 * np.pi * 60.0 * time)
    assert np.abs(chain.rows(fast)).max() < 1e-2
    two = np.column_stack([slow, fast])
    np.testing.assert_allclose(chain.rows(two)[:, 0], chain.rows(slow))
    np.testing.assert_allclose(chain.rows(2.0 * slow - fast), 2.0 * chain.rows(slow) - chain.rows(fast), atol=1e-12)


def test_white_noise_stays_white_and_shrinks_as_said() -> None:
    time = np.arange(60000) / 250.0
    chain = make_chain(motion_of(time, np.sin(time)), "test")
    noise = chain.rows(np.random.default_rng(0).normal(size=time.size))
    assert np.std(noise) == pytest.approx(chain.noise_gain, rel=0.03)
    assert abs(np.mean(noise[1:] * noise[:-1])) < 0.12 * np.var(noise)


def test_no_window_reaches_across_a_gap() -> None:
    time = np.arange(4000) / 250.0 + np.where(np.arange(4000) < 2000, 0.0, 5.0)
    motion = motion_of(time, np.sin(time))
    chain = make_chain(motion, "test")
    step = np.where(np.arange(4000) < 2000, 0.0, 100.0)
    values = chain.rows(step)
    assert set(np.round(values, 6)) == {0.0, 100.0}


def test_touched_is_the_share_of_the_window() -> None:
    time = np.arange(2000) / 250.0
    chain = make_chain(motion_of(time, np.sin(time)), "test")
    assert chain.touched(np.zeros(2000, dtype=bool)).max() == 0.0
    np.testing.assert_allclose(chain.touched(np.ones(2000, dtype=bool)), 1.0)


def test_blocks_follow_time_and_repetitions() -> None:
    time = np.arange(10000) / 250.0
    free = motion_of(time, np.sin(time) + np.sin(np.sqrt(2.0) * time))
    chain = make_chain(free, "test")
    blocks = cut_blocks(chain, chain.rows(free.position), "test")
    assert blocks.count == blocks.groups == 39
    assert np.all(np.diff(blocks.row) >= 0)
    masks = blocks.folds
    assert np.sum(masks, axis=0).tolist() == [1] * blocks.count
    again = motion_of(time, np.sin(2.0 * np.pi * time / 5.0) + 0.3 * np.sin(4.0 * np.pi * time / 5.0))
    chain = make_chain(again, "test")
    repeated = cut_blocks(chain, chain.rows(again.position), "test")
    assert repeated.groups == 8
    # The same stretch of every repetition is left out at once, so that held-out motion has not been seen.
    phase = (chain.time - chain.time[0]) % 5.0
    for mask in repeated.folds:
        seen = set(np.round(phase[mask[repeated.row]]))
        assert len(seen) <= 3


def test_what_is_left_out_of_a_short_cycle_is_never_a_whole_way() -> None:
    """A slide goes to and fro in 4.1 s, with a rest at each end, and is fast on the way back.  If that way were left
    out whole, what remains would not tell friction from weight.
    """
    period, back = 4.1, (2.75, 4.0)
    corners = [0.0, 0.1, 2.65, *back, period]
    time = np.arange(20000) / 250.0
    motion = motion_of(time, np.interp(time % period, corners, [0.0, 0.0, 1.0, 1.0, 0.0, 0.0]))
    chain = make_chain(motion, "test")
    blocks = cut_blocks(chain, chain.rows(motion.position), "test")
    assert blocks.period == pytest.approx(period, abs=0.03)
    phase = chain.time % period
    coming = (phase > back[0]) & (phase < back[1])
    for mask in blocks.folds:
        assert np.mean(~mask[blocks.row[coming]]) > 0.25


def test_many_repetitions_are_grouped_and_their_products_are_those_of_their_rows() -> None:
    """However long a robot goes through one cycle, its log is a few dozen blocks, each a stretch of several cycles."""
    period, time = 4.0, np.arange(100 * 1000) / 250.0
    motion = motion_of(time, np.sin(2.0 * np.pi * time / period) + 0.3 * np.sin(4.0 * np.pi * time / period))
    chain = make_chain(motion, "test")
    blocks = cut_blocks(chain, chain.rows(motion.position), "test")
    assert (blocks.groups, blocks.period) == (30, pytest.approx(period, abs=0.03))
    assert blocks.count <= 31 * 6
    assert np.any(np.diff(blocks.row) < 0)
    values = np.random.default_rng(3).normal(size=(blocks.row.size, 2))
    rows = Rows(values[:, :1], np.ones((blocks.row.size, 1)), blocks.row)
    for block in (0, 7, blocks.count - 1):
        own = values[blocks.row == block]
        np.testing.assert_allclose(rows.products(values, values)[block], own.T @ own)
    for first, past in rows.runs:
        assert np.ptp(blocks.row[first:past]) == 0


def test_too_short_a_motion_is_refused() -> None:
    time = np.arange(900) / 250.0
    motion = motion_of(time, np.sin(time))
    chain = make_chain(motion, "run.csv")
    with pytest.raises(LogError, match=r"run.csv: 3\.\d s of usable motion are too short; at least 4 s"):
        cut_blocks(chain, chain.rows(motion.position), "run.csv")


@pytest.mark.parametrize("sensor", [EffortSensor(), EffortSensor(delay=0.013), EffortSensor(bandwidth=4.0)])
def test_rows_made_part_by_part_are_the_rows(sensor: EffortSensor, monkeypatch: pytest.MonkeyPatch) -> None:
    columns = record(Machine(), 3, 30.0)
    columns["segment"] = (columns["time"] > 11.0).astype(np.int64)
    log = log_from_table(pa.table(columns), "log")
    robot = read_robot("ur5")
    for joint in robot.table.joint:
        robot = robot.with_joint(joint.model_copy(update={"effort_sensor": sensor}))
    gap = measure_gap(log, robot)
    torques = np.random.default_rng(0).normal(size=(gap.motion.time.size, 6, 2))
    whole = {joint: gap.reported(joint, torques[:, joint]) for joint in gap.examined}
    monkeypatch.setattr(rows, "MOST_ROWS", 100)
    parts = gap.rows_of(lambda own: torques[own])
    assert sum(1 for _ in gap.chain.parts(gap.motion, 10)) > 4
    for joint, values in parts.items():
        np.testing.assert_allclose(values, whole[joint], atol=1e-6 * np.max(np.abs(whole[joint])))
