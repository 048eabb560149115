"""When what is left is too much to be left: measured against friction as it is stated, not as it was told."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from mjfriction.diagnose.causes.catalog import STATED_LEVELS
from mjfriction.diagnose.causes.cause import Site
from mjfriction.diagnose.causes.coupling import SharedEffort, SharedFriction
from mjfriction.diagnose.causes.offset import Offset
from mjfriction.diagnose.causes.payload import Payload
from mjfriction.diagnose.causes.spring import Spring
from mjfriction.diagnose.causes.viscous_nonlinear import ViscousNonlinear
from mjfriction.diagnose.fit.model import Chosen, build_model
from mjfriction.diagnose.fit.nuisance import make_nuisance
from mjfriction.diagnose.tell import verdict
from mjfriction.diagnose.tell.alike import Standing
from mjfriction.diagnose.tell.findings import _beside_left
from mjfriction.diagnose.tell.outcome import Verdict
from mjfriction.diagnose.tell.untold import Untold
from mjfriction.identify.joint_error import JointError
from mjfriction.identify.measure import measure_gap
from mjfriction.identify.structure import Structure
from mjfriction.record.readers import read_log
from mjfriction.robot.files import read_robot
from tests.hidden.machine import Machine, write_case


def told_of(
    stated: float,
    clear: np.ndarray,
    monkeypatch: pytest.MonkeyPatch,
    blocks: int = 9,
    *,
    before: float = 0.8,
    found: Sequence[Chosen] = (),
) -> bool:
    """Return whether an error of 0.6 that follows speed is told of, at a joint whose friction came to 20."""
    gap = SimpleNamespace(
        robot=SimpleNamespace(joints=("swing",)),
        blocks=SimpleNamespace(row=np.arange(9), count=blocks),
        clear=clear,
        rms=lambda course, _: float(np.sqrt(np.mean(np.square(course)))),
        measured=np.full((9, 1), 10.0),
        residual=np.full((9, 1), before),
        effort=SimpleNamespace(friction=np.full((9, 1), stated)),
        noise_floor=np.full(1, 0.1),
    )
    nuisance = SimpleNamespace(uneven=1.0)
    model = SimpleNamespace(gap=gap, friction={0: 20.0}, nuisance=nuisance, chosen=found, noteworthy=found)
    for share in ("coloured_share", "burst_share"):
        monkeypatch.setattr(verdict, share, lambda *_: 0.0)
    monkeypatch.setattr(verdict, "with_play", lambda _: set())
    after = [Structure("swing", "velocity", 0.5)]
    return bool(verdict._followed(model, 0, after, np.full((9, 1), 0.6)))  # type: ignore[arg-type]


@pytest.mark.parametrize(("stated", "told"), [(2.0, True), (20.0, False), (0.0, False)])
def test_a_level_told_in_the_place_of_something_else_hides_nothing(
    stated: float, *, told: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """0.42 of an error of 0.6 follow speed: 5 % of a friction of 20 is more than that, of 2 as stated it is not."""
    assert told_of(stated, np.ones((9, 1), dtype=bool), monkeypatch) is told


SPRING, OFFSET, BEND = (Chosen(cause(), Site(0)) for cause in (Spring, Offset, ViscousNonlinear))
LEVELS, HELD, ELSEWHERE = Chosen(STATED_LEVELS, Site(0)), Chosen(Payload(), Site(0)), Chosen(Spring(), Site(1))


@pytest.mark.parametrize(
    ("found", "told"),
    [
        ((SPRING, OFFSET), False),
        ((SPRING, OFFSET, BEND), True),
        ((SPRING, OFFSET, LEVELS), False),
        ((SPRING, OFFSET, HELD), False),
        ((SPRING, OFFSET, ELSEWHERE), False),
    ],
)
def test_three_causes_of_one_joint_excuse_nothing(
    found: Sequence[Chosen], *, told: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """An error of 2 came down to 0.6: a cause whose form is not quite right leaves that, but not three of them."""
    assert told_of(2.0, np.ones((9, 1), dtype=bool), monkeypatch, before=2.0, found=found) is told


@pytest.mark.parametrize(
    ("left", "found", "confidence"),
    [
        ((), SPRING, 0.9),
        ((0,), SPRING, 0.5),
        ((1,), SPRING, 0.9),
        ((1, 2), SPRING, 0.9),
        ((1, 2, 3), SPRING, 0.5),
        ((1, 2, 3), HELD, 0.5),
    ],
)
def test_what_stands_beside_an_error_that_none_explains_may_be_a_part_of_it(
    left: tuple[int, ...], found: Chosen, confidence: float
) -> None:
    untold = Untold(frozenset(), dict.fromkeys(left, 0.5), np.zeros((0, 0)))
    assert _beside_left(found, Standing((), 0.9), untold).confidence == confidence


@pytest.mark.parametrize(("moving", "blocks", "told"), [(2, 9, False), (3, 9, True), (5, 60, False), (6, 60, True)])
def test_of_a_joint_that_moves_once_or_twice_nothing_is_known_on_other_motion(
    moving: int, blocks: int, *, told: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """It goes to where it is held: what is left while it does is in no other part of the log to be proved by."""
    clear = np.zeros((9, 1), dtype=bool)
    clear[:moving] = True
    assert told_of(2.0, clear, monkeypatch, blocks) is told


def test_while_a_joint_rests_nothing_is_known_of_what_follows_its_friction(tmp_path: Path) -> None:
    log, robot = write_case(tmp_path, Machine(pauses=True), seed=4, seconds=15.0)
    gap = measure_gap(read_log(log), read_robot(robot))
    nuisance = make_nuisance(gap)
    model = build_model(gap, nuisance, (Chosen(SharedFriction(), Site(5, other=4)),))
    clear = verdict.judged(model).clear
    np.testing.assert_array_equal(clear[:, 5], gap.clear[:, 5] & gap.clear[:, 4])
    assert np.any(clear[:, 5] != gap.clear[:, 5])
    np.testing.assert_array_equal(clear[:, :5], gap.clear[:, :5])
    # What a resting joint's drive gives is in the log.
    of_effort = build_model(gap, nuisance, (Chosen(SharedEffort(), Site(5, other=4)),))
    assert verdict.judged(of_effort) is gap


def test_a_summary_names_every_cause_once_and_few_of_many() -> None:
    gap = SimpleNamespace(robot=SimpleNamespace(name="arm"))
    error = JointError("a", "effort", "N·m", 1.0, 0.5, 1.0, 0.5, 0.4, (0.4, 0.6))

    def found(*places: tuple[str, str | None]) -> str:
        findings = [SimpleNamespace(cause=cause, joint=joint, shown_at="a") for cause, joint in places]
        told = verdict.summarize(gap, Verdict.EXPLAINED, findings, (error,), ())  # type: ignore[arg-type]
        return told.removeprefix("The model of 'arm' lacks ").partition(";")[0]

    waves, weight = ("drive.cogging", "a"), ("body.payload", None)
    assert found(waves, weight, waves) == "drive.cogging at a (2 of them), body.payload"
    offsets = [("drive.offset", joint) for joint in "bcdefg"]
    assert found(*offsets) == ", ".join(f"drive.offset at {joint}" for joint in "bcde") + " and 2 more"


@pytest.mark.parametrize(
    ("left", "noise", "told"),
    [
        (0.02, 0.01, "nothing beyond the noise was found."),
        (0.4, 0.01, "nothing that stands out was found. At a, 0.4 N·m are left, 4.0 % of the effort"),
        (0.4, 0.2, "nothing beyond the noise was found."),  # hardly more than noise
        (0.09, 0.01, "nothing beyond the noise was found."),  # hardly any of the effort
    ],
)
def test_a_summary_tells_what_is_left_far_above_the_noise(left: float, noise: float, told: str) -> None:
    gap = SimpleNamespace(
        robot=SimpleNamespace(name="arm", joints=("a",)),
        measured=np.full((9, 1), 10.0),
        per_reported=np.ones(1),
        rms=lambda values, joint: float(np.sqrt(np.mean(np.square(values)))),
    )
    error = JointError("a", "effort", "N·m", left, left, left, left, noise, (0.0, 0.0))
    summary = verdict.summarize(gap, Verdict.CONSISTENT, (), (error,), ())  # type: ignore[arg-type]
    assert told in summary
    assert summary.count("left") == told.count("left")
