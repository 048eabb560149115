"""Friction that turns over smoothly with speed, while joints creep at their rests: nothing that a law is off by."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from mjfriction.diagnose.diagnosis import diagnose_log
from mjfriction.diagnose.tell.outcome import Verdict
from mjfriction.identify import measure
from mjfriction.identify.measure import measure_gap
from mjfriction.identify.turning import TURNED, turning_speeds
from mjfriction.record.readers import read_log
from mjfriction.record.reversals import travel_since_turn
from mjfriction.robot.files import read_robot
from tests.hidden.machine import Machine, write_case

CREEPS = Machine(turning=0.02, pauses=True, noise=0.1)
LEVEL, NOISE = 5.0, 0.5
ROWS, JOINTS = 3000, 4


def motion(seed: int) -> np.ndarray:
    """Return the speeds of joints that are fast and creep by turns, (rows, joints)."""
    rng = np.random.default_rng(seed)
    phase, time = rng.uniform(0.0, 6.0, JOINTS), np.arange(ROWS)[:, None] / 50.0
    return np.asarray(np.sin(0.9 * time + phase) ** 5 * np.sin(0.23 * time + 2.0 * phase))


def found(lost: np.ndarray, velocity: np.ndarray, rings: float = 0.0) -> np.ndarray:
    """Return the speeds found where ``lost`` (rows, joints), of the level and along the motion, differs from stated.

    The travel since a turn ``rings`` below nothing there, by so much of the longest, as a filter makes it.
    """
    residual = LEVEL * lost * np.sign(velocity) + NOISE * np.random.default_rng(1).standard_normal(velocity.shape)
    clear, top = np.ones(velocity.shape, dtype=bool), np.quantile(np.abs(velocity), 0.99, axis=0)
    travel = travel_of(velocity)
    travel = np.where(travel < 0.1 * np.max(travel), travel - rings * np.max(travel), travel)
    return turning_speeds(velocity, travel, residual, clear, np.full(JOINTS, LEVEL), top)


def travel_of(velocity: np.ndarray) -> np.ndarray:
    """Return how far joints are from where they last turned, (rows, joints)."""
    return travel_since_turn(velocity, np.cumsum(velocity, axis=0) / 50.0, [slice(None)])[0]


@pytest.mark.parametrize("share", [0.004, 0.01, 0.02])
def test_the_speed_over_which_friction_turns_is_found(share: float) -> None:
    velocity = motion(4)
    speeds = found(np.tanh(np.abs(velocity) / share) - 1.0, velocity)
    assert speeds == pytest.approx(TURNED * share, rel=0.3)
    np.testing.assert_array_equal(found(np.tanh(np.abs(velocity) / share) - 1.0, velocity, rings=0.3), speeds)


def test_levels_that_are_off_and_friction_that_fades_turn_at_once() -> None:
    velocity = motion(5)
    speed = np.abs(velocity)
    assert np.all(found(0.0 * speed, velocity) == 0.0)
    assert np.all(found(-0.2 + 0.3 * speed, velocity) == 0.0)
    assert np.all(found(0.5 * np.exp(-speed / 0.02), velocity) == 0.0)
    assert np.all(found(-0.15 * np.exp(-speed / 0.1), velocity) == 0.0)


def test_a_joint_that_shows_it_alone_is_doubted_alone_and_half_of_all_joints_speak_for_the_others() -> None:
    velocity = motion(6)
    lost = np.tanh(np.abs(velocity) / 0.01) - 1.0
    alone = found(lost * np.array([1.0, 0.0, 0.0, 0.0]), velocity)
    assert alone[0] == pytest.approx(TURNED * 0.01, rel=0.3)
    assert np.all(alone[1:] == 0.0)
    assert np.all(found(lost * np.array([1.0, 0.0, 1.0, 0.0]), velocity) > 0.0)


def test_one_long_creep_is_enough_where_nearly_all_error_in_slow_motion_goes() -> None:
    velocity = motion(6)
    still = (np.arange(ROWS) > 1000) & (np.arange(ROWS) < 1300)
    velocity[np.abs(velocity) < 0.08] = 0.0
    velocity[still, 0] = np.linspace(0.02, 0.004, np.sum(still))
    lost = (np.tanh(np.abs(velocity) / 0.01) - 1.0) * np.array([1.0, 0.0, 0.0, 0.0])
    assert found(lost, velocity)[0] == pytest.approx(TURNED * 0.01, rel=0.3)


def test_a_joint_that_is_fast_or_creeps_has_level_and_damping_near_what_is_stated() -> None:
    # With speeds of two kinds and nothing between, a lower level and more damping say the same as friction that turns.
    velocity = motion(6)
    velocity[np.abs(velocity) < 0.15] = 0.0
    creeping = (np.arange(ROWS) % 500) < 60
    velocity[creeping, 0] = np.where(np.arange(ROWS)[creeping] % 1000 < 500, 0.03, -0.04)
    velocity[~creeping, 0] = np.where(np.abs(velocity[~creeping, 0]) > 0.4, velocity[~creeping, 0], 0.0)
    lost = (np.tanh(np.abs(velocity) / 0.1) - 1.0) * np.array([1.0, 0.0, 0.0, 0.0])
    assert found(lost, velocity)[0] == pytest.approx(TURNED * 0.1, rel=0.4)


def test_beside_a_joint_that_surely_shows_it_one_visit_is_enough_for_another() -> None:
    velocity = motion(6)
    velocity[np.abs(velocity[:, 1]) < 0.08, 1] = 0.0
    still = (np.arange(ROWS) > 1000) & (np.arange(ROWS) < 1200)
    velocity[still, 1] = np.linspace(0.02, 0.004, np.sum(still))
    lost = np.tanh(np.abs(velocity) / 0.01) - 1.0
    uneven = 0.2 * np.repeat(np.random.default_rng(2).standard_normal(ROWS // 10), 10)
    lost[:, 1] += uneven * (np.abs(velocity[:, 1]) < 0.03)
    for shown, doubted in (([0.0, 1.0, 0.0, 0.0], False), ([1.0, 1.0, 0.0, 0.0], True)):
        assert bool(found(lost * np.array(shown), velocity)[1] > 0.0) is doubted


def test_friction_of_one_joint_that_builds_up_over_its_travel_is_for_the_diagnosis_to_tell() -> None:
    velocity = motion(6)
    lost = -np.exp(-travel_of(velocity) / 0.01)
    assert np.all(found(lost * np.array([1.0, 0.0, 0.0, 0.0]), velocity) == 0.0)


def test_an_arm_that_creeps_is_judged_where_its_friction_has_its_level(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    log, robot = write_case(tmp_path, CREEPS, seed=3)

    def worst() -> float:
        measured = measure_gap(read_log(log), read_robot(robot))
        return max(measured.rms(measured.residual[:, i], i) / measured.noise_floor[i] for i in measured.examined)

    assert worst() < 1.3
    monkeypatch.setattr(measure, "turning_speeds", lambda velocity, *_: np.zeros(velocity.shape[1]))
    assert worst() > 2.0


@pytest.mark.deep
def test_creeping_is_no_finding_and_leaves_nothing_open(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    log, robot = write_case(tmp_path, CREEPS, seed=3)
    diagnosis = diagnose_log(read_log(log), read_robot(robot))
    assert diagnosis.findings == ()
    assert diagnosis.verdict is Verdict.CONSISTENT
    monkeypatch.setattr(measure, "turning_speeds", lambda velocity, *_: np.zeros(velocity.shape[1]))
    assert diagnose_log(read_log(log), read_robot(robot)).verdict is not Verdict.CONSISTENT
