"""Motions stay within what they were given, and show what they are for."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pyarrow.parquet
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mjfriction.errors import LogError
from mjfriction.plant.motions import excitation, forward_backward, pick_and_place, sawtooth, sine, trapezoid
from mjfriction.plant.trajectory import read_trajectory


@settings(max_examples=15)
@given(seed=st.integers(0, 10**6), reach=st.floats(0.1, 1.5), speed=st.floats(0.1, 3.0))
def test_an_excitation_keeps_its_limits_and_begins_and_ends_at_rest(seed: int, reach: float, speed: float) -> None:
    centre = np.array([0.3, -1.0])
    made = excitation(("a", "b"), centre, np.full(2, reach), np.full(2, speed), 20.0, seed=seed)
    assert np.all(np.abs(made.position - centre) <= reach * (1.0 + 1e-9))
    _, velocity, _ = made.at(made.time)
    assert np.max(np.abs(velocity)) <= speed * 1.01
    np.testing.assert_allclose(made.position[[0, -1]], [centre, centre], atol=1e-9)
    assert np.max(np.abs(velocity[[0, -1]])) < 1e-9


def test_every_speed_has_its_phase_in_both_directions() -> None:
    speeds = (0.05, 0.2, 0.8)
    made = forward_backward("a", 0.1, 1.2, speeds, 4.0)
    _, velocity, _ = made.at(made.time)
    for speed in speeds:
        for sign in (1.0, -1.0):
            steady = np.abs(velocity[:, 0] - sign * speed) < 1e-3 * speed
            expected = 1.2 / speed - speed / 4.0
            assert np.count_nonzero(steady) / 250.0 == pytest.approx(expected, rel=0.05)


def test_a_degenerate_trapezoid_is_refused_with_the_speed_that_would_do() -> None:
    with pytest.raises(LogError, match=r"joint 'a': at 3 the trapezoid degenerates .* below 2.191"):
        forward_backward("a", 0.0, 1.2, (0.1, 3.0), 4.0)


@given(stroke=st.floats(0.05, 5.0), speed=st.floats(0.05, 5.0), acceleration=st.floats(0.1, 20.0))
def test_a_trapezoid_covers_its_stroke(stroke: float, speed: float, acceleration: float) -> None:
    place = trapezoid(stroke, speed, acceleration)
    assert place[-1] == pytest.approx(stroke)
    steps = np.diff(place, prepend=0.0)
    assert np.all(steps >= -1e-12 * stroke)
    assert np.all(steps <= speed / 250.0 * (1.0 + 1e-6))


def test_a_sawtooth_turns_at_its_amplitudes_at_one_speed() -> None:
    made = sawtooth("a", 0.5, (0.3, 0.1), 0.05)
    assert np.max(made.position) == pytest.approx(0.8, abs=1e-3)
    assert np.min(made.position) == pytest.approx(0.2, abs=1e-3)
    speed = np.abs(np.diff(made.position[:, 0])) * 250.0
    assert np.quantile(speed, 0.1) == pytest.approx(0.05, rel=1e-6)


def test_a_sine_swings_and_pick_and_place_visits_its_poses() -> None:
    swing = sine("a", 1.0, 0.2, 0.5, 6.0)
    assert np.ptp(swing.position) == pytest.approx(0.4, rel=1e-3)
    poses = np.array([[0.0, 0.0], [1.0, -0.5], [0.5, 0.5]])
    made = pick_and_place(("a", "b"), poses, np.full(2, 1.0), np.full(2, 3.0), rounds=2)
    for pose in poses:
        assert np.min(np.linalg.norm(made.position - pose, axis=1)) < 1e-6
    _, velocity, acceleration = made.at(made.time)
    assert np.max(np.abs(velocity)) < 1.02
    assert np.max(np.abs(acceleration)) < 3.3


def test_a_trajectory_is_read_back_as_it_was_written(tmp_path: Path) -> None:
    made = sine("a", 1.0, 0.2, 0.5, 4.0)
    path = tmp_path / "swing.parquet"
    pyarrow.parquet.write_table(made.table(), path)
    again = read_trajectory(path)
    assert again.joints == ("a",)
    np.testing.assert_array_equal(again.position, made.position)
    (tmp_path / "bad.csv").write_text("time,position.a\n0,0\n1,0\n1,0\n2,0\n")
    with pytest.raises(LogError, match="whose time increases"):
        read_trajectory(tmp_path / "bad.csv")
    (tmp_path / "none.csv").write_text("time,a\n0,0\n1,0\n")
    with pytest.raises(LogError, match="a trajectory has 'time' and 'position"):
        read_trajectory(tmp_path / "none.csv")
