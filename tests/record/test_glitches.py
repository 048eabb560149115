"""Single wild samples are told from what a machine does in one or two samples."""

from __future__ import annotations

import numpy as np
import pyarrow as pa
import pytest

from mjfriction.record import glitches as glitches_
from mjfriction.record.glitches import felt, glitches
from mjfriction.record.readers.table import log_from_table


def test_the_rounding_of_a_simulation_is_no_glitch() -> None:
    rng = np.random.default_rng(1)
    held = 1e-16 * rng.normal(size=2000)
    held[700] = 1e-12
    assert not np.any(glitches(held))
    held[700] = 1e-3
    assert np.flatnonzero(glitches(held)).tolist() == [700]


def test_a_joint_that_is_pushed_back_at_once_has_no_glitch(monkeypatch: pytest.MonkeyPatch) -> None:
    # A measured velocity that nears zero for a moment, in a log in which the joint moves little else.
    velocity = np.concatenate([np.full(2500, -1e-4), np.linspace(-1e-4, 2.5e-4, 1500)])
    near = [-8.69, -6.70, -5.09, -3.80, -2.79, -2.01, -1.65, -2.78, -4.95, -7.50]
    velocity[1000:1010] = 1e-5 * np.array(near)
    velocity += 1e-9 * np.random.default_rng(0).normal(size=velocity.size)
    assert not np.any(glitches(velocity))
    wild = velocity.copy()
    wild[2000] += 2e-5
    assert np.flatnonzero(glitches(wild)).tolist() == [2000]
    monkeypatch.setattr(glitches_, "FORESEEN", 0.0)
    assert np.flatnonzero(glitches(velocity)).tolist() == [1005, 1006]


def test_two_opposite_glitches_around_one_good_sample_are_two() -> None:
    values = np.sin(np.linspace(0.0, 6.0, 2000)) + 1e-4 * np.random.default_rng(0).normal(size=2000)
    values[500] += 5.0
    values[502] -= 5.0
    assert np.flatnonzero(glitches(values)).tolist() == [500, 502]


STILL, WHOLE = np.linspace(0.0, 1.0, 5000), np.zeros(5000, dtype=np.int64)


