"""A log the stated robot explains has no finding, however noisy and wherever its velocity comes from."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet
import pytest

from mjfriction.diagnose.diagnosis import diagnose_log
from mjfriction.diagnose.tell.outcome import Verdict
from mjfriction.diagnose.tell.verdict import STRUCTURED
from mjfriction.identify import measure
from mjfriction.identify.measure import measure_gap
from mjfriction.identify.protocol import plan_excitation
from mjfriction.identify.structure import find_structure
from mjfriction.plant.machine import simulate
from mjfriction.plant.sensors import Recorder
from mjfriction.record.readers import read_log
from mjfriction.record.readers.table import log_from_table
from mjfriction.robot.files import read_robot
from tests.deep import deep
from tests.hidden.closed_loop import record_closed_loop
from tests.hidden.machine import Machine, record, write_case


@pytest.mark.parametrize("velocity", ["none", deep("clean"), "noisy"])
@pytest.mark.parametrize("noise", [deep(0.0), 0.02, deep(0.1), deep(0.2), deep(0.5)])
def test_no_finding(noise: float, velocity: str, tmp_path: Path) -> None:
    log, robot = write_case(tmp_path, Machine(noise=noise, velocity=velocity), seed=5)
    diagnosis = diagnose_log(read_log(log), read_robot(robot))
    assert diagnosis.findings == ()
    assert diagnosis.verdict is Verdict.CONSISTENT


@pytest.mark.parametrize("seed", [0, *map(deep, range(1, 6))])
def test_no_finding_when_stated_friction_is_a_few_percent_off(seed: int, tmp_path: Path) -> None:
    log, robot = write_case(tmp_path, Machine(), seed=40 + seed, off=0.03)
    assert diagnose_log(read_log(log), read_robot(robot)).findings == ()


def test_joints_that_stick_and_break_loose_have_no_finding(tmp_path: Path) -> None:
    log = tmp_path / "log.parquet"
    pyarrow.parquet.write_table(record_closed_loop(31), log)
    diagnosis = diagnose_log(read_log(log), read_robot("ur5"))
    assert diagnosis.findings == ()
    assert diagnosis.verdict is Verdict.CONSISTENT


@pytest.mark.deep
@pytest.mark.parametrize(("pauses", "velocity"), [(False, "clean"), deep(True, "none")])
def test_bristles_of_an_ordinary_contact_are_no_finding(pauses: bool, velocity: str, tmp_path: Path) -> None:
    machine = Machine(bristle_travel=3e-4, pauses=pauses, velocity=velocity, noise=0.1)
    log, robot = write_case(tmp_path, machine, seed=6, off=0.03)
    assert diagnose_log(read_log(log), read_robot(robot)).findings == ()


def resting(seed: int) -> pa.Table:
    """Return a log of an arm that goes through a few poses and rests for four fifths of the time, held by friction."""
    machine = Machine(bristle_travel=3e-4, pauses=True, noise=0.1)
    columns, rng = record(machine, seed, seconds=20.0), np.random.default_rng(seed)
    moving = np.any([np.diff(columns[f"position.{joint}"], n=20) for joint in machine.joints], axis=0)
    end = np.flatnonzero(~moving)[-1] + 20  # of the last rest
    columns = {name: values[:end] for name, values in columns.items()}
    count = columns["time"].size
    rest = {name: np.full(4 * count, values[-1]) for name, values in columns.items()}
    rest["time"] = columns["time"][-1] + columns["time"][1] * np.arange(1, 4 * count + 1)
    for joint, coulomb in zip(machine.joints, machine.coulomb, strict=True):
        held = np.mean(columns[f"effort.{joint}"][-10:])
        rest[f"effort.{joint}"] = held + 0.1 * coulomb * rng.normal(size=4 * count)
    return pa.table({name: np.append(values, rest[name]) for name, values in columns.items()})


@pytest.mark.deep
def test_what_an_arm_holds_that_rests_for_most_of_the_time_is_no_error(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    _, robot = write_case(tmp_path, Machine(), seed=6, seconds=4.0)
    log = log_from_table(resting(6), "resting")

    def worst() -> float:
        measured = measure_gap(log, read_robot(robot))
        return max(measured.rms(measured.residual[:, i], i) / measured.noise_floor[i] for i in measured.examined)

    assert worst() < 5.0  # what the bristles, which are not stated, leave beside the rests
    assert diagnose_log(log, read_robot(robot)).verdict is Verdict.CONSISTENT
    monkeypatch.setattr(measure, "ENOUGH_CLEAR", log.time.size)
    monkeypatch.setattr(measure, "WITHIN", np.inf)  # then it is judged on its rests too
    assert worst() > 10.0


def test_what_joints_hold_at_their_rests_is_no_structure(tmp_path: Path) -> None:
    _, robot = write_case(tmp_path, Machine(), seed=6, seconds=4.0)
    measured = measure_gap(log_from_table(resting(6), "resting"), read_robot(robot))
    assert max(entry.share for entry in find_structure(measured, measured.residual)) < STRUCTURED
    at_rest = replace(measured, clear=np.ones_like(measured.clear))
    assert max(entry.share for entry in find_structure(at_rest, measured.residual)) > STRUCTURED


def test_a_drive_that_reports_nothing_is_not_examined(tmp_path: Path) -> None:
    log, robot = write_case(tmp_path, Machine(), seed=4)
    table = pyarrow.parquet.read_table(log)
    place = table.schema.get_field_index("effort.wrist_3_joint")
    dead = table.set_column(place, "effort.wrist_3_joint", pa.array([0.0] * table.num_rows))
    pyarrow.parquet.write_table(dead, log)
    diagnosis = diagnose_log(read_log(log), read_robot(robot))
    assert diagnosis.not_examined == ("wrist_3_joint",)
    assert diagnosis.findings == ()


@pytest.mark.parametrize("robot", [deep("ur5"), "z1"])
def test_a_simulation_without_noise_of_its_sensors_has_no_finding(robot: str) -> None:
    # What a user tries first.  What steps of 1 ms leave is a thousandth of the effort, and far above a noise of zero.
    stated = read_robot(robot)
    log = simulate(stated, plan_excitation(stated, 60.0).trajectory, recorder=Recorder(500.0))
    diagnosis = diagnose_log(log_from_table(pa.table(log), "log"), stated)
    assert diagnosis.findings == ()
    assert diagnosis.verdict is Verdict.CONSISTENT
