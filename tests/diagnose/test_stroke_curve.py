"""What waves and a spring only spell is told as the course along the stroke that it is, or left open."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from mjfriction.diagnose.causes.cause import Site
from mjfriction.diagnose.causes.waves import PositionFriction
from mjfriction.diagnose.diagnosis import diagnose_log
from mjfriction.diagnose.fit.model import Chosen
from mjfriction.diagnose.search import compete, stroke_curve
from mjfriction.diagnose.search.stroke_curve import ALONG_STROKE, FRICTION_ALONG_STROKE
from mjfriction.diagnose.settle import stated
from mjfriction.diagnose.tell.outcome import Diagnosis, Verdict
from mjfriction.record.readers import read_log
from mjfriction.robot.files import read_robot
from mjfriction.robot.spring import coefficients, spring_along
from tests.hidden.machine import Effect, Instant, Machine, write_case

PAN = 0


def diagnosed(folder: Path, effect: Effect) -> Diagnosis:
    log, robot = write_case(folder, Machine(hidden={PAN: effect}), seed=21)
    return diagnose_log(read_log(log), read_robot(robot))


def stop(i: Instant) -> np.ndarray:
    begin = np.max(i.q) - 0.5 * np.ptp(i.q)
    return 4.0 * np.maximum(i.q - begin, 0.0)


def tight_ends(i: Instant) -> np.ndarray:
    along = 2.0 * (i.q - np.min(i.q)) / np.ptp(i.q) - 1.0
    return 9.0 * along**4 * np.sign(i.v)


@pytest.mark.deep
@pytest.mark.parametrize(
    ("effect", "cause"),
    [(stop, "body.spring"), (tight_ends, "friction.position")],
)
def test_a_course_along_the_stroke_is_told_whole(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, effect: Effect, cause: str
) -> None:
    found = diagnosed(tmp_path / "as it is", effect)
    assert found.verdict is Verdict.EXPLAINED
    assert [(one.cause, one.joint) for one in found.findings] == [(cause, "shoulder_pan_joint")]
    assert "along the stroke: " in found.findings[0].evidence
    (pan,) = [error for error in found.joints if error.joint == "shoulder_pan_joint"]
    assert pan.rms_heldout_after < 1.06 * pan.noise_floor
    # The robot file holds it.
    gap = found.gap
    left = gap.rms((gap.measured - gap.predicted(found.robot))[:, PAN], PAN)
    assert left == pytest.approx(pan.rms_after, rel=1e-3)
    for place in (compete, stated):
        monkeypatch.setattr(place, "as_courses", lambda model: model)
    without = diagnosed(tmp_path / "without", effect)
    if cause == "friction.position":
        (worse,) = [error for error in without.joints if error.joint == "shoulder_pan_joint"]
        assert worse.rms_heldout_after > 1.1 * pan.rms_heldout_after
    else:
        assert without.verdict is Verdict.UNEXPLAINED
        assert without.findings == ()
        (remaining,) = without.remaining
        assert (remaining.joint, remaining.covariate) == ("shoulder_pan_joint", ALONG_STROKE)


@pytest.mark.deep
@pytest.mark.parametrize(
    "effect",
    [
        lambda i: 6.0 * (i.q - 0.3) + 9.0 * (i.q - 0.3) ** 3,  # a hose that stiffens
        # A balancer on a lever, whose joint stands upright.
        lambda i: 7.0 * np.sin(i.q + 0.9),
    ],
)
def test_a_torque_that_bends_along_the_whole_stroke_is_one_spring(tmp_path: Path, effect: Effect) -> None:
    diagnosis = diagnosed(tmp_path, effect)
    assert [(finding.cause, finding.joint) for finding in diagnosis.findings] == [("body.spring", "shoulder_pan_joint")]
    assert diagnosis.verdict is Verdict.EXPLAINED
    assert "bends along the stroke" in diagnosis.findings[0].evidence
    (pan,) = [error for error in diagnosis.joints if error.joint == "shoulder_pan_joint"]
    assert pan.rms_heldout_after < 1.1 * pan.noise_floor
    position = diagnosis.gap.motion.position[:, PAN]
    instant = Instant(position, position, position, position, position, position, position[:, None])
    change = spring_along(coefficients(diagnosis.robot.joint("shoulder_pan_joint").spring), position) - effect(instant)
    assert np.sqrt(np.mean(np.square(change))) < 0.03 * np.std(effect(instant))


@pytest.mark.deep
def test_a_straight_spring_is_not_bent(tmp_path: Path) -> None:
    (finding,) = diagnosed(tmp_path, lambda i: 9.0 * i.q).findings
    assert finding.cause == "body.spring"
    assert [parameter.name for parameter in finding.parameters] == ["stiffness", "preload"]


@pytest.mark.deep
def test_waves_of_a_gear_beside_a_spring_stay_what_they_are(tmp_path: Path) -> None:
    found = diagnosed(tmp_path, lambda i: 2.5 * np.cos(17.0 * i.q) + 9.0 * i.q)
    assert {finding.cause for finding in found.findings} == {"drive.cogging", "body.spring"}


def three_harmonics(i: Instant) -> np.ndarray:
    longest = 2.0 * np.pi * 1.45 / np.ptp(i.q)
    return 5.0 * np.sin(longest * i.q) + 2.5 * np.cos(2.0 * longest * i.q) + 2.0 * np.cos(4.0 * longest * i.q)


def two_harmonics(i: Instant) -> np.ndarray:
    longest = 2.0 * np.pi * 1.45 / np.ptp(i.q)
    return 5.0 * np.sin(longest * i.q) + 2.5 * np.cos(2.0 * longest * i.q)


@pytest.mark.deep
@pytest.mark.parametrize(("harmonics", "count"), [(three_harmonics, 3), (two_harmonics, 2)])
def test_harmonics_are_of_a_gear_though_one_curve_does_as_well(
    harmonics: Effect, count: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    found = diagnosed(tmp_path / "as it is", harmonics)
    assert [finding.cause for finding in found.findings] == ["drive.cogging"] * count
    monkeypatch.setattr(stroke_curve, "_harmonics", lambda own: False)
    without = diagnosed(tmp_path / "without", harmonics)
    assert "drive.cogging" not in {finding.cause for finding in without.findings}


@pytest.mark.deep
def test_waves_of_which_the_period_is_not_known_are_none(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    # A stop so steep that no smooth curve follows it; what the curve says is left aside here, and that it may be told
    # whole.
    for place in (compete, stated):
        monkeypatch.setattr(place, "as_courses", lambda model: model)

    def stop(i):  # type: ignore[no-untyped-def]
        return 25.0 * np.maximum(i.q - np.max(i.q) + 0.2 * np.ptp(i.q), 0.0)

    monkeypatch.setattr(stroke_curve, "AS_GOOD", np.inf)
    found = diagnosed(tmp_path / "as it is", stop)
    assert (found.verdict, found.findings) == (Verdict.UNEXPLAINED, ())
    monkeypatch.setattr(stroke_curve, "KNOWN_TO", np.inf)
    assert diagnosed(tmp_path / "without", stop).verdict is Verdict.EXPLAINED


def test_two_waves_of_friction_are_told_where_their_periods_are_known(monkeypatch: pytest.MonkeyPatch) -> None:
    waves = [Chosen(PositionFriction(), Site(PAN, shape=(k,), order=order)) for order, k in enumerate((2.0, 5.0))]
    alone = Chosen(PositionFriction(), Site(PAN + 1, shape=(2.0,)))
    model = SimpleNamespace(chosen=(*waves, alone))
    known_to = dict.fromkeys((choice.key for choice in model.chosen), np.array([0.1, 0.1, 0.6]))
    monkeypatch.setattr(stroke_curve, "_widths", lambda _: known_to)
    assert stroke_curve.vague_waves(model) == {waves[0].key}  # type: ignore[arg-type]


@pytest.mark.deep
def test_waves_of_friction_that_are_vague_are_no_findings(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def waves(i):  # type: ignore[no-untyped-def]
        return (1.8 * np.cos(4.0 * i.q) + 1.5 * np.cos(11.0 * i.q)) * np.sign(i.v)

    known = diagnosed(tmp_path / "known", waves).findings
    assert [one.cause for one in known] == 2 * ["friction.position"]
    # As two waves, not as a spot and what waves make of the rest.
    assert sorted(one.parameters[-1].value for one in known) == pytest.approx([4.0, 11.0], rel=0.1)
    monkeypatch.setattr(stroke_curve, "KNOWN_TO", 0.0)
    vague = diagnosed(tmp_path / "vague", waves)
    assert vague.findings == ()
    # What is no finding does not vanish: a robot with such friction does not agree with its log.
    assert vague.verdict is Verdict.UNEXPLAINED
    assert [(one.joint, one.covariate) for one in vague.remaining] == [("shoulder_pan_joint", FRICTION_ALONG_STROKE)]
    assert FRICTION_ALONG_STROKE in vague.summary
