"""A Stribeck curve so wide that no motion sees its end: it is named, rather than levels and a bend."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pyarrow as pa
import pytest

from mjfriction.benchmark.drawing import draw_case
from mjfriction.diagnose.causes.cause import Site
from mjfriction.diagnose.causes.stribeck import EXPONENTS, Stribeck, UnfinishedStribeck
from mjfriction.diagnose.diagnosis import diagnose_log
from mjfriction.diagnose.fit.exact import usual_nuisance
from mjfriction.diagnose.fit.model import Chosen, build_model
from mjfriction.diagnose.fit.shapes import own_shape
from mjfriction.diagnose.settle import stated
from mjfriction.diagnose.tell import alike
from mjfriction.diagnose.tell.outcome import Finding
from mjfriction.identify.measure import measure_gap
from mjfriction.record.readers import read_log
from mjfriction.record.readers.table import log_from_table
from mjfriction.robot.files import read_robot
from tests.hidden.machine import UR5_JOINTS, UR5_VISCOUS, Effect, Instant, Machine, write_case

WRIST = 5
EXCESS, VELOCITY = 3.0, 1.5  # N·m; rad/s, of a joint that turns at 2.2 at most
LATE = 0.25  # of the top speed: with an exponent of 1, a twentieth is left at three quarters of it


def found(folder: Path, hidden: Effect) -> Finding:
    log, robot = write_case(folder, Machine(noise=0.1, hidden={WRIST: hidden}), seed=6, seconds=25.0, rate=120.0)
    (finding,) = diagnose_log(read_log(log), read_robot(robot)).findings
    assert finding.joint == UR5_JOINTS[WRIST]
    return finding


@pytest.mark.deep
def test_it_is_neither_levels_that_are_off_nor_a_bend(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def fading(course: object) -> np.ndarray:
        return np.asarray(EXCESS * np.exp(-np.abs(course.v) / VELOCITY) * np.sign(course.v))  # type: ignore[attr-defined]

    finding = found(tmp_path / "wide", fading)
    fitted = {parameter.name: parameter for parameter in finding.parameters}
    assert finding.cause == "friction.stribeck"
    assert fitted["stribeck_excess"].value == pytest.approx(EXCESS, rel=0.15)
    for module in (stated, alike):
        monkeypatch.setattr(module, "in_place_of_levels", lambda *_, **__: ())
    assert found(tmp_path / "unasked", fading).cause == "friction.viscous_nonlinear"


@pytest.mark.parametrize(("velocity", "exponent", "own"), [(2.0, 2.0, False), (2.0, 1.0, True), (1.2, 2.0, True)])
def test_what_hardly_falls_within_the_motion_is_a_level(
    velocity: float, exponent: float, own: bool, tmp_path: Path
) -> None:
    # Of a curve that stays up to the top speed nothing but a higher Coulomb level is seen.
    log, robot = write_case(tmp_path, Machine(), seed=6, seconds=15.0, rate=120.0)
    gap = measure_gap(read_log(log), read_robot(robot))
    shape = (velocity * float(gap.motion.top_speed[WRIST]), exponent)
    assert UnfinishedStribeck().own_shape(gap, Site(WRIST, shape=shape)) is own


@pytest.mark.deep
def test_levels_that_are_off_are_no_wide_curve(tmp_path: Path) -> None:
    def off(course: object) -> np.ndarray:
        v = course.v  # type: ignore[attr-defined]
        return np.asarray(0.8 * np.sign(v) - 0.4 * UR5_VISCOUS[WRIST] * v)

    assert found(tmp_path / "off", off).cause == "friction.coulomb_viscous"


@pytest.mark.deep
def test_one_that_ends_late_is_no_bend() -> None:
    """By three quarters of the top speed all but a twentieth has faded: a bend leaves clearly more."""
    case = draw_case(980038).case()
    (finding,) = diagnose_log(log_from_table(pa.table(case.log), "case"), case.stated).findings
    assert [(finding.cause, finding.joint)] == [(hidden.cause, hidden.joint) for hidden in case.hidden]
    assert finding.cause == "friction.stribeck"


@pytest.mark.deep
def test_one_that_few_rows_show_is_no_step(monkeypatch: pytest.MonkeyPatch) -> None:
    """A wrist that is always fast: the best exponent is that of a step, and one of 2 does as well."""
    case = draw_case(1010093).case()
    log = log_from_table(pa.table(case.log), "case")
    (finding,) = diagnose_log(log, case.stated).findings
    assert [(finding.cause, finding.joint)] == [(hidden.cause, hidden.joint) for hidden in case.hidden]
    monkeypatch.setattr(Stribeck, "usual_bounds", lambda *_: [])
    assert not diagnose_log(log, case.stated).findings


def best_of_its_own(folder: Path, exponent: float) -> Chosen | None:
    def fading(course: Instant) -> np.ndarray:
        velocity = LATE * np.max(np.abs(course.v))
        return np.asarray(EXCESS * np.exp(-((np.abs(course.v) / velocity) ** exponent)) * np.sign(course.v))

    log, robot = write_case(folder, Machine(noise=0.1, hidden={WRIST: fading}), seed=6, seconds=25.0, rate=120.0)
    gap = measure_gap(read_log(log), read_robot(robot))
    start = Site(WRIST, (LATE * float(gap.motion.top_speed[WRIST]), 1.0))
    return own_shape(build_model(gap, usual_nuisance(gap), ()), Chosen(Stribeck(), start))


def test_where_the_best_exponent_leaves_a_little_too_much_at_the_end_a_usual_one_is_taken(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    flat = 0.85 * min(EXPONENTS)
    best = best_of_its_own(tmp_path / "late", flat)
    assert best is not None
    assert min(EXPONENTS) <= best.site.shape[1] <= max(EXPONENTS)
    monkeypatch.setattr(Stribeck, "usual_bounds", lambda *_: [])
    assert best_of_its_own(tmp_path / "refused", flat) is None


def test_a_level_that_falls_like_a_step_has_no_usual_exponent(tmp_path: Path) -> None:
    assert best_of_its_own(tmp_path, 8.0) is None
