"""A steady tone is told from what the motion brings about."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pyarrow as pa
import pytest

from mjfriction.identify.gap import Gap
from mjfriction.identify.measure import measure_gap
from mjfriction.identify.tone import steady_tone
from mjfriction.record.readers import read_log
from mjfriction.record.readers.table import log_from_table
from mjfriction.robot.files import read_robot
from mjfriction.robot.predict import predict_log
from tests.hidden.machine import Machine, write_case

ELBOW = 2
SWING = 0.4  # Hz


def gap_of_machine(folder: Path, machine: Machine) -> Gap:
    log, robot = write_case(folder, machine, seed=1, seconds=30.0)
    return measure_gap(read_log(log), read_robot(robot))


@pytest.mark.parametrize("frequency", [0.83, 2.417, 4.74])
def test_a_tone_is_found_with_its_frequency_and_share(frequency: float, tmp_path: Path) -> None:
    hum = Machine(hidden={ELBOW: lambda i: 5.0 * np.sin(2.0 * np.pi * frequency * i.time + 0.4)})
    gap = gap_of_machine(tmp_path, hum)
    found = steady_tone(gap, ELBOW, gap.residual[:, ELBOW])
    assert found is not None
    tone, share = found
    assert tone.frequency == pytest.approx(frequency, abs=2e-3)
    left = gap.rms(gap.residual[:, ELBOW], ELBOW) ** 2
    assert share == pytest.approx(1.0 - gap.noise_floor[ELBOW] ** 2 / left, abs=0.05)


def test_noise_holds_next_to_no_tone_and_motion_none(tmp_path: Path) -> None:
    gap = gap_of_machine(tmp_path, Machine())
    noise = steady_tone(gap, ELBOW, gap.residual[:, ELBOW])
    assert noise is not None
    assert noise[1] < 0.05
    assert steady_tone(gap, ELBOW, gap.at_rows("velocity")[:, ELBOW]) is None


def test_a_log_that_is_mostly_gaps_tells_no_tone(tmp_path: Path) -> None:
    gap = gap_of_machine(tmp_path, Machine(hidden={ELBOW: lambda i: 5.0 * np.sin(9.0 * i.time)}))
    time = gap.chain.time.copy()
    time[time.size // 2 :] += 1e8  # three years
    apart = replace(gap, chain=replace(gap.chain, time=time))
    assert steady_tone(gap, ELBOW, gap.residual[:, ELBOW]) is not None
    assert steady_tone(apart, ELBOW, apart.residual[:, ELBOW]) is None


def swinging_gap(course: Callable[[np.ndarray], np.ndarray]) -> Gap:
    # An axis that swings at 0.4 Hz, with a course beside what its robot says.
    rate, seconds = 250.0, 60.0
    time = np.arange(0.0, seconds, 1.0 / rate)
    turn = 2.0 * np.pi * SWING * time
    robot = read_robot("linear_axis")
    noise = np.random.default_rng(1).normal(0.0, 0.5, time.size)
    table = {"time": time, "position.axis": 0.1 * np.sin(turn), "effort.axis": noise}
    said = predict_log(log_from_table(pa.table(table), "swings"), robot)["effort.axis"]
    log = log_from_table(pa.table({**table, "effort.axis": said + course(time) + noise}), "swings")
    return measure_gap(log, robot)


@pytest.mark.parametrize(
    ("overtone", "tone"),
    [
        (2.0, False),  # as what is the same on both sides of a swing makes
        (5.0, False),
        (5.37, True),
    ],
)
def test_an_overtone_of_motion_that_repeats_is_no_tone(overtone: float, tone: bool) -> None:
    gap = swinging_gap(lambda time: 20.0 * np.sin(2.0 * np.pi * overtone * SWING * time + 0.3))
    assert gap.blocks.period is not None
    assert gap.blocks.period * SWING == pytest.approx(round(gap.blocks.period * SWING), abs=0.02)
    assert (steady_tone(gap, 0, gap.residual[:, 0]) is not None) == tone


def test_twice_the_frequency_of_swings_that_repeat_too_seldom_is_no_tone() -> None:
    gap = swinging_gap(lambda time: 20.0 * np.sin(4.0 * np.pi * SWING * time + 0.3))
    seldom = replace(gap, blocks=replace(gap.blocks, period=None))
    assert steady_tone(seldom, 0, gap.residual[:, 0]) is None
    assert steady_tone(seldom, 0, swinging_gap(lambda time: 20.0 * np.sin(13.5 * time)).residual[:, 0]) is not None
