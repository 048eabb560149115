"""A load that swings takes the course of a damped resonator; only resonances that a motion resolves are tried."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from mjfriction.identify.gap import Gap
from mjfriction.identify.measure import heard_later, measure_gap
from mjfriction.identify.swing import Swing, courses, shown_swings
from mjfriction.record.readers import read_log
from mjfriction.robot.files import read_robot
from tests.hidden.machine import Machine, write_case

ELBOW = 2


@pytest.fixture(scope="module")
def gap(tmp_path_factory: pytest.TempPathFactory) -> Gap:
    log, robot = write_case(tmp_path_factory.mktemp("swing"), Machine(), seed=1, seconds=30.0)
    return measure_gap(read_log(log), read_robot(robot))


@pytest.mark.parametrize(("frequency", "ratio"), [(0.6, 0.02), (1.7, 0.08)])
def test_its_course_is_that_of_a_damped_resonator(frequency: float, ratio: float, gap: Gap) -> None:
    time, omega = gap.motion.time, 2.0 * np.pi * frequency
    rows = gap.chain.time

    def slope(t: float, state: np.ndarray) -> tuple[float, float]:
        pull = np.interp(t, time, gap.motion.acceleration[:, ELBOW])
        return state[1], -pull - 2.0 * ratio * omega * state[1] - (1.0 + ratio**2) * omega**2 * state[0]

    solved = solve_ivp(slope, (rows[0], rows[-1]), (0.0, 0.0), t_eval=rows, max_step=0.02, rtol=1e-6).y[0]
    course = Swing(ELBOW, frequency, ratio).columns(gap)[:, 0]
    assert np.std(solved - course * np.sqrt(np.mean(np.square(solved)))) < 0.02 * np.std(solved)
    assert np.mean(np.square(course)) == pytest.approx(1.0)


def test_it_starts_from_rest_in_each_stretch_and_may_swing_already(gap: Gap) -> None:
    late = gap.chain.time.copy()
    half = late.size // 2
    late[half:] += 100.0
    apart = replace(gap, chain=replace(gap.chain, time=late))
    swing = Swing(ELBOW, 0.8, 0.02)
    whole, parts = swing.columns(gap), swing.columns(apart)
    assert (whole.shape[1], parts.shape[1]) == (3, 5)
    factor = np.linalg.norm(parts[:half, 0]) / np.linalg.norm(whole[:half, 0])
    np.testing.assert_allclose(parts[:half, 0], factor * whole[:half, 0], rtol=1e-9, atol=1e-12)
    assert parts[half, 0] == 0.0
    # What is left of the first half's motion goes on as the second half's free swing would have.
    on = whole[half:, 0] - parts[half:, 0] / factor
    free = parts[half:, 3:]
    left = on - free @ np.linalg.lstsq(free, on, rcond=None)[0]
    assert np.std(left) < 1e-6 * np.std(on)
    np.testing.assert_array_equal(parts[half:, 1:3], 0.0)


def test_what_a_drive_reports_late_swings_late(gap: Gap) -> None:
    swing, delay = Swing(ELBOW, 0.4, 0.02), 0.1
    late = heard_later(gap, np.where(np.arange(6) == ELBOW, delay, 0.0))
    prompt, reported = (swing.columns(one)[:, 0] for one in (gap, late))
    expected = np.interp(gap.chain.time - delay, gap.chain.time, prompt)
    assert np.std(reported - expected) < 0.02
    assert np.std(reported - prompt) > 0.2


def test_those_that_are_tried_leave_no_resonance_between_them(gap: Gap) -> None:
    columns = courses(gap, shown_swings(gap).swings(ELBOW))[:, :, 0]
    for frequency, ratio in ((0.411, 0.02), (0.487, 0.05)):
        course = Swing(ELBOW, frequency, ratio).columns(gap)[:, 0]
        alike = np.square(columns.T @ course) / np.sum(np.square(columns), axis=0) / np.sum(np.square(course))
        assert np.max(alike) > 0.85


def test_where_a_motion_repeats_each_spans_two_overtones(gap: Gap) -> None:
    def narrowest(period: float | None) -> float:
        repeated = replace(gap, blocks=replace(gap.blocks, period=period))
        return min(
            (2.0 * swing.damping_ratio * swing.frequency for swing in shown_swings(repeated).swings(ELBOW)),
            default=np.inf,
        )

    assert narrowest(None) < 0.01
    assert narrowest(40.0) > 2.0 / 40.0
    assert narrowest(10.0) > 2.0 / 10.0
    assert narrowest(0.5) == np.inf
    repeated = replace(gap, blocks=replace(gap.blocks, period=10.0))
    assert shown_swings(repeated).holds(Swing(ELBOW, 1.2, 0.09))
    assert not shown_swings(repeated).holds(Swing(ELBOW, 1.2, 0.05))


def test_a_log_of_many_short_pieces_shows_no_swing(gap: Gap) -> None:
    piece = np.arange(gap.chain.time.size) // 200
    pieces = replace(gap, chain=replace(gap.chain, time=gap.chain.time + 30.0 * piece))
    assert shown_swings(gap).swings(ELBOW)[0].frequency < 0.5
    assert all(swing.frequency > 10.0 / 5.0 for swing in shown_swings(pieces).swings(ELBOW))
