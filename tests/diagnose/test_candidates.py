"""How candidates are weighed: curved ones near the best on the real balance, shapes that are none of the cause's."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pyarrow as pa
import pytest

from mjfriction.diagnose.causes.saturating_viscous import SaturatingViscous
from mjfriction.diagnose.causes.stribeck import Stribeck
from mjfriction.diagnose.diagnosis import diagnose_log
from mjfriction.diagnose.fit.trial import Trial
from mjfriction.diagnose.search import short_list
from mjfriction.identify.gap import Gap
from mjfriction.identify.measure import measure_gap
from mjfriction.record.readers.table import log_from_table
from mjfriction.robot.files import read_robot
from tests.hidden.machine import Instant, Machine, record, robot_toml


def gap_of(machine: Machine, folder: Path, seed: int = 5) -> Gap:
    (folder / "robot.toml").write_text(robot_toml(machine), encoding="utf-8")
    log = log_from_table(pa.table(record(machine, seed, 30.0)), "log")
    return measure_gap(log, read_robot(folder / "robot.toml"))


def test_shapes_at_their_edge_are_none_of_the_cause(tmp_path: Path) -> None:
    gap = gap_of(Machine(), tmp_path)
    stribeck, thinning = Stribeck(), SaturatingViscous()
    site = stribeck.sites(gap)[0]
    assert stribeck.own_shape(gap, site.shaped((site.shape[0], 2.0)))
    assert not stribeck.own_shape(gap, site.shaped((site.shape[0], 4.0)))  # a step, not a fading level
    site = thinning.sites(gap)[0]
    slow, fast = thinning.shape_bounds(gap, site)[0]
    assert thinning.own_shape(gap, site.shaped((0.5 * (slow + fast),)))
    assert not thinning.own_shape(gap, site.shaped((slow,)))  # a level that a reversal blurs


def level_that_falls_like_a_step(instant: Instant) -> np.ndarray:
    return 2.5 * np.sign(instant.v) * (np.abs(instant.v) < 0.35)


@pytest.mark.deep
def test_a_level_that_falls_like_a_step_is_no_stribeck_curve(tmp_path: Path) -> None:
    machine = Machine(hidden={2: level_that_falls_like_a_step})
    (tmp_path / "robot.toml").write_text(robot_toml(machine), encoding="utf-8")
    log = log_from_table(pa.table(record(machine, 5, 40.0)), "log")
    found = diagnose_log(log, read_robot(tmp_path / "robot.toml"))
    exponents = [p.value for f in found.findings for p in f.parameters if p.name == "stribeck_exponent"]
    assert all(value < 3.9 for value in exponents)


@pytest.mark.deep
def test_the_best_of_curved_rivals_is_taken_on_the_real_balance(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    asked: list[int] = []
    bent = short_list._bent

    def counted(model, trial):
        asked.append(trial.chosen.site.joint)
        return bent(model, trial)

    monkeypatch.setattr(short_list, "_bent", counted)
    stated = Machine()
    (tmp_path / "robot.toml").write_text(robot_toml(stated), encoding="utf-8")

    def heavier(model) -> None:
        body = model.body("wrist_2_link").id
        model.body_mass[body] += 1.0

    log = log_from_table(pa.table(record(Machine(change=heavier), 5, 40.0)), "log")
    found = diagnose_log(log, read_robot(tmp_path / "robot.toml"))
    assert {f.cause for f in found.findings} <= {"body.payload", "body.link_inertia"}
    assert asked, "no curved rivals came near each other"


@pytest.mark.deep
def test_what_makes_too_little_is_listed_as_refitted_and_not_told(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    machine = Machine(hidden={1: lambda i: np.full(i.v.shape, 2.0)})
    (tmp_path / "robot.toml").write_text(robot_toml(machine), encoding="utf-8")
    log = log_from_table(pa.table(record(machine, 5, 40.0)), "log")

    def offsets(least: float) -> tuple[list[str], list[float]]:
        # The bar of what is told alone; the competition keeps its own.
        monkeypatch.setattr("mjfriction.diagnose.tell.untold.negligible", lambda *_: least > 0.0)
        monkeypatch.setattr("mjfriction.diagnose.fit.trial.Trial.passes", passes)
        found = diagnose_log(log, read_robot(tmp_path / "robot.toml"))
        listed = [entry.fitted for entry in found.adjustments if entry.what == "offset"]
        return [finding.cause for finding in found.findings], listed

    def passes(trial: Trial, candidates: int) -> bool:
        return trial.chance < 0.01 / candidates and trial.share > 0.01

    assert offsets(0.0) == (["drive.offset"], [])
    causes, listed = offsets(1.0)
    assert causes == []
    assert listed == [pytest.approx(2.0, abs=0.2)]
