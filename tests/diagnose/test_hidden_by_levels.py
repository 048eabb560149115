"""A curve over speed that refitted levels hide: they take up most of it, and are not off by enough to be told."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from mjfriction.diagnose.causes.catalog import STRUCTURAL
from mjfriction.diagnose.causes.viscous_nonlinear import ViscousNonlinear
from mjfriction.diagnose.fit.exact import level_changes, usual_nuisance
from mjfriction.diagnose.fit.model import Model, build_model
from mjfriction.diagnose.search.field import make_field
from mjfriction.diagnose.settle import hidden_curve, stated
from mjfriction.diagnose.settle.stated import settle
from mjfriction.identify.measure import measure_gap, thinned
from mjfriction.record.readers import read_log
from mjfriction.robot.files import read_robot
from tests.hidden.machine import Effect, Instant, Machine, write_case

WRIST = 5
QUADRATIC = 0.12  # N·m·s²/rad²


def bent(at: Instant) -> np.ndarray:
    return QUADRATIC * at.v * np.abs(at.v)


def heavier(at: Instant) -> np.ndarray:
    return 0.06 * at.friction


def refitted(folder: Path, effect: Effect, noise: float = 0.02) -> Model:
    """The stated robot, friction a few percent off everywhere, with its levels refitted and no cause found."""
    machine = Machine(noise=noise, hidden={WRIST: effect})
    log, robot = write_case(folder, machine, seed=21, off=0.03, seconds=30.0, rate=100.0)
    gap = thinned(measure_gap(read_log(log), read_robot(robot)))
    model = build_model(gap, usual_nuisance(gap), ())
    assert hidden_curve.SUSPECT < level_changes(model)[WRIST] < stated.LEAST_CHANGE_ROUGH
    return model


def test_it_is_found_beside_levels_that_are_near_what_is_stated(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    model = refitted(tmp_path, bent)
    asked = make_field(model.gap, STRUCTURAL)
    settled = settle(model, asked)
    (curve,) = settled.model.chosen
    assert (type(curve.cause), curve.site.joint) == (ViscousNonlinear, WRIST)
    assert settled.model.strengths_of(curve)[0] == pytest.approx(QUADRATIC, rel=0.4)
    assert not settled.levels
    monkeypatch.setattr(stated, "SUSPECT", 1.0)
    assert not settle(model, asked).model.chosen


def test_where_noise_leaves_levels_as_good_they_stay(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    model = refitted(tmp_path, bent, noise=0.1)
    asked = make_field(model.gap, STRUCTURAL)
    assert not settle(model, asked).model.chosen
    monkeypatch.setattr(hidden_curve, "HALVED", 1.0)
    assert settle(model, asked).model.chosen


def test_levels_that_are_off_alike_hide_none(tmp_path: Path) -> None:
    model = refitted(tmp_path, heavier)
    settled = settle(model, make_field(model.gap, STRUCTURAL))
    assert not settled.model.chosen
    assert not settled.levels
