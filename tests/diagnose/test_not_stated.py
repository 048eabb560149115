"""Friction that a robot file does not state at all is told, whatever else its joint has."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from scipy.signal import butter, sosfiltfilt

from mjfriction.diagnose.causes.catalog import STATED_LEVELS, STRUCTURAL
from mjfriction.diagnose.causes.cause import Site
from mjfriction.diagnose.diagnosis import diagnose_log
from mjfriction.diagnose.fit import trial
from mjfriction.diagnose.fit.model import Chosen, build_model
from mjfriction.diagnose.fit.nuisance import make_nuisance
from mjfriction.diagnose.fit.trial import try_out
from mjfriction.diagnose.search.field import make_field, size
from mjfriction.diagnose.settle import stated
from mjfriction.identify.gap import Gap
from mjfriction.identify.measure import measure_gap
from mjfriction.record.readers import read_log
from mjfriction.robot.files import read_robot
from tests.hidden.machine import UR5_COULOMB, UR5_JOINTS, UR5_VISCOUS, Machine, record, robot_toml, write_case

ELBOW = 2


def told(folder: Path) -> set[tuple[str, str | None]]:
    machine = Machine(hidden={ELBOW: lambda at: -3.0 * at.v * abs(at.v)}, noise=0.1)
    log, robot = write_case(folder, machine, seed=5)
    text = robot.read_text(encoding="utf-8")
    own = f"coulomb = {UR5_COULOMB[ELBOW]}, viscous = {UR5_VISCOUS[ELBOW]}"
    assert own in text
    robot.write_text(text.replace(own, "coulomb = 0.0, viscous = 0.0"), encoding="utf-8")
    return {(finding.cause, finding.joint) for finding in diagnose_log(read_log(log), read_robot(robot)).findings}


@pytest.mark.deep
def test_it_is_told_beside_a_bend_over_speed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    level, bend = ("friction.coulomb_viscous", UR5_JOINTS[ELBOW]), ("friction.viscous_nonlinear", UR5_JOINTS[ELBOW])
    assert told(tmp_path / "told") == {level, bend}
    monkeypatch.setattr(stated, "AS_MUCH", float("inf"))
    assert told(tmp_path / "bent") == {bend}


def gap_of_few_rows(folder: Path) -> Gap:
    # The drives leave nothing above 2 Hz, so that sixteen seconds are some sixty rows.
    columns = record(Machine(noise=0.1), seed=5, seconds=16.0)
    sos = butter(4, 2.0, fs=250.0, output="sos")
    for joint in UR5_JOINTS:
        columns[f"effort.{joint}"] = sosfiltfilt(sos, columns[f"effort.{joint}"])
    pq.write_table(pa.table(columns), folder / "log.parquet")
    bare = Machine(coulomb=(0.0,) * 6, viscous=(0.0,) * 6)
    (folder / "robot.toml").write_text(robot_toml(bare), encoding="utf-8")
    return measure_gap(read_log(folder / "log.parquet"), read_robot(folder / "robot.toml"))


def test_what_it_explains_is_no_noise_to_stand_out_from(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    gap = gap_of_few_rows(tmp_path)
    assert gap.chain.time.size < 100
    without = build_model(gap, make_nuisance(gap).without_level(ELBOW), ())
    level = Chosen(STATED_LEVELS, Site(ELBOW))
    field = size(make_field(gap, STRUCTURAL))
    told = try_out(without, level)
    assert told is not None
    assert told.passes(field)
    # As if every row were as uncertain as it is without the level.
    monkeypatch.setattr(trial, "_left_of_noise", lambda model, normal: np.ones(normal.joints))
    drowned = try_out(without, level)
    assert drowned is not None
    assert not drowned.passes(field)
