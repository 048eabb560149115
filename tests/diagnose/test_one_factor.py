"""Both levels of a joint that carries nothing, off by one factor: its drive's torque constant may be off instead."""

from __future__ import annotations

import functools
from pathlib import Path

import numpy as np
import pyarrow as pa
import pytest

from mjfriction.diagnose.diagnosis import diagnose_log
from mjfriction.diagnose.tell.outcome import Diagnosis
from mjfriction.record.readers.table import log_from_table
from mjfriction.robot.files import read_robot
from tests.hidden.machine import UR5_COULOMB, UR5_VISCOUS, Machine, record, robot_toml

WRIST, FACTOR = 5, 1.3
JOINT = "wrist_3_joint"
LEVELS, CONSTANT = "friction.coulomb_viscous", "drive.torque_constant"


@functools.cache
def log(kind: str):
    hidden = {}
    if kind == "levels apart":
        more, less = 0.5 * UR5_COULOMB[WRIST], -0.25 * UR5_VISCOUS[WRIST]
        hidden = {WRIST: lambda i: more * np.sign(i.v) + less * i.v}
    columns = record(Machine(noise=0.1, hidden=hidden), 31, 50.0)
    if kind == "constant":
        columns[f"effort.{JOINT}"] = FACTOR * columns[f"effort.{JOINT}"]
    return log_from_table(pa.table(columns), kind)


def diagnosed(kind: str, seed: int, folder: Path) -> Diagnosis:
    (folder / "robot.toml").write_text(robot_toml(Machine(noise=0.1), off=0.03, seed=seed), encoding="utf-8")
    return diagnose_log(log(kind), read_robot(folder / "robot.toml"))


@pytest.mark.deep
def test_a_constant_that_is_off_is_named_where_stated_levels_are_a_little_off_too(tmp_path: Path) -> None:
    (finding,) = diagnosed("constant", 1, tmp_path).findings
    assert finding.joint == JOINT
    assert (finding.cause, *finding.alternatives) == (CONSTANT, LEVELS)
    assert finding.confidence <= 0.5  # nothing but their agreement tells a factor from two levels
    (factor,) = finding.parameters
    assert abs(factor.value / FACTOR - 1.0) < 0.05


@pytest.mark.deep
def test_levels_that_are_off_each_by_its_own_are_no_constant(tmp_path: Path) -> None:
    (finding,) = diagnosed("levels apart", 1, tmp_path).findings
    assert (finding.cause, finding.joint) == (LEVELS, JOINT)
    assert CONSTANT not in finding.alternatives
    assert finding.confidence > 0.8
