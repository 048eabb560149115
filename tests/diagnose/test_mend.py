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
from mjfriction.diagnose.diagnosis import diagnose_log
from mjfriction.diagnose.faults import mend, misplaced
from mjfriction.diagnose.faults.mend import audited
from mjfriction.diagnose.faults.misplaced import find_misplaced
from mjfriction.diagnose.faults.read_so import off_as_stated, read_so
from mjfriction.diagnose.faults.units import find_units
from mjfriction.diagnose.tell.outcome import Diagnosis, Finding, Verdict
from mjfriction.errors import LogError
from mjfriction.identify.measure import measure_gap
from mjfriction.record.fault import Fault, Mend
from mjfriction.record.log import Log
from mjfriction.record.readers import read_log
from mjfriction.record.readers.table import log_from_table
from mjfriction.record.span import EVER
from mjfriction.report.inspected import inspected_table
from mjfriction.report.result import make_report
from mjfriction.robot.files import read_robot
from mjfriction.robot.robot import Robot
from tests.deep import deep
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
        deep(turned(f"position.{ELBOW}"), "data.sign"),
        deep(turned(f"position.{ELBOW}", f"velocity.{ELBOW}"), "data.sign"),
        deep(turned(*(f"{quantity}.{ELBOW}" for quantity in ("position", "velocity", "effort"))), "data.sign"),
        deep(scaled(1000.0, f"effort.{WRIST}"), "data.unit"),
        deep(scaled(1.0 / 101.0, f"effort.{ELBOW}"), "data.unit"),
        (scaled(180.0 / np.pi, *of_all("position")), "data.unit"),
        deep(scaled(180.0 / np.pi, *of_all("position"), *of_all("velocity")), "data.unit"),
        deep(scaled(180.0 / np.pi, f"position.{ELBOW}", f"velocity.{ELBOW}"), "data.unit"),
        deep(exchanged((f"effort.{ELBOW}", f"effort.{WRIST}")), "data.swap"),
        deep(exchanged(*((f"{own}.{ELBOW}", f"{own}.{LIFT}") for own in ("position", "velocity"))), "data.swap"),
        (exchanged(*((f"{own}.{ELBOW}", f"{own}.{LIFT}") for own in ("position", "velocity", "effort"))), "data.swap"),
        deep(lambda columns: turned(f"effort.{WRIST}")(columns) | scaled(1e3, f"effort.{LIFT}")(columns), "data.unit"),
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


@pytest.mark.deep
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


@pytest.mark.parametrize(("rounds", "refused"), [(3, False), (4, True)])
def test_faults_beside_those_that_were_mended_are_mended_three_times(
    rounds: int, refused: bool, case: tuple[Log, Robot], monkeypatch: pytest.MonkeyPatch
) -> None:
    log, robot = case
    found = iter([[Fault("data.sign", f"{k}", "turn it", mend=Mend())] for k in range(rounds)])
    monkeypatch.setattr(mend, "find_faults", lambda _: next(found, []))
    audit = audited(log, robot)
    assert audit.refused is refused
    assert [fault.where for fault in audit.faults] == (["0"] if refused else ["0", "1", "2"])


def test_a_fault_without_a_mend_is_not_gone_with_another(
    case: tuple[Log, Robot], monkeypatch: pytest.MonkeyPatch
) -> None:
    log, robot = case
    found = iter([[Fault("data.sign", "a", "turn it", mend=Mend()), Fault("data.unit", "b", "convert it")]])
    monkeypatch.setattr(mend, "find_faults", lambda _: next(found, []))
    assert audited(log, robot).refused


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


@pytest.mark.parametrize(("joint", "swing"), [("wrist_2_joint", 0.0), ("wrist_2_joint", 0.14), ("wrist_3_joint", 0.0)])
def test_a_joint_that_hardly_moves_is_in_degrees_as_all_others_are(joint: str, swing: float, tmp_path: Path) -> None:
    # Some fifteen degrees, or eight about that, are within any limits in radians; the last joint carries nothing that
    # would tell.
    path, robot = write_case(tmp_path, Machine(), seed=12, seconds=25.0)
    log, still = read_log(path), f"position.{joint}"
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


