"""A log at fault that says how it should have been read tells of its machine what a sound one does."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from mjfriction.benchmark.cases import Setting, make_case
from mjfriction.cli.logs import read_logs
from mjfriction.diagnose import mend
from mjfriction.diagnose.diagnosis import diagnose_log
from mjfriction.diagnose.mend import audited
from mjfriction.diagnose.misplaced import find_misplaced
from mjfriction.diagnose.outcome import Diagnosis, Finding, Verdict
from mjfriction.diagnose.read_so import read_so
from mjfriction.errors import LogError
from mjfriction.identify.gap import measure_gap
from mjfriction.record.faults import Fault, Mend
from mjfriction.record.log import Log
from mjfriction.record.readers import read_log
from mjfriction.record.readers.table import log_from_table
from mjfriction.report.inspected import inspected_table
from mjfriction.report.result import make_report
from mjfriction.robot.files import read_robot
from mjfriction.robot.robot import Robot
from tests.hidden.machine import UR5_JOINTS, Instant, Machine, write_case

Columns = dict[str, np.ndarray]
Damage = Callable[[Columns], Columns]
ELBOW, WRIST, LIFT = "elbow_joint", "wrist_1_joint", "shoulder_lift_joint"
EXACT = 1e-6  # of a parameter: what conversion there and back leaves of one


def falling(at: Instant) -> np.ndarray:
    return 4.0 * np.exp(-((at.v / 0.12) ** 2)) * np.sign(at.v)


@pytest.fixture(scope="module")
def case(tmp_path_factory: pytest.TempPathFactory) -> tuple[Log, Robot]:
    machine = Machine(hidden={2: falling}, velocity="noisy")
    log, robot = write_case(tmp_path_factory.mktemp("case"), machine, seed=12, seconds=25.0)
    return read_log(log), with_drive(read_robot(robot), 2, gear_ratio=101.0)


def with_drive(robot: Robot, joint: int, **values: float) -> Robot:
    table = robot.table.joint[joint]
    return robot.with_joint(table.model_copy(update={"actuator": table.actuator.model_copy(update=values)}))


@pytest.fixture(scope="module")
def sound(case: tuple[Log, Robot]) -> Finding:
    (finding,) = diagnose_log(*case).findings
    assert (finding.cause, finding.joint) == ("friction.stribeck", ELBOW)
    return finding


def damaged(log: Log, damage: Damage) -> Log:
    return replace(log, columns={**log.columns, **damage(dict(log.columns))})


def turned(*names: str) -> Damage:
    return lambda columns: {name: -columns[name] for name in names}


def scaled(factor: float, *names: str) -> Damage:
    return lambda columns: {name: factor * columns[name] for name in names}


def exchanged(*pairs: tuple[str, str]) -> Damage:
    return lambda columns: {
        own: columns[source] for one, other in pairs for own, source in ((one, other), (other, one))
    }


def of_all(quantity: str) -> list[str]:
    return [f"{quantity}.{joint}" for joint in UR5_JOINTS]


@pytest.mark.parametrize(
    ("damage", "kind"),
    [
        (turned(f"effort.{ELBOW}"), "data.sign"),
        (turned(f"position.{ELBOW}"), "data.sign"),
        (turned(f"position.{ELBOW}", f"velocity.{ELBOW}"), "data.sign"),
        (turned(*(f"{quantity}.{ELBOW}" for quantity in ("position", "velocity", "effort"))), "data.sign"),
        (scaled(1000.0, f"effort.{WRIST}"), "data.unit"),
        (scaled(1.0 / 101.0, f"effort.{ELBOW}"), "data.unit"),
        (scaled(180.0 / np.pi, *of_all("position")), "data.unit"),
        (scaled(180.0 / np.pi, *of_all("position"), *of_all("velocity")), "data.unit"),
        (exchanged((f"effort.{ELBOW}", f"effort.{WRIST}")), "data.swap"),
        (exchanged(*((f"{own}.{ELBOW}", f"{own}.{LIFT}") for own in ("position", "velocity"))), "data.swap"),
        (exchanged(*((f"{own}.{ELBOW}", f"{own}.{LIFT}") for own in ("position", "velocity", "effort"))), "data.swap"),
        (lambda columns: turned(f"effort.{WRIST}")(columns) | scaled(1e3, f"effort.{LIFT}")(columns), "data.unit"),
    ],
)
def test_what_is_hidden_beside_a_fault_is_what_a_sound_log_shows(
    damage: Damage, kind: str, case: tuple[Log, Robot], sound: Finding
) -> None:
    log, robot = case
    diagnosis = diagnose_log(damaged(log, damage), robot)
    assert diagnosis.verdict is Verdict.BAD_DATA
    assert kind in {fault.kind for fault in diagnosis.faults}
    assert all(fault.action.endswith("(read so here)") for fault in diagnosis.faults)
    assert_same(diagnosis, sound)
    assert "The log itself is at fault" in diagnosis.summary
    assert "lacks friction.stribeck at elbow_joint" in diagnosis.summary


def assert_same(diagnosis: Diagnosis, sound: Finding) -> None:
    (finding,) = diagnosis.findings
    assert (finding.cause, finding.joint) == (sound.cause, sound.joint)
    for own, other in zip(finding.parameters, sound.parameters, strict=True):
        assert own.value == pytest.approx(other.value, rel=EXACT)


def test_what_has_no_known_unit_is_refused_and_so_is_what_stands_beside_it(case: tuple[Log, Robot]) -> None:
    log, robot = case
    wrong = scaled(37.0, f"effort.{WRIST}")
    for damage in (wrong, lambda columns: wrong(columns) | turned(f"effort.{ELBOW}")(columns)):
        diagnosis = diagnose_log(damaged(log, damage), robot)
        assert diagnosis.refused
        assert diagnosis.verdict is Verdict.BAD_DATA
        assert diagnosis.findings == ()
        assert "nothing was fitted" in diagnosis.summary
        assert diagnosis.robot.table == diagnosis.gap.robot.table
        assert make_report(diagnosis).refused


def test_one_of_two_logs_is_mended_alone(case: tuple[Log, Robot], tmp_path: Path, sound: Finding) -> None:
    log, robot = case
    late = log.time >= 0.5 * (log.time[0] + log.time[-1])
    names = [f"{quantity}.{ELBOW}" for quantity in ("position", "velocity")]
    columns = {**log.columns, **{name: np.where(late, -1.0, 1.0) * log.columns[name] for name in names}}
    findings = []
    for name, held in (("right", log.columns), ("wrong", columns)):
        paths = []
        for day, own in (("monday", ~late), ("tuesday", late)):
            paths.append(tmp_path / f"{name}_{day}.parquet")
            table = {"time": log.time, **held}
            pq.write_table(pa.table({column: values[own] for column, values in table.items()}), paths[-1])
        diagnosis = diagnose_log(read_logs(paths, robot.joints, None, None), robot)
        findings.append(diagnosis)
    right, wrong = findings
    assert wrong.verdict is Verdict.BAD_DATA
    assert {fault.where for fault in wrong.faults} == {f"position.{ELBOW}, in wrong_tuesday.parquet alone"}
    assert_same(wrong, right.findings[0])


def test_a_velocity_that_is_right_stays_as_it_is(case: tuple[Log, Robot]) -> None:
    log, robot = case
    names = [f"{quantity}.{ELBOW}" for quantity in ("position", "velocity")]
    alone, both = (audited(damaged(log, turned(*own)), robot).gap.log for own in (names[:1], names))
    for read in (alone, both):
        for name in names:
            np.testing.assert_array_equal(read.columns[name], log.columns[name])


def test_a_mend_that_fits_worse_is_none(case: tuple[Log, Robot], monkeypatch: pytest.MonkeyPatch) -> None:
    log, robot = case
    wrong = Fault("data.sign", ELBOW, "turn it", mend=Mend(factors=((f"effort.{ELBOW}", -1.0),)))
    faults = iter([[wrong], []])
    monkeypatch.setattr(mend, "find_faults", lambda _: next(faults))
    audit = audited(log, robot)
    assert audit.refused
    np.testing.assert_array_equal(audit.gap.log.columns[f"effort.{ELBOW}"], log.columns[f"effort.{ELBOW}"])


def test_a_mend_that_leaves_its_fault_is_none_and_is_told_once(
    case: tuple[Log, Robot], monkeypatch: pytest.MonkeyPatch
) -> None:
    log, robot = case
    idle = Fault("data.sign", ELBOW, "turn it", mend=Mend())
    monkeypatch.setattr(mend, "find_faults", lambda _: [idle])
    audit = audited(log, robot)
    assert audit.refused
    assert audit.faults == (idle,)


def test_a_mend_that_leaves_no_log_is_none(case: tuple[Log, Robot]) -> None:
    log, robot = case
    still = Fault(
        "data.unit", "position", "convert it", mend=Mend(factors=tuple((name, 0.0) for name in of_all("position")))
    )
    with pytest.raises(LogError):
        read_so(measure_gap(log, robot), [still.mend], robot)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(mend, "find_faults", lambda _: [still])
        assert audited(log, robot).refused


@pytest.mark.parametrize(
    "damage",
    [
        scaled(101.0, f"position.{ELBOW}"),  # at the motor
        scaled(101.0, *of_all("position")),
        scaled(200.0 / np.pi, *of_all("position")),  # gradians
        lambda columns: {f"position.{ELBOW}": columns[f"position.{ELBOW}"] + 6.0 * np.pi},  # three turns off
    ],
)
def test_positions_beyond_limits_that_are_no_degrees_are_refused(damage: Damage, case: tuple[Log, Robot]) -> None:
    log, robot = case
    without = {name: own for name, own in log.columns.items() if not name.startswith("velocity.")}
    assert audited(damaged(replace(log, columns=without), damage), robot).refused


@pytest.mark.parametrize("swing", [0.0, 0.14])
def test_a_joint_that_hardly_moves_is_in_degrees_as_all_others_are(swing: float, tmp_path: Path) -> None:
    # Some fifteen degrees, or eight about that, are within any limits in radians.
    path, robot = write_case(tmp_path, Machine(), seed=12, seconds=25.0)
    log, still = read_log(path), "position.wrist_2_joint"
    columns = {**log.columns, still: 0.26 + swing / np.ptp(log.columns[still]) * log.columns[still]}
    sound = replace(log, columns=columns)
    wrong = damaged(sound, scaled(180.0 / np.pi, *of_all("position")))
    read = audited(wrong, read_robot(robot)).gap.log
    for name in of_all("position"):
        np.testing.assert_allclose(read.columns[name], columns[name], rtol=1e-12)


def test_one_log_of_two_in_degrees_is_read_so_alone(case: tuple[Log, Robot]) -> None:
    log, robot = case
    half = float(log.time[log.time.size // 2])
    joined = replace(log, joined=(("monday", float(log.time[0])), ("tuesday", half)))
    late = np.where(log.time >= half, 180.0 / np.pi, 1.0)
    names = [*of_all("position"), *of_all("velocity")]
    audit = audited(damaged(joined, lambda columns: {name: late * columns[name] for name in names}), robot)
    assert not audit.refused
    assert {fault.where for fault in audit.faults} == {f"{name}, in tuesday alone" for name in of_all("position")}
    for name in names:
        np.testing.assert_allclose(audit.gap.log.columns[name], log.columns[name], rtol=1e-12)


def test_a_sign_that_may_be_of_two_columns_is_not_turned() -> None:
    sliding = make_case(2, Setting(robot="linear_axis", seconds=20.0, rate=250.0), (), 1.0)
    columns = {name: -own if name.startswith("position") else own for name, own in sliding.log.items()}
    audit = audited(log_from_table(pa.table(columns), "sliding"), sliding.stated)
    assert audit.refused
    assert "or of the positions" in audit.faults[0].action


def test_no_motion_is_planned_for_a_machine_whose_joints_are_counted_otherwise(case: tuple[Log, Robot]) -> None:
    log, robot = case
    for name, otherwise in ((f"effort.{ELBOW}", False), (f"position.{ELBOW}", True)):
        audit = audited(damaged(log, turned(name)), robot)
        assert not audit.refused
        assert audit.moved_otherwise is otherwise


def test_currents_of_other_gears_are_known_as_exchanged(case: tuple[Log, Robot]) -> None:
    # A current that stands at another joint is not that joint's effort: their gears differ.
    log, robot = case
    worth = {}
    for k, joint in enumerate(UR5_JOINTS):
        robot = with_drive(robot, k, gear_ratio=30.0 + 40.0 * k, torque_constant=0.1)
        worth[joint] = robot.table.joint[k].actuator.effort_per_ampere
    columns = {name: values for name, values in log.columns.items() if not name.startswith("effort.")}
    columns |= {f"current.{joint}": log.columns[f"effort.{joint}"] / worth[joint] for joint in UR5_JOINTS}
    swapped = exchanged((f"current.{ELBOW}", f"current.{LIFT}"))(columns)
    gap = measure_gap(replace(log, columns={**columns, **swapped}), robot)
    (fault,) = find_misplaced(gap)
    assert (fault.kind, fault.where) == ("data.swap", f"current.{ELBOW} and that of {LIFT}")
    assert not audited(gap.log, robot).refused


def test_what_a_mended_log_could_show_is_told(case: tuple[Log, Robot]) -> None:
    log, robot = case
    whole, mended, refused = (
        inspected_table(damaged(log, damage), robot)
        for damage in (lambda _: {}, turned(f"effort.{ELBOW}"), scaled(37.0, f"effort.{ELBOW}"))
    )
    assert mended["could_show"] == whole["could_show"]
    assert [entry["kind"] for entry in mended["data_problems"]] == ["data.sign"]
    assert refused["could_show"] == []
