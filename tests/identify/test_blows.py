"""Blows: what rotor and link exchange in a moment is kept out of the balance, and nothing else is."""

from __future__ import annotations

import numpy as np
import pyarrow as pa
import pytest

from mjfriction.identify.gap import Gap
from mjfriction.identify.measure import measure_gap
from mjfriction.plant.motions import trapezoid
from mjfriction.record.readers.table import log_from_table
from mjfriction.robot.files import read_robot

RATE = 250.0


def gap_along(position: np.ndarray) -> Gap:
    time = np.arange(position.size) / RATE
    columns = {"time": time, "position.axis": position, "effort.axis": np.sin(time)}
    return measure_gap(log_from_table(pa.table(columns), "made"), read_robot("linear_axis"))


def spoilt(gap: Gap) -> np.ndarray:
    return gap.chain.time[gap.doubt[:, 0] > 1e3 * np.median(gap.doubt[:, 0] + 1e-9)]


def swing(seconds: float = 30.0) -> np.ndarray:
    time = np.arange(0.0, seconds, 1.0 / RATE)
    rng = np.random.default_rng(1)
    return 0.2 * np.sin(2.0 * np.pi * 0.2 * time) + 1e-6 * rng.standard_normal(time.size)


def test_a_step_of_velocity_while_the_joint_moves_is_a_blow() -> None:
    course = swing()
    at = np.argmin(np.abs(np.arange(course.size) / RATE - 10.2))  # in mid-stroke
    course[at:] += 0.05 * (np.arange(course.size - at) / RATE) * np.exp(-np.arange(course.size - at) / RATE / 0.3)
    found = spoilt(gap_along(course))
    assert found.size > 0
    assert found == pytest.approx(10.2, abs=0.3)
    assert spoilt(gap_along(swing())).size == 0


def test_a_motion_that_sets_out_and_stops_is_no_blow() -> None:
    stroke = trapezoid(0.3, 0.2, 2.0)
    rest = np.zeros(75)
    course = np.concatenate([rest, stroke, rest + stroke[-1], stroke[::-1], rest])
    noisy = np.tile(course, 4) + 1e-6 * np.random.default_rng(2).standard_normal(4 * course.size)
    assert spoilt(gap_along(noisy)).size == 0
