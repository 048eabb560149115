"""When a load turns: as it goes through zero, or as it leaves one side and reaches the other."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from mjfriction.identify.measure import measure_gap
from mjfriction.record.load_turns import load_turns
from mjfriction.record.readers import read_log
from mjfriction.robot.files import read_robot
from tests.hidden.machine import Machine, write_case


@pytest.mark.parametrize("noise", [0.0, 0.008])
def test_a_load_that_rests_near_zero_turns_at_the_ends_of_its_rest(noise: float, tmp_path: Path) -> None:
    log, robot = write_case(tmp_path, Machine(), seed=5, seconds=20.0)
    motion = measure_gap(read_log(log), read_robot(robot)).motion
    time = motion.time - motion.time[0]
    # From one side to the other, with a rise of three thousandths per second over six seconds in between.
    load = np.clip(time - 5.0, -1.0, 0.0) + np.clip(time - 11.0, 0.0, 1.0) + 3e-3 * (time - 8.0)
    load = load + noise * np.sin(2.0 * np.pi * 0.7 * time)
    turns = load_turns(motion, load)
    near = turns.near(0.3)
    assert turns.count == 1
    assert near[np.argmin(np.abs(time - 5.0))]
    assert near[np.argmin(np.abs(time - 11.0))]
    assert not near[np.argmin(np.abs(time - 6.5))]
    # It goes through zero once, in the middle, unless noise takes it there and back.
    assert near[np.argmin(np.abs(time - 8.0))] == (noise == 0.0)
