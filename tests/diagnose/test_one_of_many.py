"""What is but one of many alternatives is no finding where something is left unexplained or beside another, and what
is one of several, or hardly large enough, is none on a machine of several joints.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from mjfriction.diagnose.causes.catalog import STRUCTURAL
from mjfriction.diagnose.causes.cause import Site
from mjfriction.diagnose.causes.offset import Offset
from mjfriction.diagnose.causes.payload import Payload
from mjfriction.diagnose.causes.spring import Spring
from mjfriction.diagnose.causes.waves import PositionFriction
from mjfriction.diagnose.fit.exact import usual_nuisance
from mjfriction.diagnose.fit.model import Chosen, Model, build_model
from mjfriction.diagnose.fit.nuisance import make_nuisance
from mjfriction.diagnose.fit.shapes import apart
from mjfriction.diagnose.fit.trial import Trial
from mjfriction.diagnose.search.field import make_field
from mjfriction.diagnose.settle.stated import Settled
from mjfriction.diagnose.tell import alike, findings
from mjfriction.diagnose.tell.alike import Standing
from mjfriction.diagnose.tell.findings import make_findings
from mjfriction.diagnose.tell.untold import Untold
from mjfriction.identify.measure import measure_gap
from mjfriction.identify.stroke_waves import wavenumber_step
from mjfriction.identify.tone import Tone
from mjfriction.record.readers import read_log
from mjfriction.robot.files import read_robot
from tests.hidden.machine import UR5_JOINTS, Machine, write_case

ELBOW = 2
SPRING = Chosen(Spring(), Site(ELBOW))
MANY = ("sensor.encoder_offset", "body.link_inertia", "drive.cogging")


@pytest.fixture(scope="module")
def model(tmp_path_factory: pytest.TempPathFactory) -> Model:
    """An arm with a spring at its elbow, and the model that holds it."""
    machine = Machine(noise=0.1, hidden={ELBOW: lambda course: 6.0 * course.q})
    log, robot = write_case(tmp_path_factory.mktemp("arm"), machine, seed=6, seconds=20.0, rate=100.0)
    gap = measure_gap(read_log(log), read_robot(robot))
    return build_model(gap, usual_nuisance(gap), (SPRING,))


@pytest.fixture
def few(monkeypatch: pytest.MonkeyPatch) -> None:
    """As on a machine of few joints."""
    monkeypatch.setattr(findings, "SEVERAL_JOINTS", len(UR5_JOINTS) + 1)


@pytest.mark.usefixtures("few")
@pytest.mark.parametrize(("confidence", "left", "told"), [(0.2, 0.5, False), (0.2, 0.0, True), (0.5, 0.5, True)])
def test_it_is_told_only_where_it_names_something(
    confidence: float, left: float, told: bool, model: Model, monkeypatch: pytest.MonkeyPatch
) -> None:
    many = Standing(MANY, confidence)
    monkeypatch.setattr(findings, "standing", lambda *_: many)
    untold = Untold(frozenset(), {ELBOW: left} if left else {}, model.heldout_residual())
    said = make_findings(Settled(model, ()), untold, make_field(model.gap, STRUCTURAL), seed=0)
    assert [(one.cause, one.joint) for one in said.findings] == [("body.spring", UR5_JOINTS[ELBOW])] * told
    assert (SPRING.key in said.untold) is not told


@pytest.mark.usefixtures("few")
def test_beside_another_it_is_what_that_leaves(model: Model, monkeypatch: pytest.MonkeyPatch) -> None:
    spring, offset = ("body.spring", UR5_JOINTS[ELBOW]), ("drive.offset", UR5_JOINTS[ELBOW])

    def found(joint: int, confidence: float) -> list[tuple[str, str | None]]:
        other = Chosen(Offset(), Site(joint))
        both = build_model(model.gap, model.nuisance, (SPRING, other))
        its, many = Standing(MANY, confidence), Standing(MANY, 0.2)
        monkeypatch.setattr(findings, "standing", lambda _, choice, __: its if choice.key == other.key else many)
        untold = Untold(frozenset(), {}, both.heldout_residual())
        said = make_findings(Settled(both, ()), untold, make_field(model.gap, STRUCTURAL), seed=0)
        return sorted((one.cause, one.joint) for one in said.findings)

    assert found(ELBOW, 0.5) == [offset]
    assert found(ELBOW - 1, 0.5) == [spring, ("drive.offset", UR5_JOINTS[ELBOW - 1])]
    # Neither of two that name nothing is a finding that leaves the other.
    assert found(ELBOW, 0.2) == [spring, offset]


@pytest.mark.usefixtures("few")
@pytest.mark.parametrize("left", [{}, {ELBOW + 1: 0.5}])
def test_of_the_whole_arm_it_names_nothing_where_anything_is_left(
    left: dict[int, float], model: Model, monkeypatch: pytest.MonkeyPatch
) -> None:
    payload = Chosen(Payload(), Payload().sites(model.gap)[0])
    loaded = build_model(model.gap, model.nuisance, (payload,))
    monkeypatch.setattr(findings, "standing", lambda *_: Standing(MANY, 0.2))
    untold = Untold(frozenset(), left, loaded.heldout_residual())
    said = make_findings(Settled(loaded, ()), untold, make_field(model.gap, STRUCTURAL), seed=0)
    assert [one.cause for one in said.findings] == ["body.payload"] * (not left)
    assert (payload.key in said.untold) is bool(left)


@pytest.mark.parametrize(
    ("confidence", "among", "joints", "noisy", "told"),
    [
        (0.39, MANY, 4, True, False),
        (0.39, MANY, 7, True, True),
        (0.41, MANY, 4, True, True),
        (0.59, (), 4, False, False),
        (0.59, (), 4, True, True),
        (0.59, (), 7, False, True),
        (0.61, (), 4, False, True),
    ],
)
def test_one_of_several_or_one_that_is_hardly_larger_than_other_errors_is_told_of_few_joints_only(
    confidence: float,
    among: tuple[str, ...],
    joints: int,
    noisy: bool,
    told: bool,
    model: Model,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    gap = model.gap if noisy else replace(model.gap, noise_floor=0.3 * model.gap.noise_floor)
    model = build_model(gap, model.nuisance, model.chosen)
    monkeypatch.setattr(findings, "standing", lambda *_: Standing(among, confidence))
    monkeypatch.setattr(findings, "SEVERAL_JOINTS", joints)
    untold = Untold(frozenset(), {}, model.heldout_residual())
    said = make_findings(Settled(model, ()), untold, make_field(model.gap, STRUCTURAL), seed=0)
    assert bool(said.findings) is told
    assert (SPRING.key in said.untold) is not told


@pytest.mark.parametrize("refitted", [True, False])
def test_a_tone_that_is_refitted_along_is_no_small_error(
    refitted: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    tone = {ELBOW + 1: lambda course: 4.0 * np.sin(2.0 * np.pi * 1.7 * course.time)}
    machine = Machine(noise=0.1, hidden={ELBOW: lambda course: 6.0 * course.q} | tone)
    log, robot = write_case(tmp_path, machine, seed=6, seconds=20.0, rate=100.0)
    gap = measure_gap(read_log(log), read_robot(robot))
    heard = build_model(gap, make_nuisance(gap, [Tone(ELBOW + 1, 1.7)] if refitted else ()), (SPRING,))
    monkeypatch.setattr(findings, "standing", lambda *_: Standing((), 0.59))
    untold = Untold(frozenset(), {}, heard.heldout_residual())
    said = make_findings(Settled(heard, ()), untold, make_field(gap, STRUCTURAL), seed=0)
    assert bool(said.findings) is refitted


@pytest.mark.parametrize(("confidence", "joints", "told"), [(0.49, 4, False), (0.51, 4, True), (0.49, 7, True)])
def test_refitted_links_that_are_no_likelier_than_another_cause_are_told_of_few_joints_only(
    confidence: float, joints: int, told: bool, model: Model, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(findings, "SEVERAL_JOINTS", joints)
    untold = Untold(frozenset({SPRING.key}), {}, model.heldout_residual())
    asked = Settled(model, ()), untold, make_field(model.gap, STRUCTURAL)
    with pytest.MonkeyPatch.context() as certain:
        certain.setattr(findings, "standing", lambda *_: Standing((), 0.9))
        (spring,) = make_findings(Settled(model, ()), replace(untold, keys=frozenset()), asked[2], seed=0).findings
    links = replace(spring, cause="body.link_inertia", joint=None, alternatives=MANY, confidence=confidence)
    monkeypatch.setattr(findings, "link_finding", lambda *_: links)
    assert make_findings(*asked, seed=0).findings == (links,) * told


@pytest.mark.usefixtures("few")
@pytest.mark.parametrize(("confidence", "told"), [(0.01, False), (0.1, True)])
def test_what_is_hardly_likely_is_not_told(
    confidence: float, told: bool, model: Model, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(findings, "standing", lambda *_: Standing((), confidence))
    untold = Untold(frozenset(), {}, model.heldout_residual())
    said = make_findings(Settled(model, ()), untold, make_field(model.gap, STRUCTURAL), seed=0)
    assert bool(said.findings) is told
    assert (SPRING.key in said.untold) is not told


def test_two_waves_that_the_stroke_does_not_tell_apart_are_one(model: Model) -> None:
    def wave(wavenumber: float, order: int) -> Chosen:
        return Chosen(PositionFriction(), Site(ELBOW, (wavenumber,), order=order))

    step = wavenumber_step(model.gap, ELBOW)
    first = wave(3.0 * step, 0)
    waving = build_model(model.gap, model.nuisance, (first,))
    assert not apart(waving, wave(3.5 * step, 1))
    assert apart(waving, wave(5.0 * step, 1))
    assert apart(waving, SPRING)


def test_a_cause_so_large_that_all_else_passes_for_noise_stands_as_it_does_beside_it(
    model: Model, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Rows that are weighed without it may fit what is not physical; as the model with it weighs them, they do not."""
    field, own = make_field(model.gap, STRUCTURAL), alike.try_out

    def unless_noisy(beside: Model, choice: Chosen) -> Trial | None:
        joint = model.system.rows.weight[:, ELBOW]
        return own(beside, choice) if np.array_equal(beside.system.rows.weight[:, ELBOW], joint) else None

    asked = alike.standing(model, SPRING, field)
    monkeypatch.setattr(alike, "try_out", unless_noisy)
    stands = alike.standing(model, SPRING, field)
    assert stands.alternatives == asked.alternatives
    assert stands.confidence == pytest.approx(asked.confidence, abs=0.02)
    assert stands.confidence > alike.EVEN
