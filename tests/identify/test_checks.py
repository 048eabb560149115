"""What a fit says besides its numbers: motion that cannot tell a parameter, and what to record instead."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pyarrow as pa
import pytest

from mjfriction.identify.identification import identify_log
from mjfriction.identify.outcome import Identification
from mjfriction.plant.machine import simulate
from mjfriction.plant.sensors import Recorder
from mjfriction.plant.trajectory import Trajectory
from mjfriction.record.readers.table import log_from_table
from tests.deep import deep
from tests.identify.test_elements import robot_with

TIME = np.linspace(0.0, 16.0, 321)
STRIBECK = "coulomb = 1.5, static = 2.0, stribeck_velocity = 0.1, stribeck_exponent = 1.0, viscous = 0.5"


def identified(folder: Path, position: np.ndarray, law: str | None) -> Identification:
    columns = simulate(
        robot_with(folder, "stribeck", STRIBECK),
        Trajectory(("hinge",), TIME, position[:, None]),
        recorder=Recorder(250.0),
        seed=1,
    )
    stated = robot_with(folder, "coulomb_viscous", "coulomb = 1.0, viscous = 1.0")
    return identify_log(log_from_table(pa.table(columns), "log"), stated, law=law)


def remarks(folder: Path, position: np.ndarray, law: str) -> dict[str, str]:
    found = identified(folder, position, law)
    return {fitted.name: fitted.note for fitted in found.laws[0].parameters}


def test_one_direction_does_not_tell_a_level_from_the_zero(tmp_path: Path) -> None:
    onward = 0.4 * TIME + 0.27 * np.sin(TIME)
    assert "record both directions" in remarks(tmp_path, onward, "coulomb_viscous")["coulomb"]
    to_and_fro = 0.4 * np.sin(TIME)
    assert "directions" not in remarks(tmp_path, to_and_fro, "coulomb_viscous")["coulomb"]


@pytest.mark.deep
def test_slow_motion_does_not_tell_what_lies_beyond_the_fall(tmp_path: Path) -> None:
    slow = remarks(tmp_path, 0.05 * np.sin(0.5 * TIME), "stribeck")
    assert "record faster motion" in slow["viscous"]
    fast = remarks(tmp_path, 0.8 * np.sin(TIME), "stribeck")
    assert "record faster motion" not in fast["viscous"]


@pytest.mark.deep
@pytest.mark.parametrize(
    ("law", "stroke"),
    [
        *((None, 0.04), ("stribeck", 0.15)),
        *((law, 0.04) for law in ("coulomb_viscous", "stribeck", "arctan")),
        *((law, 0.15) for law in (None, "coulomb_viscous", "arctan")),
    ],
)
def test_a_log_that_never_leaves_the_stribeck_range_says_so_whatever_the_law(
    law: str | None, stroke: float, tmp_path: Path
) -> None:
    # A law with no falling part, or one whose fall ends at once, would find a level of 1.9 in a machine of 1.5.
    found = identified(tmp_path, stroke * np.sin(0.8 * TIME), law)
    (own,) = found.laws
    assert own.falls
    assert not own.trusted
    assert all(fitted.note for fitted in own.parameters)
    assert "record faster motion" in found.summary


@pytest.mark.parametrize("law", ["stribeck", deep(None)])
def test_a_log_that_is_fast_enough_says_nothing(law: str | None, tmp_path: Path) -> None:
    found = identified(tmp_path, 0.8 * np.sin(TIME), law)
    assert not found.laws[0].falls
    assert "faster" not in found.summary
