"""Levels that are off are told beside what bends friction near rest, or makes the directions differ, where neither can
stand for them.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from mjfriction.diagnose.diagnosis import diagnose_log
from mjfriction.diagnose.settle import stated
from mjfriction.record.readers import read_log
from mjfriction.robot.files import read_robot
from tests.hidden.machine import UR5_COULOMB, UR5_VISCOUS, Effect, Instant, Machine, write_case

ELBOW = 2
EXCESS, HIGHER, STRIBECK_VELOCITY = 0.8 * UR5_COULOMB[ELBOW], 0.6 * UR5_COULOMB[ELBOW], 0.06


def sticky(at: Instant) -> np.ndarray:
    return EXCESS * np.exp(-np.abs(at.v) / STRIBECK_VELOCITY) * np.sign(at.v)


def worn(at: Instant) -> np.ndarray:
    place = (at.q - np.min(at.q) - 0.35 * np.ptp(at.q)) / (0.04 * np.ptp(at.q))
    return 2.0 * HIGHER * np.exp(-0.5 * np.square(place)) * np.sign(at.v)


def one_way_and_higher(at: Instant) -> np.ndarray:
    return 0.4 * UR5_VISCOUS[ELBOW] * np.abs(at.v) + HIGHER * np.sign(at.v)


@pytest.mark.deep
@pytest.mark.parametrize(
    ("bend", "cause"),
    [(sticky, "friction.stribeck"), (worn, "friction.position")],
)
def test_they_are_told_beside_it(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, bend: Effect, cause: str) -> None:
    def found(higher: float) -> set[str]:
        machine = Machine(hidden={ELBOW: lambda at: bend(at) + higher * np.sign(at.v)}, noise=0.1)
        log, robot = write_case(tmp_path, machine, seed=4)
        findings = diagnose_log(read_log(log), read_robot(robot)).findings
        return {finding.cause for finding in findings}

    assert found(HIGHER) == {cause, "friction.coulomb_viscous"}
    assert found(0.0) == {cause}
    monkeypatch.setattr(stated, "_off_beyond_a_bend", lambda *_: False)
    assert found(HIGHER) == {cause}


@pytest.mark.deep
def test_they_are_told_beside_directions_that_differ(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    log, robot = write_case(tmp_path, Machine(hidden={ELBOW: one_way_and_higher}, noise=0.1), seed=4)

    def found() -> set[str]:
        return {finding.cause for finding in diagnose_log(read_log(log), read_robot(robot)).findings}

    assert found() == {"friction.asymmetry", "friction.coulomb_viscous"}
    monkeypatch.setattr(stated, "WITH_LEVELS", stated.WITH_LEVELS | {"friction.asymmetry"})
    assert found() == {"friction.asymmetry"}


def one_way(at: Instant) -> np.ndarray:
    return 1.2 * UR5_VISCOUS[ELBOW] * np.maximum(at.v, 0.0)


def rising(at: Instant) -> np.ndarray:
    along = (at.q - np.min(at.q)) / np.ptp(at.q)
    return 4.0 * UR5_COULOMB[ELBOW] * along * np.sign(at.v)


@pytest.mark.deep
@pytest.mark.parametrize(
    ("hidden", "cause", "rule"),
    [(one_way, "friction.asymmetry", "_of_one_direction"), (rising, "friction.position", "_rising")],
)
def test_levels_that_are_a_part_of_something_else_are_none_of_their_own(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, hidden: Effect, cause: str, rule: str
) -> None:
    # Damping that is off in one direction only, and friction that rises from one end of the stroke to the other.
    log, robot = write_case(tmp_path, Machine(hidden={ELBOW: hidden}, noise=0.1), seed=4, seconds=22.0)

    def found() -> set[str]:
        return {finding.cause for finding in diagnose_log(read_log(log), read_robot(robot)).findings}

    assert found() == {cause}
    monkeypatch.setattr(stated, rule, lambda *_: False)
    assert found() == {cause, "friction.coulomb_viscous"}
