"""How near drives and links are to what is stated is seen from themselves, and one that is not stands out."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pyarrow as pa
import pytest
from scipy.optimize import minimize_scalar
from scipy.stats import norm

from mjfriction.benchmark.cases import Case, Setting, draw_of, make_case
from mjfriction.diagnose.diagnosis import diagnose_log
from mjfriction.diagnose.fit import nearness as module
from mjfriction.diagnose.fit.intervals import half_widths
from mjfriction.diagnose.fit.nearness import FARTHEST, NEAREST, Nearness, nearness
from mjfriction.diagnose.tell import findings
from mjfriction.diagnose.tell.outcome import Finding
from mjfriction.identify.normal import Normal, Part, Products
from mjfriction.record.readers.table import log_from_table

USUAL = 0.03


def near(off: np.ndarray, information: float = 1e12, *, let_go: bool = False) -> Nearness:
    """Return how near numbers (k,) are, of each of which a motion tells so much alone."""
    gram = np.full(off.size, information)
    part = Part(np.arange(off.size), np.diag(gram)[None], (gram * off)[None], np.array([1.0]))
    stated = SimpleNamespace(of_stated=slice(0, off.size), inertias=let_go or None)
    return nearness(stated, Normal(Products((part,), off.size), np.full(off.size, USUAL**-2.0)))


def test_the_spread_is_the_one_that_makes_them_likeliest() -> None:
    off = USUAL * np.random.default_rng(0).normal(scale=0.6, size=12)

    def unlikely(spread: float) -> float:
        return -2.0 * float(np.sum(norm.logpdf(off, scale=spread * USUAL) - norm.logpdf(0.0, scale=USUAL)))

    best = minimize_scalar(unlikely, bounds=(NEAREST, FARTHEST), method="bounded")
    own = near(off)
    assert own.shown == pytest.approx(off.size)
    assert own.spread == pytest.approx(best.x, rel=1e-3)
    assert own.strain == pytest.approx(best.fun, rel=1e-6)


def test_none_is_believed_to_be_nearer_or_farther_off_than_robots_are() -> None:
    exact, wrong = near(np.full(9, 0.001 * USUAL)), near(np.full(9, 5.0 * USUAL))
    assert exact.spread == pytest.approx(NEAREST)
    assert wrong.spread == pytest.approx(FARTHEST)


def test_one_that_is_off_beside_others_that_are_not_is_less_likely_than_its_distance_says() -> None:
    off = np.array([5.0, *[0.4] * 11]) * USUAL
    alone = near(off).strain - near(off[1:]).strain
    assert alone > 1.2 * 5.0**2
    # Of a robot that is off throughout it is more likely.
    off = np.array([5.0, *[2.5] * 11]) * USUAL
    assert near(off).strain - near(off[1:]).strain < 0.4 * 5.0**2


def test_what_no_motion_shows_and_what_is_let_go_is_near_to_nothing() -> None:
    off = np.full(5, USUAL)
    assert near(off, 1e-9).shown == pytest.approx(0.0, abs=1e-6)
    assert near(off, let_go=True).spread == 1.0


def with_a_wrong_link(robot: str, seed: int, seconds: float, severity: float, noise: float = 0.2) -> Case:
    setting = Setting(robot, seconds=seconds, rate=125.0, noise=noise, off=0.03)
    return make_case(seed, setting, (draw_of("body.link_inertia"),), severity)


def found(case: Case) -> list[Finding]:
    return list(diagnose_log(log_from_table(pa.table(case.log), "case"), case.stated).findings)


@pytest.mark.deep
def test_a_link_that_others_could_stand_in_for_stands_out_where_these_are_nearly_right(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    # All links within what a stated one may be off by do as well on motion not fitted.
    case = with_a_wrong_link("z1", 7, 30.0, 2.2)
    ((link, scale),) = case.machine.table.link_scale.items()
    true = scale / case.stated.table.link_scale[link]

    (finding,) = found(case)
    assert finding.cause == "body.link_inertia"
    (value,) = finding.parameters
    assert value.name == f"link_scale.{link}"
    # Other links are off as well, which the log does not tell: by that the interval is wider.
    assert value.low < true < value.high
    with monkeypatch.context() as patch:
        patch.setattr(findings, "widths_told", half_widths)
        assert not found(case)[0].parameters[0].low < true
    monkeypatch.setattr(module, "NEAREST", 1.0)
    assert not found(case)


@pytest.mark.deep
@pytest.mark.parametrize(
    ("robot", "seed", "seconds", "severity", "noise"),
    [
        ("ur5", 5, 24.0, 1.2, 0.2),  # it makes next to nothing where most of the error went, and more elsewhere
        ("z1", 4, 30.0, 1.6, 0.2),  # beside it all others do as well as they are stated
        ("z1", 4, 30.0, 2.2, 0.2),  # all others are nearly right
        ("ur10", 2, 30.0, 2.5, 0.1),  # let go at once, all bear a part of it
    ],
)
def test_it_is_found_though_hardly_any_error_is_left_for_it(
    robot: str, seed: int, seconds: float, severity: float, noise: float
) -> None:
    case = with_a_wrong_link(robot, seed, seconds, severity, noise)
    (finding,) = found(case)
    ((link, scale),) = case.machine.table.link_scale.items()
    assert finding.cause == "body.link_inertia"
    (value,) = finding.parameters
    assert value.name == f"link_scale.{link}"
    assert value.low < scale / case.stated.table.link_scale[link] < value.high
