"""A drive that low-passes its efforts is known by the steps of friction that they lack; a joint that rests is none."""

from __future__ import annotations

import functools

import numpy as np
import pyarrow as pa
import pytest
from scipy.signal import lfilter

from mjfriction.identify import effort_band
from mjfriction.identify.measure import measure_gap
from mjfriction.plant.machine import simulate
from mjfriction.plant.motions import sine
from mjfriction.plant.sensors import Recorder
from mjfriction.record.log import Floats
from mjfriction.record.readers.table import log_from_table
from mjfriction.robot.files import read_robot
from mjfriction.robot.robot import Robot
from mjfriction.robot.rubbing import forward_share
from mjfriction.robot.schema import EffortSensor, PositionSensor
from tests.deep import deep

RATE, AXIS = 500.0, "axis"


@functools.cache
def machine() -> Robot:
    robot = read_robot("linear_axis")
    sensors = {
        "position_sensor": PositionSensor(resolution=1e-5, noise=2e-5),
        "effort_sensor": EffortSensor(noise=0.2),
    }
    return robot.with_joint(robot.joint(AXIS).model_copy(update=sensors))


@functools.cache
def recorded(stroke: float) -> dict[str, Floats]:
    # So slowly that friction holds the axis at both ends for a while.
    course = sine(AXIS, 0.2, 0.5 * stroke, 0.15, 8.0)
    return simulate(machine(), course, recorder=Recorder(RATE), seed=1)


def filtered(columns: dict[str, Floats]) -> float:
    return float(measure_gap(log_from_table(pa.table(columns), "log"), machine()).filtered[0])


@pytest.mark.parametrize("stroke", [0.05, deep(0.2)])
def test_a_drive_that_low_passes_strongly_is_known(stroke: float) -> None:
    columns, share = dict(recorded(stroke)), 1.0 - np.exp(-2.0 * np.pi / RATE)
    for _ in range(3):  # 1 Hz, three times
        columns[f"effort.{AXIS}"] = lfilter([share], [1.0, share - 1.0], columns[f"effort.{AXIS}"])
    assert 1.0 < filtered(columns) < 5.0


@pytest.mark.parametrize("stroke", [0.05, 0.2])
def test_friction_that_goes_over_while_a_joint_rests_is_no_filter(stroke: float) -> None:
    assert filtered(recorded(stroke)) == np.inf


def test_the_sensors_noise_at_rest_would_make_steps_that_no_effort_has(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(effort_band, "_sure_course", lambda motion, joint, _: forward_share(motion, joint))
    assert filtered(recorded(0.05)) < 15.0
