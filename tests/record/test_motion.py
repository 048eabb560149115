"""Motion estimated from positions, against motion known in closed form."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.signal import lfilter

from mjfriction.errors import LogError
from mjfriction.record.log import Log
from mjfriction.record.motion import back_to_log, estimate_motion
from mjfriction.record.noise import noise_level
from mjfriction.record.recorded_velocity import velocity_ratio
from mjfriction.record.resample import read_clock


def log_of(time: np.ndarray, position: np.ndarray, segment: np.ndarray | None = None, **more: np.ndarray) -> Log:
    segment = np.zeros(time.size, dtype=np.int64) if segment is None else segment
    columns = {"position.a": position, "effort.a": np.zeros(time.size)} | {f"{k}.a": v for k, v in more.items()}
    return Log("test", time, segment, ("a",), columns)


def sine(time: np.ndarray, frequency: float = 0.7) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    w = 2.0 * np.pi * frequency
    return np.sin(w * time + 0.3), w * np.cos(w * time + 0.3), -w * w * np.sin(w * time + 0.3)


@pytest.mark.parametrize("rate", [125.0, 1000.0])
def test_derivatives_of_a_sine_have_no_lag_and_no_gain(rate: float) -> None:
    time = np.arange(int(10 * rate)) / rate
    q, v, a = sine(time)
    motion = estimate_motion(log_of(time, q), ["a"], 20.0)
    inside = motion.settled
    np.testing.assert_allclose(motion.velocity[inside, 0], v[inside], atol=1e-3 * np.abs(v).max())
    np.testing.assert_allclose(motion.acceleration[inside, 0], a[inside], atol=2e-3 * np.abs(a).max())


def test_a_log_that_starts_in_full_motion_is_right_from_its_first_sample() -> None:
    # Reflecting the signal at its ends would make the acceleration there zero.
    time = np.arange(2000) / 1000.0
    q, v, a = sine(time + 0.2)
    motion = estimate_motion(log_of(time, q), ["a"], 40.0)
    np.testing.assert_allclose(motion.velocity[:, 0], v, atol=0.02 * np.abs(v).max())
    np.testing.assert_allclose(motion.acceleration[[0, -1], 0], a[[0, -1]], atol=0.02 * np.abs(a).max())


def test_nothing_leaks_across_segments_and_gaps() -> None:
    rate = 200.0
    time = np.arange(1200) / rate
    q, v, _ = sine(time)
    step = np.where(np.arange(1200) < 600, 0.0, 50.0)
    segment = np.repeat([1, 2], 600)
    motion = estimate_motion(log_of(time, q + step, segment), ["a"], 20.0)
    assert np.abs(motion.velocity).max() < 1.1 * np.abs(v).max()
    late = time + np.where(np.arange(1200) < 600, 0.0, 3.0)
    gap = estimate_motion(log_of(late, q + step), ["a"], 20.0)
    assert gap.clock.gaps == ((599, 600),)
    np.testing.assert_allclose(gap.velocity, motion.velocity, rtol=1e-9, atol=1e-9)


def test_a_jittering_clock_is_evened_out() -> None:
    rng = np.random.default_rng(0)
    time = np.cumsum(np.full(2000, 0.005) * rng.uniform(0.8, 1.2, 2000))
    q, v, _ = sine(time)
    log = log_of(time, q)
    motion = estimate_motion(log, ["a"], 20.0)
    back = back_to_log(motion, log, motion.velocity[:, 0])
    np.testing.assert_allclose(back[50:-50], v[50:-50], atol=5e-3 * np.abs(v).max())


def test_a_hopeless_clock_is_refused_by_name() -> None:
    rng = np.random.default_rng(0)
    time = np.cumsum(rng.choice([0.001, 0.001, 0.0035], 500))
    with pytest.raises(LogError, match=r"sampling is too irregular to differentiate: steps spread by \d+ %"):
        read_clock(log_of(time, np.sin(time)))
    split = np.arange(100, dtype=np.int64)
    with pytest.raises(LogError, match="every row is a segment of its own"):
        read_clock(log_of(np.arange(100.0), np.zeros(100), split))
    short = np.repeat(np.arange(10), 20)
    with pytest.raises(LogError, match="no stretch of 60 samples without a gap"):
        estimate_motion(log_of(np.arange(200) * 0.01, np.zeros(200), short), ["a"], 10.0)


@pytest.mark.parametrize("even", [True, False])
def test_velocities_are_compared_on_a_clock_that_is_one(even: bool) -> None:
    steps = np.full(2000, 0.002) if even else np.random.default_rng(0).choice([0.001, 0.001, 0.0035], 2000)
    time = np.cumsum(steps)
    q, v, _ = sine(time)
    ratio = velocity_ratio(log_of(time, q, velocity=2.0 * v), "a", 20.0)
    assert ratio == (pytest.approx(2.0, rel=0.01) if even else None)


@settings(max_examples=20, deadline=None)
@given(level=st.floats(1e-7, 1e-2), seed=st.integers(0, 1000))
def test_noise_is_told_from_motion(level: float, seed: int) -> None:
    time = np.arange(4000) / 250.0
    noisy = sine(time)[0] + level * np.random.default_rng(seed).normal(size=time.size)
    assert noise_level([noisy]) == pytest.approx(level, rel=0.1)


def test_the_quieter_source_of_velocity_is_taken_unless_it_disagrees() -> None:
    rng = np.random.default_rng(1)
    time = np.arange(5000) / 250.0
    q, v, _ = sine(time)
    rough = q + 1e-3 * rng.normal(size=time.size)
    alone = estimate_motion(log_of(time, rough), ["a"], 20.0)
    clean = estimate_motion(log_of(time, rough, velocity=v), ["a"], 20.0)
    inside = alone.settled
    error = [np.sqrt(np.mean((m.velocity[inside, 0] - v[inside]) ** 2)) for m in (alone, clean)]
    assert error[1] < 0.1 * error[0]
    assert error[0] == pytest.approx(alone.velocity_noise[0], rel=0.2)
    # One that comes late, and so noisily that most of its acceleration is noise, looks almost as if it did not.
    late = np.interp(time - 0.012, time, v) + 1e-3 * rng.normal(size=time.size)
    for lying in (1.2 * v, late):
        taken = estimate_motion(log_of(time, rough, velocity=lying), ["a"], 20.0)
        np.testing.assert_array_equal(taken.velocity, alone.velocity)


@pytest.mark.parametrize("rate", [125.0, 1000.0])
def test_a_velocity_made_of_the_coarse_position_is_no_quieter_than_that(rate: float) -> None:
    time = np.arange(20.0 * rate) / rate
    coarse = np.round(sine(time)[0] / 1e-4) * 1e-4
    share = -np.expm1(-2.0 * np.pi * 30.0 / rate)
    smoothed = lfilter([share], [1.0, share - 1.0], np.gradient(coarse) * rate)
    alone = estimate_motion(log_of(time, coarse), ["a"], 20.0)
    beside = estimate_motion(log_of(time, coarse, velocity=smoothed), ["a"], 20.0)
    np.testing.assert_array_equal(beside.velocity, alone.velocity)
    np.testing.assert_array_equal(beside.velocity_noise, alone.velocity_noise)
    # Of a sensor of its own, as noisy and as smooth, that is not said.
    another = sine(time)[0] + 1e-4 / np.sqrt(12.0) * np.random.default_rng(1).normal(size=time.size)
    of_its_own = lfilter([share], [1.0, share - 1.0], np.gradient(another) * rate)
    taken = estimate_motion(log_of(time, coarse, velocity=of_its_own), ["a"], 20.0)
    assert np.any(taken.velocity != alone.velocity)


@pytest.mark.parametrize("late", [-0.002, 0.0, 0.003])
def test_a_velocity_that_a_drive_has_filtered_is_put_to_its_own_time(late: float) -> None:
    rng = np.random.default_rng(1)
    time = np.arange(5000) / 250.0
    q, v, _ = sine(time)
    rough = q + 1e-3 * rng.normal(size=time.size)
    motion = estimate_motion(log_of(time, rough, velocity=sine(time - late)[1]), ["a"], 20.0)
    apart = (motion.velocity[:, 0] - v)[motion.settled]
    # By its lateness alone it would be off by |q̈|·late.
    assert np.sqrt(np.mean(np.square(apart))) < 2e-3 * np.std(v)


def test_current_and_effort_are_told_apart() -> None:
    time = np.arange(300) * 0.01
    log = Log("test", time, np.zeros(300, dtype=np.int64), ("a",), {"position.a": np.sin(time), "current.a": time})
    motion = estimate_motion(log, ["a"], 10.0)
    assert motion.quantity == ("current",)
    np.testing.assert_allclose(motion.torque[:, 0], time)


def test_a_joint_that_stops_does_not_seem_to_turn_back(monkeypatch: pytest.MonkeyPatch) -> None:
    # The velocity falls evenly to zero and stays there; the filter rings past it.
    time = np.arange(4000) / 1000.0
    v = np.where(time < 2.0, 2.0 - time, 0.0)
    motion = estimate_motion(log_of(time, np.cumsum(v) / 1000.0), ["a"], 20.0)
    turned = motion.velocity[:, 0] < -motion.sure_speed[:, 0]
    assert not np.any(turned[motion.settled])
    monkeypatch.setattr("mjfriction.record.motion.RINGING", 0.0)
    without = replace(motion)
    assert np.any((without.velocity[:, 0] < -without.sure_speed[:, 0])[motion.settled])


def test_values_beside_one_another_are_differentiated_piece_by_piece() -> None:
    motion = estimate_motion(
        log_of(np.arange(1200) / 200.0, np.repeat([0.0, 50.0], 600), np.repeat([1, 2], 600)), ("a",), 20.0
    )
    values = np.random.default_rng(0).normal(size=(motion.time.size, 3))
    change = motion.differentiated(values)
    assert len(motion.pieces) == 2
    for own in motion.pieces:
        expected = np.gradient(values[own], axis=0) * motion.rate
        np.testing.assert_allclose(change[own], expected, rtol=1e-12, atol=1e-12 * motion.rate)
    np.testing.assert_array_equal(motion.differentiated(values[:, 1]), change[:, 1])
