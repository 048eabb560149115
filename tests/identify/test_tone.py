"""A steady tone is told from what the motion brings about."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from mjfriction.identify.gap import Gap, measure_gap
from mjfriction.identify.tone import steady_tone
from mjfriction.record.readers import read_log
from mjfriction.robot.files import read_robot
from tests.hidden.machine import Machine, write_case

ELBOW = 2


def gap_of_machine(folder: Path, machine: Machine) -> Gap:
    log, robot = write_case(folder, machine, seed=1, seconds=30.0)
    return measure_gap(read_log(log), read_robot(robot))


@pytest.mark.parametrize("frequency", [0.83, 2.417, 4.74])
def test_a_tone_is_found_with_its_frequency_and_share(frequency: float, tmp_path: Path) -> None:
    hum = Machine(hidden={ELBOW: lambda i: 5.0 * np.sin(2.0 * np.pi * frequency * i.time + 0.4)})
    gap = gap_of_machine(tmp_path, hum)
    tone = steady_tone(gap, ELBOW, gap.residual[:, ELBOW])
    assert tone is not None
    assert tone.frequency == pytest.approx(frequency, abs=2e-3)
    left = gap.rms(gap.residual[:, ELBOW], ELBOW) ** 2
    assert tone.share == pytest.approx(1.0 - gap.noise_floor[ELBOW] ** 2 / left, abs=0.05)


def test_noise_holds_next_to_no_tone_and_motion_none(tmp_path: Path) -> None:
    gap = gap_of_machine(tmp_path, Machine())
    noise = steady_tone(gap, ELBOW, gap.residual[:, ELBOW])
    assert noise is not None
    assert noise.share < 0.05
    assert steady_tone(gap, ELBOW, gap.at_rows("velocity")[:, ELBOW]) is None


def test_a_log_that_is_mostly_gaps_tells_no_tone(tmp_path: Path) -> None:
    gap = gap_of_machine(tmp_path, Machine(hidden={ELBOW: lambda i: 5.0 * np.sin(9.0 * i.time)}))
    time = gap.chain.time.copy()
    time[time.size // 2 :] += 1e8  # three years
    apart = replace(gap, chain=replace(gap.chain, time=time))
    assert steady_tone(gap, ELBOW, gap.residual[:, ELBOW]) is not None
    assert steady_tone(apart, ELBOW, apart.residual[:, ELBOW]) is None
