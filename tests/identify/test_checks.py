"""What a fit says besides its numbers: motion that cannot tell a parameter, and what to record instead."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pyarrow as pa

from mjfriction.identify.identification import identify_log
from mjfriction.plant.machine import simulate
from mjfriction.plant.sensors import Recorder
from mjfriction.plant.trajectory import Trajectory
from mjfriction.record.readers.table import log_from_table
from tests.identify.test_elements import robot_with

TIME = np.linspace(0.0, 16.0, 321)
STRIBECK = "coulomb = 1.5, static = 2.0, stribeck_velocity = 0.1, stribeck_exponent = 1.0, viscous = 0.5"


def remarks(folder: Path, position: np.ndarray, law: str) -> dict[str, str]:
    columns = simulate(
        robot_with(folder, "stribeck", STRIBECK),
        Trajectory(("hinge",), TIME, position[:, None]),
        recorder=Recorder(250.0),
        seed=1,
    )
    stated = robot_with(folder, "coulomb_viscous", "coulomb = 1.0, viscous = 1.0")
    found = identify_log(log_from_table(pa.table(columns), "log"), stated, law=law)
    return {fitted.name: fitted.note for fitted in found.laws[0].parameters}


def test_one_direction_does_not_tell_a_level_from_the_zero(tmp_path: Path) -> None:
    onward = 0.4 * TIME + 0.27 * np.sin(TIME)
    assert "record both directions" in remarks(tmp_path, onward, "coulomb_viscous")["coulomb"]
    to_and_fro = 0.4 * np.sin(TIME)
    assert "directions" not in remarks(tmp_path, to_and_fro, "coulomb_viscous")["coulomb"]


def test_slow_motion_does_not_tell_what_lies_beyond_the_fall(tmp_path: Path) -> None:
    slow = remarks(tmp_path, 0.05 * np.sin(0.5 * TIME), "stribeck")
    assert "record faster motion" in slow["viscous"]
    fast = remarks(tmp_path, 0.8 * np.sin(TIME), "stribeck")
    assert "record faster motion" not in fast["viscous"]
