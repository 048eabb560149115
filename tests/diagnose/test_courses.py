"""Courses along the stroke: stated where the joint is, once, with the offset they contain, and where it travelled."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from mjfriction.diagnose.causes.along_stroke import (
    AlongStroke,
    FrictionAlongStroke,
    RisingAlongStroke,
    TorqueAlongStroke,
    travelled,
)
from mjfriction.diagnose.causes.cause import UNCONSTRAINED, Site
from mjfriction.diagnose.causes.offset import Offset
from mjfriction.diagnose.causes.spring import BentSpring, Spring
from mjfriction.diagnose.causes.waves import Cogging, PositionFriction
from mjfriction.diagnose.fit.model import Chosen, build_model, cause_block
from mjfriction.diagnose.fit.nuisance import make_nuisance
from mjfriction.diagnose.fit.shapes import reshaped
from mjfriction.diagnose.search import courses
from mjfriction.diagnose.search.courses import as_courses
from mjfriction.diagnose.search.stroke_curve import StrokeCurve
from mjfriction.diagnose.settle import stated
from mjfriction.diagnose.settle.stated import Settled
from mjfriction.diagnose.tell.alike import EVEN
from mjfriction.diagnose.tell.findings import _instead, _standing
from mjfriction.identify.gap import Gap
from mjfriction.identify.measure import measure_gap
from mjfriction.identify.structure import Structure
from mjfriction.record.readers import read_log
from mjfriction.robot.files import read_robot
from tests.hidden.machine import UR5_JOINTS, Effect, Instant, Machine, write_case

PAN = 0


def gap_of(folder: Path, effect: Effect, offset: float = 0.0) -> Gap:
    log, path = write_case(folder, Machine(hidden={PAN: effect}, noise=0.05), seed=21)
    robot = read_robot(path)
    table = robot.joint(UR5_JOINTS[PAN])
    sensor = table.position_sensor.model_copy(update={"offset": offset})
    return measure_gap(read_log(log), robot.with_joint(table.model_copy(update={"position_sensor": sensor})))


def hose(i: Instant) -> np.ndarray:
    return 2.0 + 8.0 * np.maximum(i.q - np.mean(i.q), 0.0)


@pytest.mark.parametrize(
    "course", [FrictionAlongStroke(), TorqueAlongStroke(), RisingAlongStroke(), Spring(), BentSpring()]
)
def test_the_robot_file_holds_it_where_the_joint_is(tmp_path: Path, course: AlongStroke | Spring | BentSpring) -> None:
    # The first joint of an arm stands upright: its zero is no matter but for what is stated along the stroke.
    gap = gap_of(tmp_path, hose, offset=0.4)
    choice = Chosen(course, course.along(gap, PAN) if isinstance(course, AlongStroke) else Site(PAN))
    model = build_model(gap, make_nuisance(gap), (choice,))
    strengths = model.strengths[model.places[0]]
    extended = course.extend(gap.robot, choice.site, strengths)
    made = gap.predicted(extended)[:, PAN] - gap.predicted(gap.robot)[:, PAN]
    told = course.columns(gap, choice.site)[PAN] @ strengths
    assert gap.rms(told, PAN) > 0.1
    assert gap.rms(made - told, PAN) < 1e-3 * gap.rms(told, PAN)


def test_it_takes_the_place_of_its_own_kind_and_of_its_offset(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    gap = gap_of(tmp_path, hose)
    torque = TorqueAlongStroke()
    waves = [Chosen(Cogging(), Site(PAN, (k,), order=order)) for order, k in enumerate((5.0, 9.0))]
    chosen = (Chosen(torque, torque.along(gap, PAN)), Chosen(Offset(), Site(PAN)), *waves)
    model = build_model(gap, make_nuisance(gap), chosen)
    curve = StrokeCurve(frozenset(one.key for one in waves), Structure(UR5_JOINTS[PAN], "a curve", 0.5))
    monkeypatch.setattr(courses, "stroke_curves", lambda *_: [curve])
    (only,) = as_courses(model).chosen
    assert isinstance(only.cause, TorqueAlongStroke)


def test_a_hose_that_pulls_from_one_place_on_is_no_spring_with_a_wave(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    gap = gap_of(tmp_path, lambda i: 20.0 * np.maximum(i.q - np.quantile(i.q, 0.7), 0.0))
    chosen = (Chosen(BentSpring(), Site(PAN)), Chosen(Cogging(), Site(PAN, (4.0,))))
    model = build_model(gap, make_nuisance(gap), chosen)
    monkeypatch.setattr(courses, "stroke_curves", lambda *_: [])  # what finds curves by their smoothness
    (only,) = as_courses(model).chosen
    assert isinstance(only.cause, TorqueAlongStroke)
    # A spring beside the waves of a gear is one.
    geared = gap_of(tmp_path, lambda i: 6.0 * i.q + 2.0 * np.cos(40.0 * i.q))
    both = (Chosen(Spring(), Site(PAN)), Chosen(Cogging(), Site(PAN, (40.0,))))
    kept = build_model(geared, make_nuisance(geared), both)
    assert as_courses(kept) is kept


def test_a_hose_that_pulls_more_and_more_is_a_course_that_rises_to_an_end(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    gap = gap_of(tmp_path, lambda i: 40.0 * np.maximum(i.q - np.quantile(i.q, 0.4), 0.0) ** 2)
    joint = gap.robot.joints[PAN]
    chosen = (Chosen(BentSpring(), Site(PAN)), Chosen(Cogging(), Site(PAN, (5.0,))))
    model = build_model(gap, make_nuisance(gap), chosen)
    curve = StrokeCurve(frozenset(one.key for one in chosen), Structure(joint, "a curve", 0.9))
    monkeypatch.setattr(courses, "stroke_curves", lambda *_: [curve])
    (only,) = as_courses(model).chosen
    assert isinstance(only.cause, RisingAlongStroke)
    assert "a parabola and 8 half waves over" in only.cause.evidence(gap, only.site, np.ones(11))
    # Half waves are level at its end, and leave what waves and a cubic do not.
    monkeypatch.setattr(courses, "RisingAlongStroke", TorqueAlongStroke)
    assert as_courses(model) is model


def of_few_waves(i: Instant) -> np.ndarray:
    # Hardly more than one period of a gear's longest wave, and what is no harmonic of it.
    k = 2.0 * np.pi * 1.4 / np.ptp(i.q)
    return 8.0 * np.cos(k * i.q + 0.3) + 1.5 * np.cos(2.3 * k * i.q) + np.cos(0.25 * k * i.q)


def test_a_smooth_torque_that_may_be_waves_is_told_as_either(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    gap = gap_of(tmp_path, of_few_waves)
    k = 2.0 * np.pi * 1.4 / float(np.ptp(gap.motion.position[:, PAN]))
    waves = [Chosen(Cogging(), Site(PAN, (m * k,), order=order)) for order, m in enumerate((1.0, 2.3))]
    chosen = (Chosen(BentSpring(), Site(PAN)), *waves)
    model = reshaped(build_model(gap, make_nuisance(gap), chosen))
    there = as_courses(model)
    (course,) = there.chosen
    assert isinstance(course.cause, RisingAlongStroke)
    assert course.instead == model.chosen
    stands = _standing(Settled(there, ()), course, ())
    assert (stands.alternatives, stands.confidence) == (("drive.cogging",), EVEN)
    name, other = _instead(Settled(there, ()), course, stands) or ("", there)
    assert (name, other.chosen) == ("drive.cogging", model.chosen)
    monkeypatch.setattr(courses, "_hardly_more", lambda *_: False)
    assert as_courses(model) is model


def test_half_waves_of_a_torque_do_not_run_wild_where_motion_did_not_go(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    gap = gap_of(tmp_path, hose)
    choice = Chosen(RisingAlongStroke(), RisingAlongStroke().along(gap, PAN))
    position, residual = gap.at_rows("position")[:, PAN], gap.residual[:, PAN]
    there = position < np.quantile(position, 0.8)

    def off_elsewhere() -> float:
        columns, precision = cause_block(gap, choice)
        rows = columns[PAN][there] / gap.noise_floor[PAN]
        strengths = np.linalg.solve(rows.T @ rows + np.diag(precision), rows.T @ residual[there] / gap.noise_floor[PAN])
        return float(np.sqrt(np.mean(np.square((residual - columns[PAN] @ strengths)[~there]))))

    kept = off_elsewhere()
    monkeypatch.setattr(RisingAlongStroke, "spreads", lambda _: UNCONSTRAINED)
    assert off_elsewhere() > 10.0 * kept


def test_one_wave_stays_a_wave(tmp_path: Path) -> None:
    gap = gap_of(tmp_path, lambda i: 2.5 * np.cos(6.0 * i.q) * np.sign(i.v))
    model = build_model(gap, make_nuisance(gap), (Chosen(PositionFriction(), Site(PAN, (6.0,))),))
    assert as_courses(model) is model
    # Against a wave that is none it pays.
    other = build_model(gap, make_nuisance(gap), (Chosen(PositionFriction(), Site(PAN, (3.0,))),))
    (course,) = as_courses(other).chosen
    assert isinstance(course.cause, FrictionAlongStroke)


@pytest.mark.parametrize(("wavenumber", "rising"), [(2.0, True), (8.0, False)])
def test_a_wave_longer_than_the_stroke_rises_along_it(wavenumber: float, *, rising: bool) -> None:
    wave = Chosen(PositionFriction(), Site(PAN, (wavenumber,)))
    motion = SimpleNamespace(position=np.linspace(-1.0, 1.0, 50)[:, None])
    model = SimpleNamespace(gap=SimpleNamespace(motion=motion), chosen=(wave,))
    assert stated._rising(model, PAN) is rising  # type: ignore[arg-type]


@pytest.mark.parametrize(("middle", "whole"), [(True, True), (False, False)])
def test_a_joint_that_was_not_everywhere_has_no_course(middle: bool, whole: bool) -> None:
    ends = np.concatenate([np.linspace(0.0, 0.3, 200), np.linspace(0.7, 1.0, 200)])
    position = np.sort(np.append(ends, np.linspace(0.3, 0.7, 200) if middle else []))[:, None]
    gap = SimpleNamespace(
        motion=SimpleNamespace(position=position),
        at_rows=lambda _: position,
        clear=np.ones(position.shape, dtype=bool),
    )
    assert travelled(gap, 0) is whole  # type: ignore[arg-type]