@pytest.mark.parametrize("before", [False, True])
def test_a_blow_that_begins_or_dies_away_is_none(before: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    # What a drive gives as its speed is asked to jump: most of it within a sample, the rest beside it.
    effort = 4.0 * np.sin(np.linspace(0.0, 30.0, 5000)) + 0.05 * np.random.default_rng(2).normal(size=5000)
    blow = effort.copy()
    blow[2000] -= 30.0
    wild = np.arange(5000) == 2000
    np.testing.assert_array_equal(glitches(blow), wild)
    assert not np.any(felt(wild, blow, STILL, WHOLE))
    beside = 1999 if before else 2001
    blow[beside] -= 2.0
    np.testing.assert_array_equal(glitches(blow), wild)
    assert felt(wild, blow, STILL, WHOLE)[2000]
    # What was recorded after a break says nothing of it.
    assert not np.any(felt(wild, blow, STILL, np.cumsum(np.arange(5000) == (2000 if before else 2001))))
    monkeypatch.setattr(glitches_, "TOUCHED", np.inf)
    assert not np.any(felt(wild, blow, STILL, WHOLE))


@pytest.mark.parametrize("by", ["neighbours", "speed"])
def test_noise_and_coarse_counts_are_hardly_ever_a_blow(by: str, monkeypatch: pytest.MonkeyPatch) -> None:
    count, blows, told = 6000, 0, 0
    position = np.round(np.cumsum(np.full(count, 0.0001)) / 0.003) * 0.003
    monkeypatch.setattr(glitches_, "_answered" if by == "neighbours" else "_touches", lambda *_: False)
    for seed in range(8):
        effort = 0.05 * np.random.default_rng(seed).normal(size=count)
        wild = np.isin(np.arange(count), np.arange(100, count - 100, 211))
        effort[wild] += 4.0
        np.testing.assert_array_equal(glitches(effort), wild)
        blows += np.count_nonzero(wild)
        told += np.count_nonzero(felt(wild, effort, position, np.zeros(count, dtype=np.int64)))
    assert told < (0.05 if by == "neighbours" else 0.01) * blows


def test_a_wild_sample_is_known_where_friction_turns_over() -> None:
    # The sample beside it stands as far from a straight course as the turn makes it.
    effort = 0.05 * np.random.default_rng(2).normal(size=5000) + np.where(np.arange(5000) < 2001, -1.0, 1.0)
    effort[2000] = 120.0
    assert np.flatnonzero(glitches(effort)).tolist() == [2000]
    assert not np.any(felt(glitches(effort), effort, STILL, WHOLE))


@pytest.mark.parametrize("rate", [100.0, 250.0, 500.0])
def test_a_wild_sample_at_the_corner_of_a_move_is_known(rate: float) -> None:
    # Rest, 2 rad/s² up to speed, cruise, down to rest: a trapezoid's corners are no jumps of speed.
    time = np.arange(0.0, 6.0, 1.0 / rate)
    speed = np.clip(2.0 * np.minimum(time - 1.0, 5.0 - time), 0.0, 1.0)
    position = np.round(np.cumsum(speed) / rate / 1e-5) * 1e-5
    noise = 0.02 * np.random.default_rng(3).normal(size=time.size)
    for corner in (1.0, 1.5, 4.5, 5.0):
        for at in np.arange(-3, 4) + round(corner * rate):
            effort = 0.5 * np.sign(speed) + noise
            effort[at] += 40.0
            wild = np.arange(time.size) == at
            assert not np.any(felt(wild, effort, position, np.zeros(time.size, dtype=np.int64))), (corner, at)


def test_a_blow_that_the_joint_answers_to_is_none() -> None:
    # A drive is asked for a jump of its speed: within a sample or two it gives what that takes.
    rng, count = np.random.default_rng(4), 4000
    speed = np.where(np.arange(count) < 2000, 0.3, 0.12)
    position = np.round(np.cumsum(0.002 * speed) / 2e-5) * 2e-5
    effort = 2.0 * np.sign(speed) + 0.02 * rng.normal(size=count)
    for at in (1000, 2000):
        effort[at] -= 15.0
    wild, piece = glitches(effort), np.zeros(count, dtype=np.int64)
    assert np.flatnonzero(wild).tolist() == [1000, 2000]
    assert np.flatnonzero(felt(wild, effort, position, piece)).tolist() == [2000]
    # What stands where another recording begins tells of none.
    assert not np.any(felt(wild, effort, position, np.where(np.arange(count) < 2005, 0, 1)))
    columns = {"time": 0.002 * np.arange(count), "position.hinge": position, "effort.hinge": effort}
    (fault,) = log_from_table(pa.table(columns), "log").faults
    assert (fault.kind, fault.where) == ("data.glitch", "effort.hinge, 2 s")


@pytest.mark.parametrize("moved", [True, False])
def test_a_speed_that_the_joint_had_is_no_wild_reading_of_it(moved: bool) -> None:
    rate, count = 125.0, 4000
    velocity = 0.4 * np.sin(np.arange(count) / 300.0)
    jolt = np.where(np.arange(count) == 2100, 0.3, 0.0)
    position = np.cumsum(velocity + moved * jolt) / rate
    noise = 1e-4 * np.random.default_rng(4).normal(size=count)
    columns = {"time": np.arange(count) / rate, "position.a": position, "velocity.a": velocity + jolt + noise}
    log = log_from_table(pa.table(columns | {"effort.a": np.sign(velocity)}), "log")
    assert [fault.kind for fault in log.faults] == ([] if moved else ["data.glitch"])