def test_degrees_in_one_of_two_logs_are_known_by_its_efforts_alone(case: tuple[Log, Robot]) -> None:
    log, robot = case
    half = float(log.time[log.time.size // 2])
    late = np.where(log.time >= half, 180.0 / np.pi, 1.0)
    wrong = damaged(log, lambda columns: {name: late * columns[name] for name in of_all("position")})
    columns = {name: own for name, own in wrong.columns.items() if not name.startswith("velocity.")}
    segment, joined = (log.time >= half).astype(np.int64), (("first", 0.0), ("second", half))
    gap = measure_gap(replace(wrong, columns=columns, segment=segment, joined=joined), robot)
    endless = replace(gap.body, lower=np.full(6, -np.inf), upper=np.full(6, np.inf))
    faults = find_units(replace(gap, body=endless))
    assert {fault.where for fault in faults} == {f"{name}, in second alone" for name in of_all("position")}
    assert {fault.mend.span for fault in faults if fault.mend} == {(half, np.inf)}


def test_a_reading_is_held_against_the_robot_within_its_span(case: tuple[Log, Robot]) -> None:
    log, robot = case
    half = float(log.time[log.time.size // 2])
    gap = measure_gap(log, robot)
    wrong = read_so(gap, [Mend(factors=((f"effort.{ELBOW}", -1.0),), span=(half, np.inf))], robot)
    early, late = (off_as_stated([gap, wrong], span) for span in ((-np.inf, half - 1.0), (half + 1.0, np.inf)))
    assert early[1] - early[0] == pytest.approx(0.0, abs=0.1)
    assert late[1] - late[0] > 1.0


def test_a_unit_is_told_by_what_other_sizes_leave(case: tuple[Log, Robot], monkeypatch: pytest.MonkeyPatch) -> None:
    # Where friction alone moves with a position, as fast as it may be, any size does as well.
    gap = measure_gap(*case)
    degrees = [Mend(factors=((f"position.{ELBOW}", np.pi / 180.0),))]
    for left, told in (((0.2, 0.2), True), ((0.21, 0.03), True), ((0.01, 0.01), False), ((-0.1, 0.4), False)):
        monkeypatch.setattr(mend, "off_as_stated", lambda _, own=left: np.array([0.0, *own]))
        assert mend._of_their_size(gap, degrees, gap) is told, left


@pytest.mark.parametrize(
    ("gear_ratio", "torque_constant", "factor", "refused"),
    [
        (101.0, None, 1.0 / 101.0, False),
        (101.0, 1.0, 1.0 / 101.0, False),
        (-101.0, None, -1.0 / 101.0, False),
        (101.0, None, -1.0 / 101.0, True),
        (101.0, 1.1, 1.0 / 101.0, True),  # in N·m at the motor, or in A
    ],
)
def test_an_effort_at_the_motor_is_told_by_its_gear_where_nothing_else_is_as_near(
    gear_ratio: float, torque_constant: float | None, factor: float, refused: bool, case: tuple[Log, Robot]
) -> None:
    log, robot = case
    robot = with_drive(robot, 2, gear_ratio=gear_ratio, torque_constant=torque_constant)
    audit = audited(damaged(log, scaled(factor, f"effort.{ELBOW}")), robot)
    assert audit.refused is refused
    assert [fault.kind for fault in audit.faults] == ["data.unit"]


def test_a_current_in_milliamperes_is_read_so(case: tuple[Log, Robot]) -> None:
    log, robot = case
    columns = {name: own for name, own in log.columns.items() if not name.startswith("effort.")}
    for k, joint in enumerate(UR5_JOINTS):
        robot = with_drive(robot, k, gear_ratio=101.0, torque_constant=0.1)
        columns[f"current.{joint}"] = log.columns[f"effort.{joint}"] / 10.1
    wrong = replace(log, columns={**columns, f"current.{ELBOW}": 1e3 * columns[f"current.{ELBOW}"]})
    audit = audited(wrong, robot)
    assert not audit.refused
    assert [(fault.kind, fault.where) for fault in audit.faults] == [("data.unit", f"current.{ELBOW}")]
    np.testing.assert_allclose(audit.gap.log.columns[f"current.{ELBOW}"], columns[f"current.{ELBOW}"], rtol=1e-12)


def test_a_current_that_stands_for_an_effort_is_not_exchanged_with_it(case: tuple[Log, Robot]) -> None:
    log, robot = case
    current = f"current.{LIFT}"
    columns = {**log.columns, current: log.columns[f"effort.{LIFT}"]}
    del columns[f"effort.{LIFT}"]
    swapped = exchanged((current, f"effort.{ELBOW}"))(columns)
    robot = with_drive(robot, 1, torque_constant=1.0)
    faults = find_misplaced(measure_gap(replace(log, columns={**columns, **swapped}), robot))
    assert [(fault.kind, fault.mend) for fault in faults] == [("data.swap", None)]


def test_which_of_two_readings_it_is_that_leave_as_little_is_not_sure(monkeypatch: pytest.MonkeyPatch) -> None:
    class Looked:
        gap = None

        def left(self, course: list[np.ndarray], _: np.ndarray) -> np.ndarray:
            return course[0]

    faults = [Fault("data.sign", name, "turn it", mend=Mend(factors=((name, -1.0),))) for name in "ab"]
    for other, as_stated, where, sure in (
        (0.5, None, "a", True),
        (0.11, None, "a", False),
        (0.11, faults[1], "b", True),
    ):
        monkeypatch.setattr(misplaced, "_as_stated", lambda *_, known=as_stated: known)
        readings = zip(([np.array([0.1])], [np.array([other])]), 2 * [np.zeros(1)], faults, strict=True)
        (fault,) = misplaced._least(Looked(), EVER, readings, lambda _: True)
        assert fault.where == where
        assert (fault.mend is not None) is sure


LIFTED = """<mujoco><worldbody><body>
<joint name="lift" type="slide" axis="0 0 1"/><geom type="box" size=".1 .1 .1" mass="4"/>
</body></worldbody></mujoco>"""
STATED = """name = "lift"
model = "lift.xml"
[[joint]]
name = "lift"
friction = { law = "coulomb_viscous", side = "joint", parameters = { coulomb = 6.0, viscous = 4.0 } }
"""


@pytest.mark.parametrize("turned", ["effort.lift", "position.lift"])
def test_the_weight_of_a_lift_tells_whose_sign_is_wrong(turned: str, tmp_path: Path) -> None:
    # Without it, as if an offset of either sign were possible, both readings leave as little: what a soft stop adds.
    (tmp_path / "lift.xml").write_text(LIFTED)
    (tmp_path / "robot.toml").write_text(STATED)
    time = np.arange(0.0, 40.0, 0.004)
    place = 0.2 * np.sin(1.3 * time) + 0.05 * np.sin(3.1 * time)
    speed = np.gradient(place, time)
    effort = 4.0 * (np.gradient(speed, time) + 9.81) + 6.0 * np.sign(speed) + 4.0 * speed
    effort += 40.0 * np.maximum(place + 0.05, 0.0) + 0.1 * np.random.default_rng(1).normal(size=time.size)
    columns = {"time": time, "position.lift": place, "effort.lift": effort}
    columns[turned] = -columns[turned]
    audit = audited(log_from_table(pa.table(columns), "lift"), read_robot(tmp_path / "robot.toml"))
    assert not audit.refused
    assert [(fault.kind, fault.where) for fault in audit.faults] == [("data.sign", turned)]


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


@pytest.mark.deep
def test_what_a_mended_log_could_show_is_told(case: tuple[Log, Robot]) -> None:
    log, robot = case
    whole, mended, refused = (
        inspected_table(damaged(log, damage), robot)
        for damage in (lambda _: {}, turned(f"effort.{ELBOW}"), scaled(37.0, f"effort.{ELBOW}"))
    )
    assert mended["could_show"] == whole["could_show"]
    degrees = inspected_table(damaged(log, scaled(180.0 / np.pi, *of_all("position"))), robot)
    for written, right in zip(degrees["joints"], whole["joints"], strict=True):
        assert written["range"] == pytest.approx(np.degrees(right["range"]), rel=0.02)
    assert [entry["kind"] for entry in mended["data_problems"]] == ["data.sign"]
    assert refused["could_show"] == []
