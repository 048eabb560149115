"""Faults of the log itself are named before any physics is blamed."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from mjfriction.benchmark.cases import Setting, make_case
from mjfriction.body.inverse import inverse_dynamics
from mjfriction.cli.logs import read_logs
from mjfriction.diagnose.diagnosis import diagnose_log
from mjfriction.diagnose.faults import misplaced
from mjfriction.diagnose.faults.audit import find_faults
from mjfriction.diagnose.faults.mend import audited
from mjfriction.diagnose.faults.misplaced import find_misplaced
from mjfriction.diagnose.faults.units import find_degrees, find_degrees_by_velocity
from mjfriction.diagnose.tell.outcome import Diagnosis, Verdict
from mjfriction.errors import LogError
from mjfriction.identify.measure import measure_gap
from mjfriction.record.log import Log
from mjfriction.record.readers import read_log
from mjfriction.record.readers.table import log_from_table
from mjfriction.report.result import data_problems
from mjfriction.robot.files import read_robot
from mjfriction.robot.predict import predict_log
from mjfriction.robot.robot import Robot
from tests.deep import deep
from tests.diagnose.test_lone_axis import pendulum
from tests.diagnose.test_planar_arm import JOINT, LINK
from tests.hidden.machine import Machine, write_case

Columns = dict[str, np.ndarray]
ELBOW, WRIST = "effort.elbow_joint", "effort.wrist_1_joint"
LIFT = "shoulder_lift_joint"
LIFTED = f"position.{LIFT}"


@pytest.fixture(scope="module")
def case(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path]:
    return write_case(tmp_path_factory.mktemp("case"), Machine(), seed=12, seconds=25.0)


def damaged(case: tuple[Path, Path], damage: Callable[[Columns], Columns]) -> Log:
    log = read_log(case[0])
    return replace(log, columns=dict(log.columns) | damage(dict(log.columns)))


def run(case: tuple[Path, Path], damage: Callable[[Columns], Columns]) -> Diagnosis:
    return diagnose_log(damaged(case, damage), read_robot(case[1]))


@pytest.mark.parametrize(
    ("damage", "kind", "where"),
    [
        (lambda c: {ELBOW: -c[ELBOW]}, "data.sign", ELBOW),
        deep(lambda c: {ELBOW: 1000.0 * c[ELBOW]}, "data.unit", ELBOW),
        (lambda c: {ELBOW: c[ELBOW] / 101.0}, "data.unit", ELBOW),
        (lambda c: {ELBOW: c[WRIST], WRIST: c[ELBOW]}, "data.swap", f"{WRIST} and that of elbow_joint"),
    ],
)
def test_effort_of_wrong_sign_unit_or_joint(
    damage: Callable[[Columns], Columns], kind: str, where: str, case: tuple[Path, Path]
) -> None:
    diagnosis = run(case, damage)
    assert diagnosis.verdict is Verdict.BAD_DATA
    assert (kind, where) in {(fault.kind, fault.where) for fault in diagnosis.faults}
    assert diagnosis.findings == ()
    assert diagnosis.robot.table == diagnosis.gap.robot.table


def test_efforts_that_look_alike_and_are_exchanged_are_known_by_their_sizes(tmp_path: Path) -> None:
    # Both turn to and fro together, without gravity: friction is all there is, of either the same course.
    stated = upright(tmp_path)
    time = np.arange(0.0, 30.0, 0.004)
    angle = 0.8 * np.arcsin(np.sin(1.3 * time))
    rng = np.random.default_rng(1)
    columns = {"time": time} | {f"position.{joint}": angle for joint in stated.joints}
    blank = columns | {f"effort.{joint}": np.zeros(time.size) for joint in stated.joints}
    predicted = predict_log(log_from_table(pa.table(blank), "blank"), stated)
    for joint in stated.joints:
        effort = predicted[f"effort.{joint}"]
        columns[f"effort.{joint}"] = effort + 0.03 * np.std(effort) * rng.normal(size=time.size)
    swapped = columns | {"effort.near": columns["effort.far"], "effort.far": columns["effort.near"]}
    audit = audited(log_from_table(pa.table(swapped), "swapped"), stated)
    assert [(fault.kind, fault.where) for fault in audit.faults] == [("data.swap", "effort.far and that of near")]
    assert not audit.refused
    np.testing.assert_array_equal(audit.gap.log.columns["effort.near"], columns["effort.near"])
    # One alone of the wrong size is in another unit.
    scaled = columns | {"effort.near": columns["effort.near"] / 8.0}
    faults = find_faults(measure_gap(log_from_table(pa.table(scaled), "scaled"), stated))
    assert [(fault.kind, fault.where) for fault in faults] == [("data.unit", "effort.near")]


def upright(folder: Path) -> Robot:
    """Return an arm of two joints that turn about the vertical, of which the far one has an eighth of the friction."""
    bars = [LINK.format(name=name, mass=0.2, centre=0.0, inertia=0.002) for name in ("bar", "tip")]
    pairs = (("near", "base", "bar"), ("far", "bar", "tip"))
    hinges = [JOINT.format(name=name, parent=parent, child=child, z=0.1) for name, parent, child in pairs]
    urdf = "".join(['<robot name="upright"><link name="base"/>', *bars, *hinges, "</robot>"])
    (folder / "upright.urdf").write_text(urdf.replace("0 1 0", "0 0 1"))
    joints = "".join(
        f'[[joint]]\nname = "{name}"\n'
        f'friction = {{ law = "coulomb_viscous", parameters = {{ coulomb = {level}, viscous = {0.3 * level} }} }}\n'
        for name, level in (("near", 4.0), ("far", 0.5))
    )
    (folder / "upright.toml").write_text(f'name = "upright"\nmodel = "upright.urdf"\n{joints}')
    return read_robot(folder / "upright.toml")


@pytest.mark.parametrize(("factor", "kind"), [deep(1000.0, "data.unit"), (-1.0, "data.sign")])
def test_arms_that_mostly_rest_are_judged_where_they_move(factor: float, kind: str) -> None:
    # Between its moves friction holds the wrist, and its efforts look like none that are predicted: half of them do.
    placing = make_case(2, Setting(robot="comau_ns12", seconds=20.0, rate=250.0, motion="pick_and_place"), (), 1.0)
    assert find_faults(measure_gap(log_from_table(pa.table(placing.log), "placing"), placing.stated)) == []
    for joint in placing.stated.joints[-2:]:
        column = f"effort.{joint}"
        log = log_from_table(pa.table({**placing.log, column: factor * placing.log[column]}), "placing")
        (fault,) = find_faults(measure_gap(log, placing.stated))
        assert (fault.kind, fault.where) == (kind, column)


def test_a_rod_that_mostly_rests_about_its_upright_has_no_sign_turned(tmp_path: Path) -> None:
    """It comes to rest past its upright, and what the contact holds there outweighs it: the drive seems to push it on
    where it has to hold it back.
    """
    robot = pendulum(tmp_path, "rod", inertia=0.08, rotor=2e-6, coulomb=3.0, noise=0.0)
    time = np.arange(0.0, 144.0, 0.004)
    since, way = time % 24.0, np.where(time // 24.0 % 2 == 0, 1.0, -1.0)
    angle = np.pi + 0.1 * way * np.where(since < 1.0, -np.cos(np.pi * since), 1.0)
    speed = np.gradient(angle, time)
    rigid = inverse_dynamics(robot.body(), *(own[:, None] for own in (angle, speed, np.gradient(speed, time))))[:, 0]
    noise = 0.05 * np.random.default_rng(1).normal(size=time.size)
    effort = rigid + 3.0 * way + 0.2 * speed + noise
    log = log_from_table(pa.table({"time": time, "position.swing": angle, "effort.swing": effort}), "rod")
    assert find_faults(measure_gap(log, robot)) == []


def test_a_log_that_is_refused_is_not_fitted_however_it_hums(case: tuple[Path, Path]) -> None:
    time = read_log(case[0]).time
    hum = 6.0 * np.sin(2.0 * np.pi * 4.74 * time)
    sound = run(case, lambda c: {ELBOW: c[ELBOW] + hum})
    assert sound.verdict is Verdict.UNEXPLAINED
    faulty = run(case, lambda c: {ELBOW: c[ELBOW] + hum, WRIST: 37.0 * c[WRIST]})
    assert faulty.verdict is Verdict.BAD_DATA
    assert faulty.refused
    assert faulty.robot.table == faulty.gap.robot.table
    assert faulty.adjustments == ()
    residual = np.nan_to_num(faulty.gap.residual)
    np.testing.assert_allclose(faulty.residual_after[:, faulty.gap.examined], residual[:, faulty.gap.examined])


def test_a_sound_log_has_no_fault(case: tuple[Path, Path]) -> None:
    assert run(case, lambda _: {}).faults == ()


def test_a_drive_far_off_is_physics_still(case: tuple[Path, Path]) -> None:
    diagnosis = run(case, lambda c: {ELBOW: 1.4 * c[ELBOW]})
    assert diagnosis.faults == ()
    assert [finding.cause for finding in diagnosis.findings] == ["drive.torque_constant"]


def test_degrees_are_named(case: tuple[Path, Path]) -> None:
    diagnosis = run(case, lambda c: {n: np.degrees(v) for n, v in c.items() if n.startswith("position.")})
    assert diagnosis.verdict is Verdict.BAD_DATA
    assert {fault.kind for fault in diagnosis.faults} == {"data.unit"}
    assert "convert it if it is in degrees" in diagnosis.faults[0].action


def in_degrees(columns: Columns) -> Columns:
    return {name: np.degrees(values) for name, values in columns.items() if name.startswith("position.")}


def velocities(log: Log) -> Columns:
    pairs = ((name, values) for name, values in log.columns.items() if name.startswith("position."))
    return {name.replace("position", "velocity"): np.gradient(values, log.time) for name, values in pairs}


def test_degrees_are_known_without_limits_by_the_efforts(case: tuple[Path, Path]) -> None:
    gap = measure_gap(damaged(case, in_degrees), read_robot(case[1]))
    assert {fault.where for fault in find_degrees(gap)} == {f"position.{joint}" for joint in gap.robot.joints}
    # Far turns that are radians are no degrees.
    assert find_degrees(measure_gap(damaged(case, lambda c: {BEND: c[BEND] + 4.0 * np.pi}), read_robot(case[1]))) == []


def test_degrees_and_a_clock_that_is_off_are_known_by_measured_velocities(case: tuple[Path, Path]) -> None:
    log, robot = read_log(case[0]), read_robot(case[1])

    def faults(of: Log) -> set[tuple[str, str]]:
        return {(fault.kind, fault.where) for fault in find_faults(measure_gap(of, robot))}

    def with_velocities(factor: float, **changes: object) -> Log:
        own = {name: factor * values for name, values in velocities(log).items()}
        return replace(log, columns=dict(log.columns) | own, **changes)

    sound = with_velocities(1.0)
    assert faults(sound) == set()
    degrees = replace(sound, columns=dict(sound.columns) | in_degrees(dict(log.columns)))
    assert {where for _, where in faults(degrees)} == {f"position.{joint}" for joint in log.joints}
    gap = measure_gap(degrees, robot)
    assert len(find_degrees_by_velocity(degrees, gap.body, gap.motion.cutoff)) == len(log.joints)
    assert faults(with_velocities(1.0, time=1.3 * log.time)) == {("data.clock", "whole log")}
    # Velocities that are off themselves, in turns per minute or at the motor are of no use, but no fault of the rest.
    for factor in (1.3, 9.5493, 101.0):
        assert faults(with_velocities(factor)) == set()


@pytest.mark.parametrize(
    ("factor", "kind", "words"),
    [
        (-1.0, "data.sign", "turn its sign"),
        deep(180.0 / np.pi, "data.unit", "degrees per second"),
        deep(-30.0 / np.pi, "data.unit", "revolutions per minute"),
    ],
)
def test_a_velocity_that_contradicts_its_position_is_told_and_not_used(
    factor: float, kind: str, words: str, case: tuple[Path, Path]
) -> None:
    log, robot = read_log(case[0]), read_robot(case[1])
    own = velocities(log)
    plain = diagnose_log(log, robot)
    sound = replace(log, columns=dict(log.columns) | own)
    assert diagnose_log(sound, robot).faults == ()
    name = f"velocity.{robot.joints[2]}"
    diagnosis = diagnose_log(replace(log, columns=dict(log.columns) | {name: factor * own[name]}), robot)
    (fault,) = diagnosis.faults
    assert (fault.kind, fault.where) == (kind, name)
    assert words in fault.action
    assert "not used" in fault.action
    # Nothing else depends on it.
    assert (diagnosis.verdict, diagnosis.findings) == (plain.verdict, plain.findings)


@pytest.mark.parametrize(("spread", "told"), [(0.003, False), (0.1, False), (0.15, True)])
def test_a_clock_is_at_fault_where_it_is_uneven_and_not_where_it_is_but_read_by_a_computer(
    spread: float, *, told: bool, case: tuple[Path, Path]
) -> None:
    log = read_log(case[0])
    step = float(np.median(np.diff(log.time)))
    jitter = 0.5**0.5 * spread * step * np.random.default_rng(4).standard_normal(log.time.size)
    gap = measure_gap(replace(log, time=log.time + jitter), read_robot(case[1]))
    assert any(problem.kind == "data.clock" for problem in data_problems(gap)) is told


LIFT, BEND = "position.shoulder_lift_joint", "position.elbow_joint"


@pytest.mark.parametrize(
    ("damage", "kind", "names"),
    [
        (lambda c: {BEND: -c[BEND]}, "data.sign", ["elbow_joint"]),
        (lambda c: {BEND: c[LIFT], LIFT: c[BEND]}, "data.swap", ["elbow_joint", "shoulder_lift_joint"]),
    ],
)
def test_positions_of_wrong_sign_or_joint(
    damage: Callable[[Columns], Columns], kind: str, names: list[str], case: tuple[Path, Path]
) -> None:
    diagnosis = run(case, damage)
    assert diagnosis.verdict is Verdict.BAD_DATA
    (fault,) = diagnosis.faults
    assert fault.kind == kind
    assert all(name in fault.where for name in names)
    # Two joints whose positions are exchanged look like two whose efforts are, but for what the others carry.
    assert fault.where.startswith("position.")


def of_both(columns: Columns, change: Callable[[Columns, str], Columns]) -> Columns:
    return change(columns, "position") | change(columns, "effort")


def test_a_sign_is_known_of_a_joint_whose_effort_wanders(
    case: tuple[Path, Path], monkeypatch: pytest.MonkeyPatch
) -> None:
    def damage(columns: Columns) -> Columns:
        effort = columns["effort.wrist_3_joint"]
        knots = np.random.default_rng(1).normal(0.0, np.std(effort), 60)
        wander = np.interp(np.arange(effort.size), np.linspace(0.0, effort.size, knots.size), knots)
        return {"effort.wrist_3_joint": effort + wander, "position.wrist_3_joint": -columns["position.wrist_3_joint"]}

    gap = measure_gap(damaged(case, damage), read_robot(case[1]), highest=60.0)
    (fault,) = find_faults(gap)
    assert fault.kind == "data.sign"
    assert fault.where.endswith("wrist_3_joint")
    monkeypatch.setattr(misplaced, "MENDED_FROM_NOTHING", misplaced.MENDED)
    assert find_faults(gap) == []


@pytest.mark.parametrize(
    "pair",
    [("shoulder_lift_joint", "elbow_joint"), deep(("elbow_joint", "wrist_1_joint"))],
)
def test_joints_that_are_exchanged_with_all_they_have_are_known(pair: tuple[str, str], case: tuple[Path, Path]) -> None:
    def exchanged(columns: Columns, quantity: str) -> Columns:
        one, other = (f"{quantity}.{joint}" for joint in pair)
        return {one: columns[other], other: columns[one]}

    diagnosis = run(case, lambda c: of_both(c, exchanged))
    assert diagnosis.verdict is Verdict.BAD_DATA
    (fault,) = diagnosis.faults
    assert (fault.kind, fault.where) == ("data.swap", f"all columns of {pair[1]} and {pair[0]}")


@pytest.mark.parametrize("joint", ["shoulder_lift_joint", deep("elbow_joint")])
def test_a_joint_counted_the_other_way_round_is_known(joint: str, case: tuple[Path, Path]) -> None:
    diagnosis = run(case, lambda c: of_both(c, lambda c, quantity: {f"{quantity}.{joint}": -c[f"{quantity}.{joint}"]}))
    assert diagnosis.verdict is Verdict.BAD_DATA
    (fault,) = diagnosis.faults
    assert (fault.kind, fault.where) == ("data.sign", f"all columns of {joint}")


def test_efforts_that_a_large_cause_disguises_are_still_known_as_exchanged(tmp_path: Path) -> None:
    machine = Machine(hidden={2: lambda i: 25.0 * np.cos(9.0 * i.q)})
    log_path, robot = write_case(tmp_path, machine, seed=3, seconds=20.0)
    log = read_log(log_path)
    lift, elbow = log.columns[ELBOW.replace("elbow", "shoulder_lift")], log.columns[ELBOW]
    assert diagnose_log(log, read_robot(robot)).faults == ()
    exchanged = {**log.columns, ELBOW: lift, ELBOW.replace("elbow", "shoulder_lift"): elbow}
    (fault,) = diagnose_log(replace(log, columns=exchanged), read_robot(robot)).faults
    assert fault.kind == "data.swap"
    assert fault.where.startswith("effort.")


def test_two_that_are_both_mended_are_exchanged_however_well_they_fit_as_they_are(
    case: tuple[Path, Path], monkeypatch: pytest.MonkeyPatch
) -> None:
    log, lift = read_log(case[0]), ELBOW.replace("elbow", "shoulder_lift")
    right = measure_gap(log, read_robot(case[1]))
    gap = measure_gap(
        replace(log, columns={**log.columns, ELBOW: log.columns[lift], lift: log.columns[ELBOW]}), read_robot(case[1])
    )
    # As of an arm whose joints carry much the same, so that neither is poor.
    monkeypatch.setattr(misplaced, "_mended", lambda *_: False)
    assert find_misplaced(right) == []
    (fault,) = find_misplaced(gap)
    assert (fault.kind, fault.where) == ("data.swap", f"{ELBOW} and that of shoulder_lift_joint")
    monkeypatch.setattr(misplaced, "MENDED_BOTH", 0.0)
    assert find_misplaced(gap) == []


def test_the_sign_of_a_position_is_told_from_that_of_an_effort_by_the_robot_as_stated(
    case: tuple[Path, Path], monkeypatch: pytest.MonkeyPatch
) -> None:
    # Nothing carries the last joint's motion, and nothing weighs on it: what others carry tells little.
    log, robot, last = read_log(case[0]), read_robot(case[1]), "wrist_3_joint"
    for column in (f"position.{last}", f"effort.{last}"):
        turned = measure_gap(replace(log, columns={**log.columns, column: -log.columns[column]}), robot)
        (fault,) = find_faults(turned)
        assert (fault.kind, fault.where, fault.action) == ("data.sign", column, "turn its sign")
    monkeypatch.setattr(misplaced, "CLEARLY", 1e-9)
    (fault,) = find_faults(turned)
    assert "or of the positions" in fault.action


def test_the_sign_of_a_lone_slide_and_of_its_effort_are_one_and_the_same() -> None:
    sliding = make_case(2, Setting(robot="linear_axis", seconds=20.0, rate=250.0), (), 1.0)
    (joint,) = sliding.stated.joints
    for quantity in ("position", "effort"):
        columns = {name: -own if name.startswith(quantity) else own for name, own in sliding.log.items()}
        (fault,) = find_faults(measure_gap(log_from_table(pa.table(columns), "sliding"), sliding.stated))
        assert (fault.kind, fault.where) == ("data.sign", f"effort.{joint}")
        assert "or of the positions" in fault.action


def test_milliseconds_are_refused(case: tuple[Path, Path]) -> None:
    log = read_log(case[0])
    with pytest.raises(LogError, match="time must be in seconds: a clock in milli-"):
        diagnose_log(replace(log, time=1000.0 * log.time), read_robot(case[1]))


def test_a_joint_that_never_moves_is_not_examined(case: tuple[Path, Path]) -> None:
    # A parked axis at the tip: what it carries is next to nothing, whatever its angle.
    still = run(case, lambda c: {"position.wrist_3_joint": np.full_like(c["position.wrist_3_joint"], 0.3)})
    assert "wrist_3_joint" in still.not_examined
    assert np.isfinite(still.heldout).all()


@pytest.mark.parametrize(
    ("damage", "kind", "where"),
    [
        (lambda c, late: {ELBOW: np.where(late, 100.0, 1.0) * c[ELBOW]}, "data.unit", ELBOW),
        deep(lambda c, late: {WRIST: np.where(late, -1.0, 1.0) * c[WRIST]}, "data.sign", WRIST),
        (lambda c, late: {LIFTED: np.where(late, -1.0, 1.0) * c[LIFTED]}, "data.sign", LIFTED),
    ],
)
def test_one_of_two_logs_may_be_at_fault(
    damage: Callable[[Columns, np.ndarray], Columns], kind: str, where: str, case: tuple[Path, Path], tmp_path: Path
) -> None:
    log = read_log(case[0])
    half = 0.5 * (log.time[0] + log.time[-1])
    columns = {"time": log.time, **log.columns}
    late = log.time >= half
    columns |= damage(dict(log.columns), late)
    paths = []
    for name, own in (("monday", ~late), ("tuesday", late)):
        paths.append(tmp_path / f"{name}.parquet")
        pq.write_table(pa.table({column: values[own] for column, values in columns.items()}), paths[-1])
    diagnosis = diagnose_log(read_logs(paths, read_robot(case[1]).joints, None, None), read_robot(case[1]))
    assert diagnosis.verdict is Verdict.BAD_DATA
    assert [(fault.kind, fault.where) for fault in diagnosis.faults] == [(kind, f"{where}, in tuesday.parquet alone")]


def test_rows_that_were_dropped_are_told_once(case: tuple[Path, Path]) -> None:
    log = read_log(case[0])
    rows = np.arange(log.time.size)
    for first in (1000, 3000, 5000):  # a stretch comes once more, in the place of what went on there
        rows[first : first + 100] = rows[first - 100 : first]
    again = {name: values[rows] for name, values in log.columns.items()}
    gap = measure_gap(log_from_table(pa.table({"time": log.time, **again}), "again"), read_robot(case[1]))
    assert [problem.kind for problem in data_problems(gap)] == ["data.duplicate"]
    assert len(gap.motion.clock.gaps) >= 3


def test_a_joint_that_rests_in_one_of_two_logs_is_not_judged_there(case: tuple[Path, Path], tmp_path: Path) -> None:
    log = read_log(case[0])
    half = log.time.size // 2
    columns = {"time": log.time, **{name: values.copy() for name, values in log.columns.items()}}
    columns["position.wrist_1_joint"][half:] = columns["position.wrist_1_joint"][half - 1]
    columns[WRIST][half:] = 0.4 * np.random.default_rng(1).normal(size=log.time.size - half)
    paths = []
    for name, own in (("monday", slice(0, half)), ("tuesday", slice(half, None))):
        paths.append(tmp_path / f"{name}.parquet")
        pq.write_table(pa.table({column: values[own] for column, values in columns.items()}), paths[-1])
    robot = read_robot(case[1])
    gap = measure_gap(read_logs(paths, robot.joints, None, None), robot)
    assert robot.joints.index("wrist_1_joint") in gap.examined
    assert find_faults(gap) == []


@pytest.mark.parametrize(
    ("as_logged", "left", "mended"),
    [
        # A slide that was counted the other way round, and the joint that carries it, whose effort is noisy.
        ((0.087, 0.39, 0.128), (0.069, 0.199, 0.02), True),
        ((0.087, 0.39, 0.128), (0.069, 0.30, 0.02), False),
        ((0.087, 0.39, 0.128), (0.13, 0.199, 0.02), False),
        ((0.087, 0.39, 0.04), (0.069, 0.199, 0.002), False),
        ((0.02, 0.8, 0.01), (0.02, 0.2, 0.01), True),
    ],
)
def test_what_mends_a_log(as_logged: tuple[float, ...], left: tuple[float, ...], *, mended: bool) -> None:
    assert misplaced._mended(np.array(as_logged), np.array(left)) is mended
