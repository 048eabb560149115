"""What hardly shows beside what is left is no finding: how much that is."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from mjfriction.diagnose.causes.cause import Site
from mjfriction.diagnose.causes.spring import BentSpring
from mjfriction.diagnose.causes.varying import Step, WarmUpDrift
from mjfriction.diagnose.diagnosis import diagnose_log
from mjfriction.diagnose.fit.model import Chosen, build_model
from mjfriction.diagnose.fit.nuisance import make_nuisance
from mjfriction.diagnose.settle.stated import Settled
from mjfriction.diagnose.tell import untold
from mjfriction.diagnose.tell.untold import find_untold, shows
from mjfriction.identify.measure import measure_gap
from mjfriction.record.readers import read_log
from mjfriction.robot.files import read_robot
from tests.hidden.machine import UR5_COULOMB, Instant, Machine, bristle, write_case

ROWS, ELBOW = 4000, 2


def gap(effort: float = 0.0, noise: float = 1.0) -> Any:
    return SimpleNamespace(
        examined=(0, 1),
        measured=np.full((ROWS, 2), effort),
        noise_floor=np.full(2, noise),
        rms=lambda values, joint: float(np.sqrt(np.mean(np.square(values)))),
    )


def left(*mean_squares: float) -> np.ndarray:
    return np.sqrt(np.array(mean_squares)) * np.ones((ROWS, 1))


@pytest.mark.parametrize(
    ("taken", "by_others", "unexplained", "seen"),
    [
        (0.15, 0.0, 0.0, True),  # little, but nothing larger is beside it
        (0.05, 0.0, 0.0, False),  # too little
        (0.15, 10.0, 0.0, False),  # as much as a large cause leaves whose form is not quite the one fitted
        (0.25, 1000.0, 0.0, True),  # enough, whatever others take
        (0.25, 0.0, 0.5, False),  # less than what none explains
        (2.0, 0.0, untold.DROWNED * 0.9, False),  # more than that, but not half of the error that none explains
        (3.0, 0.0, untold.DROWNED * 0.9, True),
    ],
)
def test_what_is_taken_off_what_is_left_decides(taken: float, by_others: float, unexplained: float, seen: bool) -> None:
    after = left(1.0, 1.0)
    before = left(1.0 + taken, 1.0)
    bare = left(1.0 + taken + by_others, 1.0)
    assert shows(gap(), before, after, {0: unexplained}, bare, {}) is seen


@pytest.mark.parametrize(("taken", "seen"), [(2.9, False), (3.1, True)])
def test_what_has_to_clear_its_joint_leaves_little_there(taken: float, seen: bool) -> None:
    after, before = left(1.0, 1.0), left(1.0 + taken, 1.0)
    assert shows(gap(), before, after, {}, before, {}, cleared=3.0) is seen
    assert shows(gap(), before, after, {}, before, {})


def test_a_spring_that_bends_is_told_where_it_clears_its_joint(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    # Beside it, ripple as every gear has some, of periods that no cause describes.
    def course(at: Instant) -> np.ndarray:
        return 3.0 * at.q**3 + 0.6 * (np.sin(61.0 * at.q) + np.sin(43.0 * at.q) * np.sign(at.v))

    log, robot = write_case(tmp_path, Machine(hidden={ELBOW: course}, noise=0.01), seed=3, seconds=30.0)
    measured = measure_gap(read_log(log), read_robot(robot))
    bent = Chosen(BentSpring(), Site(ELBOW))
    model = build_model(measured, make_nuisance(measured), (bent,))

    def told() -> bool:
        return bent.key not in find_untold(Settled(model, ()), (), (), model.heldout_residual()).keys

    assert not told()
    # Nor where drives and links would have to stand in for it.
    monkeypatch.setattr(untold, "relief", lambda *_: np.inf)
    assert not told()
    monkeypatch.setattr(BentSpring, "least_cleared", 0.0)
    assert told()


def test_one_joint_is_enough() -> None:
    after, before = left(1.0, 1.0), left(1.0, 1.5)
    assert shows(gap(), before, after, {0: 1.0}, before, {})


@pytest.mark.parametrize(("effort", "seen"), [(190.0, True), (210.0, False)])
def test_what_removes_half_a_percent_of_the_effort_is_next_to_nothing(effort: float, seen: bool) -> None:
    after, before = left(1.0, 1.0), left(2.0, 1.0)
    assert shows(gap(effort), before, after, {}, before, {}) is seen


@pytest.mark.parametrize(
    ("taken", "effort", "noise", "amid", "seen"),
    [
        (0.5, 0.0, 0.5, True, True),  # what is left is hardly more than noise
        (0.5, 0.0, 0.1, True, False),  # it is many small errors, and this is one of them
        (0.9, 0.0, 0.1, True, True),  # larger than these together
        (0.9, 100.0, 0.1, True, False),  # but no larger than one of them may be
        (2.0, 100.0, 0.1, True, True),
        (0.5, 0.0, 0.1, False, True),  # from one log to the next, a model's errors are the same
    ],
)
def test_a_cause_stands_out_of_the_many_small_errors_of_a_model(
    taken: float, effort: float, noise: float, amid: bool, seen: bool
) -> None:
    after, before = left(1.0, 1.0), left(1.0 + taken, 1.0)
    assert shows(gap(effort, noise), before, after, {}, before, {}, amid_others=amid) is seen


def test_beside_a_bristle_more_is_asked_for_on_its_own_joint() -> None:
    after, before = left(1.0, 1.0), left(1.4, 1.0)
    bristle = left(201.0, 1.0)  # what no bristle is drawn right to half a percent: as much as the noise
    assert shows(gap(), before, after, {}, bristle, {})
    assert not shows(gap(), before, after, {}, bristle, {0: bristle})
    assert shows(gap(), before, after, {}, bristle, {1: bristle})
    assert shows(gap(), left(2.2, 1.0), after, {}, bristle, {0: bristle})


@pytest.mark.deep
def test_only_what_is_beside_a_bristle_is_held_against_it(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def bristle_and_offset(at: Instant) -> np.ndarray:
        return UR5_COULOMB[ELBOW] * (bristle(at.q, 0.05) - np.sign(at.v)) + 2.0

    asked: list[set[int]] = []

    def noted(gap: Any, before: Any, after: Any, left: Any, bare: Any, built_up: Any, **_: Any) -> bool:
        asked.append(set(built_up))
        return shows(gap, before, after, left, bare, built_up)

    log, robot = write_case(tmp_path, Machine(hidden={ELBOW: bristle_and_offset}, noise=0.1), seed=4)
    monkeypatch.setattr(untold, "shows", noted)
    findings = diagnose_log(read_log(log), read_robot(robot)).findings
    assert {finding.cause for finding in findings} == {"friction.presliding", "drive.offset"}
    assert sorted(map(sorted, asked)) == [[], [ELBOW]]


@pytest.mark.parametrize(
    ("cause", "moment", "between"),
    [(Step(), 9.9, True), (Step(), 11.2, True), (Step(), 5.0, False), (WarmUpDrift(), 9.9, False)],
)
def test_a_step_where_a_second_log_begins_is_between_the_two(cause: Any, moment: float, between: bool) -> None:
    time = np.concatenate([np.arange(0.0, 10.0, 0.02), np.arange(11.0, 21.0, 0.02)])
    joined = SimpleNamespace(
        chain=SimpleNamespace(time=time),
        clear=np.ones((time.size, 1), dtype=bool),
        log=SimpleNamespace(joined=(("first", 0.0), ("second", 11.0))),
    )
    assert untold._between_logs(joined, Chosen(cause, Site(0, (moment,)))) is between
