"""The proof in motion: driven by the log's efforts, the extended robot goes where the machine went."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pyarrow as pa
import pytest
from numpy.typing import NDArray

from mjfriction.benchmark.cases import Case, Setting, draw_of, make_case
from mjfriction.diagnose.diagnosis import diagnose_log
from mjfriction.diagnose.fit.model import Model
from mjfriction.diagnose.tell import free_run
from mjfriction.diagnose.tell.free_run import SECONDS
from mjfriction.diagnose.tell.outcome import Verdict
from mjfriction.identify import stretches
from mjfriction.identify.gap import Gap
from mjfriction.identify.measure import gap_of, measure_gap
from mjfriction.identify.stretches import Cuts, Stretches, simulated_error, stretches_at
from mjfriction.record.log import Floats, Log
from mjfriction.record.readers.table import log_from_table
from mjfriction.report.result import make_report
from mjfriction.robot.files import read_robot
from mjfriction.robot.robot import Robot
from tests.diagnose.test_needless import CARRIAGES, ROBOT

SETTING = Setting(seconds=30.0, rate=250.0)


def log_of(case: Case) -> Log:
    return log_from_table(pa.table(case.log), "case")


@pytest.mark.deep
@pytest.mark.parametrize("cause", ["drive.cogging", "friction.load", "body.spring", "body.payload"])
def test_the_extended_robot_goes_where_the_hidden_machine_does(cause: str) -> None:
    # Of a cause in MuJoCo's model, or beside it: in a friction law, along the stroke, a spring, a load.
    case = make_case(7, SETTING, (draw_of(cause),), 6.0)
    diagnosis = diagnose_log(log_of(case), case.stated)
    assert [(one.cause, one.joint) for one in diagnosis.findings] == [(cause, case.hidden[0].joint)]
    run, gap = diagnosis.free_run, diagnosis.gap
    assert run is not None
    joint = gap.robot.joints.index(diagnosis.findings[0].shown_at)
    own, _ = simulated_error(gap_of(case.machine, gap), case.machine, SECONDS)
    gain = run.gains[joint]
    assert gain.low > 0.0
    assert gain.after < 1.3 * own[joint]
    assert gain.before > 1.5 * own[joint]
    # Nothing moves joints that have nothing hidden, beyond what this one does to them.
    for other, quiet in run.gains.items():
        assert quiet.after < 1.3 * own[other], other


def test_each_run_is_within_one_stretch_of_its_block_though_repetitions_share_blocks(tmp_path: Path) -> None:
    """A carriage goes through one cycle forty times: a block holds stretches of more than one of them."""
    time = np.arange(40 * 800) / 400.0
    phase = 2.0 * np.pi * time / 2.0
    table = {"time": time, "position.x": 0.1 * np.sin(phase), "position.y": 0.1 * np.sin(2.0 * phase)}
    (tmp_path / "carriages.xml").write_text(CARRIAGES, encoding="utf-8")
    (tmp_path / "robot.toml").write_text(ROBOT, encoding="utf-8")
    noise = np.random.default_rng(1).normal(size=(2, time.size))
    efforts = {"effort.x": 10.0 * np.cos(phase) + noise[0], "effort.y": 8.0 * np.cos(2.0 * phase) + noise[1]}
    gap = measure_gap(log_from_table(pa.table(table | efforts), "cycles"), read_robot(tmp_path / "robot.toml"))
    assert np.any(np.diff(gap.blocks.row) < 0)
    cuts, block = free_run._one_in_each_block(gap)
    assert block.size > 0.8 * gap.blocks.count
    for begin, own in zip(cuts.begins, block, strict=True):
        first, last = gap.motion.time[[begin, begin + cuts.length - 1]]
        within = (gap.chain.time >= first) & (gap.chain.time <= last)
        assert np.all(gap.blocks.row[within] == own)


@pytest.mark.deep
def test_where_nothing_is_hidden_nothing_is_gained() -> None:
    case = make_case(7, SETTING, (), 1.0)
    diagnosis = diagnose_log(log_of(case), case.stated)
    assert diagnosis.verdict is Verdict.CONSISTENT
    assert diagnosis.free_run is not None
    for gain in diagnosis.free_run.gains.values():
        assert abs(gain.reduction) < 0.05


@pytest.mark.deep
def test_no_run_is_on_motion_that_its_robots_strengths_were_fitted_to(monkeypatch: pytest.MonkeyPatch) -> None:
    case = make_case(7, SETTING, (draw_of("friction.load"),), 6.0)
    fitted: list[NDArray[np.bool_]] = []
    driven: list[Floats] = []
    whole, at = Model.built_from, free_run.stretches_at

    def spied(model: Model, training: NDArray[np.bool_] | None = None) -> Floats:
        fitted.extend([] if training is None else [training])
        return whole(model, training)

    def watched(gap: Gap, robot: Robot, cuts: Cuts) -> Stretches:
        driven.append(gap.motion.time[cuts.begins])
        return at(gap, robot, cuts)

    monkeypatch.setattr(Model, "built_from", spied)
    monkeypatch.setattr(free_run, "stretches_at", watched)
    gap = diagnose_log(log_of(case), case.stated).gap
    _, *runs = driven  # the stated robot's first
    assert len(fitted) == len(runs) == len(gap.blocks.folds)
    for training, begins in zip(fitted, runs, strict=True):
        block = gap.blocks.row[np.searchsorted(gap.chain.time, begins)]
        assert not np.any(training[block])
    assert sum(begins.size for begins in runs) == driven[0].size


def test_efforts_that_say_nothing_drive_nothing() -> None:
    case = make_case(7, SETTING, (), 1.0)
    log = log_of(case)
    clipped = (log.time > 10.0) & (log.time < 14.0)
    gap = measure_gap(replace(log, unusable={f"effort.{case.stated.joints[2]}": clipped}), case.stated)
    begins = gap.motion.time[free_run._one_in_each_block(gap)[0].begins]
    assert begins.size > 15
    assert not np.any((begins > 10.0 - SECONDS) & (begins < 14.0))


@pytest.mark.deep
def test_a_cause_that_is_none_without_a_part_of_the_log_is_told_of_and_not_driven(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    case = make_case(7, SETTING, (draw_of("friction.load"),), 6.0)
    whole = Model.built_from

    def turned(model: Model, training: NDArray[np.bool_] | None = None) -> Floats:
        strengths = whole(model, training)
        return strengths if training is None else -strengths

    monkeypatch.setattr(Model, "built_from", turned)
    diagnosis = diagnose_log(log_of(case), case.stated)
    assert [one.cause for one in diagnosis.findings] == ["friction.load"]
    assert diagnosis.free_run is None
    assert diagnosis.not_run == "friction.load comes out as nature does not allow without a part of the log"


@pytest.mark.deep
def test_an_arm_that_cannot_be_driven_is_diagnosed_all_the_same() -> None:
    case = make_case(7, SETTING, (draw_of("friction.load"),), 6.0)
    log, lost = log_of(case), next(name for name in case.stated.joints if name != case.hidden[0].joint)
    unheard = replace(log, columns={name: own for name, own in log.columns.items() if name != f"effort.{lost}"})
    diagnosis = diagnose_log(unheard, case.stated)
    assert [one.cause for one in diagnosis.findings] == ["friction.load"]
    report = make_report(diagnosis)
    assert report.simulation is None
    assert report.driven == f"Not driven in MuJoCo: {report.not_simulated}."
    assert f"the efforts of all joints, and {lost} has none" in report.driven


@pytest.mark.deep
def test_what_lies_around_a_stretch_ends_with_its_segment() -> None:
    # One sample of the segment before, by itself, has no derivatives: the simulation had no end to begin from.
    case = make_case(7, replace(SETTING, seconds=8.0), (draw_of("drive.elasticity"),), 6.0)
    log = log_of(case)
    gap = measure_gap(replace(log, segment=(log.time > 4.0).astype(np.int64)), case.machine)
    first = int(np.flatnonzero(gap.motion.piece == 1)[0])
    margin = int(np.ceil(stretches.BEFORE * gap.motion.rate))
    begins = np.array([first + margin - 1])
    there = stretches_at(gap, case.machine, Cuts(begins, 20))
    assert np.all(np.isfinite(there.reported))
    around, at = stretches._around(gap.motion, Cuts(begins, 20))
    assert len(around.pieces) == 1
    np.testing.assert_array_equal(around.position[at], gap.motion.position[begins])
