"""The gap between a log and a robot where a log has less than all."""

from __future__ import annotations

from dataclasses import replace
from importlib.resources import files
from pathlib import Path

import numpy as np
import pytest

from mjfriction.body.inverse import inertia_along
from mjfriction.diagnose.diagnosis import diagnose_log
from mjfriction.errors import LogError
from mjfriction.identify.doubt import doubt_speeds
from mjfriction.identify.gap import Gap
from mjfriction.identify.measure import gap_of, measure_gap
from mjfriction.record.log import Log
from mjfriction.record.motion import estimate_motion
from mjfriction.record.readers import read_log
from mjfriction.robot.bandwidth import choose_cutoff
from mjfriction.robot.effort import bare, predict_effort
from mjfriction.robot.files import read_robot
from mjfriction.robot.friction import raised_levels
from mjfriction.robot.friction_tables import FrictionTerm
from mjfriction.robot.own_slopes import own_slopes
from mjfriction.robot.robot import Robot
from mjfriction.robot.schema import Coupling, EffortSensor, PositionSensor, Spring, Transmission
from tests.hidden.machine import UR5_COULOMB, Machine, write_case

SECONDS = np.arange(0.0, 40.0, 0.004)
NOISE = np.random.default_rng(1).normal(size=SECONDS.size)


@pytest.fixture(scope="module")
def demo() -> Log:
    return read_log(Path(str(files("mjfriction"))) / "bundled/demo/log.parquet")


def test_a_joint_that_reads_the_same_throughout_is_no_obstacle(demo: Log) -> None:
    still = {**demo.columns, "position.wrist_3_joint": np.zeros(demo.time.size)}
    gap = measure_gap(replace(demo, columns=still), read_robot("ur5"))
    assert not gap.motion.moving[5]
    assert np.all(np.isfinite(gap.doubt))


@pytest.mark.parametrize(("share", "examined"), [(0.3, True), (0.95, False)])
def test_a_joint_whose_effort_clips_whenever_it_moves_is_not_examined(share: float, examined: bool, demo: Log) -> None:
    speed = np.abs(np.gradient(demo.columns["position.wrist_3_joint"], demo.time))
    clipped = {"effort.wrist_3_joint": speed > np.quantile(speed, 1.0 - share)}
    gap = measure_gap(replace(demo, unusable=clipped), read_robot("ur5"))
    assert (5 in gap.examined) is examined
    assert set(range(5)) <= set(gap.examined)


@pytest.mark.deep
def test_a_link_whose_joint_reports_no_effort_is_felt_by_the_others(demo: Log) -> None:
    columns = {name: values for name, values in demo.columns.items() if name != "effort.wrist_1_joint"}
    robot = read_robot("ur5")
    light = robot.table.model_copy(update={"link_scale": {"wrist_1_joint": 0.5}})
    found = diagnose_log(replace(demo, columns=columns), replace(robot, table=light))
    assert ("body.link_inertia", None) in {(finding.cause, finding.joint) for finding in found.findings}
    assert "wrist_1_joint" in found.not_examined


@pytest.mark.parametrize(("lag", "raises"), [(0.0, True), (0.012, False)])
def test_a_quiet_velocity_widens_the_band_only_if_it_is_the_positions(demo: Log, lag: float, raises: bool) -> None:
    robot = read_robot("ur5")
    rng = np.random.default_rng(6)
    rough = {
        name: values + 3e-4 * rng.normal(size=values.size)
        for name, values in demo.columns.items()
        if name.startswith("position.")
    }
    without = {name: values for name, values in demo.columns.items() if not name.startswith("velocity.")} | rough
    velocity = {
        f"velocity.{joint}": np.interp(
            demo.time - lag, demo.time, np.gradient(demo.columns[f"position.{joint}"], demo.time)
        )
        for joint in robot.joints
    }
    alone, beside = (
        choose_cutoff(replace(demo, columns=c), robot, robot.body()) for c in (without, without | velocity)
    )
    assert (beside > 1.5 * alone) is raises
    if not raises:
        assert beside == alone


@pytest.mark.parametrize("shared", [0.0, 0.3])
def test_robots_that_differ_in_what_they_report_are_predicted_each_as_it_is(demo: Log, shared: float) -> None:
    gap = measure_gap(demo, read_robot("ur5"))
    wrist, elbow = gap.robot.joint("wrist_1_joint"), gap.robot.joint("elbow_joint")
    coupled = wrist.model_copy(update={"coupling": (Coupling(joint="elbow_joint", effort=shared),)})
    for sensor in (EffortSensor(), EffortSensor(delay=0.01), EffortSensor(scale=1.2, offset=2.0), EffortSensor()):
        robot = gap.robot.with_joint(coupled).with_joint(elbow.model_copy(update={"effort_sensor": sensor}))
        expected = gap.chain.rows(predict_effort(robot, robot.body(), gap.motion).reported)
        np.testing.assert_allclose(gap.predicted(robot), expected, atol=1e-9 * np.max(np.abs(expected)))


def test_robots_that_differ_in_what_they_carry_or_rub_are_predicted_each_as_it_is(demo: Log) -> None:
    gap = measure_gap(demo, read_robot("ur5"))
    elbow, heavier = (
        gap.robot.joint("elbow_joint"),
        gap.robot.table.model_copy(update={"link_scale": {"elbow_joint": 1.3}}),
    )
    rubbing = raised_levels(gap.robot, "elbow_joint", 2.0, 1.0)
    robots = [gap.robot, rubbing, Robot(heavier, gap.robot.folder)]
    changes: list[dict[str, object]] = [
        {"position_sensor": PositionSensor(offset=0.1)},
        {"actuator": elbow.actuator.model_copy(update={"rotor_inertia": elbow.actuator.rotor_inertia + 2e-4})},
        {"spring": Spring(stiffness=5.0)},
        {"transmission": Transmission(compliance=2e-3)},
        {"transmission": Transmission(compliance=2e-3, carries_friction=True)},
        {"transmission": Transmission(compliance=2e-3, rubs_with_link=True)},
    ]
    robots += [
        one.with_joint(one.joint("elbow_joint").model_copy(update=c)) for c in changes for one in (gap.robot, rubbing)
    ]
    giving = Transmission(compliance=2e-3)
    robots += [
        one.with_joint(one.joint("elbow_joint").model_copy(update={"transmission": giving})) for one in robots[2:7]
    ]
    for robot in robots:
        expected = gap.chain.rows(predict_effort(robot, robot.body(), gap.motion).reported)
        np.testing.assert_allclose(gap.predicted(robot), expected, atol=1e-9 * np.max(np.abs(expected)))
    assert bare(rubbing) == bare(gap.robot)


def test_slopes_of_the_loads_are_computed_once_for_all_transmissions(
    demo: Log, monkeypatch: pytest.MonkeyPatch
) -> None:
    gap, made = measure_gap(demo, read_robot("ur5")), []
    monkeypatch.setattr(
        "mjfriction.identify.gap.own_slopes", lambda body, motion: made.append(body) or own_slopes(body, motion)
    )
    elbow = gap.robot.joint("elbow_joint")
    for compliance in (1e-3, 2e-3, 4e-3):
        soft = elbow.model_copy(update={"transmission": Transmission(compliance=compliance)})
        gap.predicted(raised_levels(gap.robot.with_joint(soft), "elbow_joint", 1e3 * compliance, 1.0))
    assert len(made) == 1


def test_a_links_inertia_between_poses_is_that_of_the_pose(demo: Log) -> None:
    robot = read_robot("ur5")
    motion = measure_gap(demo, robot).motion
    every = inertia_along(robot.body(), motion.position)
    np.testing.assert_allclose(own_slopes(robot.body(), motion)[2], every, rtol=2e-3)


@pytest.fixture(scope="module")
def pausing(tmp_path_factory: pytest.TempPathFactory) -> tuple[Log, Robot]:
    machine = Machine(bristle_travel=6e-4, pauses=True, noise=0.05)
    log, robot = write_case(tmp_path_factory.mktemp("pausing"), machine, seed=6, seconds=30.0)
    return read_log(log), read_robot(robot)


def test_a_rest_says_one_thing_however_long_it_is(pausing: tuple[Log, Robot], monkeypatch: pytest.MonkeyPatch) -> None:
    def said() -> np.ndarray:
        # What each rest of the elbow weighs, in units of one row that is in doubt by the whole level.
        gap = measure_gap(*pausing)
        speed = np.abs(gap.at_rows("velocity")[:, 2])
        still = speed < 0.1 * gap.doubt_speed[2]
        runs = np.split(np.flatnonzero(still), np.flatnonzero(np.diff(np.flatnonzero(still)) > 1) + 1)
        level = np.min(gap.doubt[still, 2])
        return np.array([np.sum(np.square(level / gap.doubt[run, 2])) for run in runs if run.size > 5])

    assert np.ptp(said()) < 0.5 * np.min(said())
    monkeypatch.setattr("mjfriction.identify.measure.rows_of_rests", lambda share, _: np.ones_like(share))
    assert np.max(said()) > 5.0


def test_where_a_contact_yields_after_a_rest_no_row_is_clear(pausing: tuple[Log, Robot]) -> None:
    def worst(gap: Gap) -> float:
        return max(np.max(np.abs(gap.residual[gap.clear[:, j], j])) / UR5_COULOMB[j] for j in gap.examined)

    assert worst(measure_gap(*pausing)) < 0.25
    assert worst(measure_gap(*pausing, yielding=0.0)) > 0.5


def test_waiting_and_creeping_meanwhile_makes_nothing_of_a_joints_usual_speed() -> None:
    time = np.arange(0.0, 100.0, 0.01)

    def usual(position: np.ndarray) -> float:
        log = Log("sine", time, np.zeros(time.size, dtype=np.int64), ("swing",), {"position.swing": position})
        return float(doubt_speeds(estimate_motion(log, ("swing",), 10.0))[0])

    swings = np.sin(np.minimum(time, 4.0 * np.pi))
    assert usual(swings + 1e-3 * time) == pytest.approx(usual(np.sin(time)), rel=0.05)


def test_what_is_spoilt_judges_no_joint_that_mostly_rests(demo: Log) -> None:
    time, elbow = demo.time - demo.time[0], "position.elbow_joint"
    rests, spoilt_from = time > 2.0, 0.45 * time[-1]
    held = np.where(rests, demo.columns[elbow][np.argmax(rests)], demo.columns[elbow])
    unusable = {"effort.elbow_joint": time > spoilt_from}
    gap = measure_gap(replace(demo, columns={**demo.columns, elbow: held}, unusable=unusable), read_robot("ur5"))
    judged = gap.chain.time[gap.clear[:, 2]] - demo.time[0]
    assert judged.size > 10
    assert np.max(judged) < 2.1


def recorded(position: np.ndarray, effort: np.ndarray) -> Log:
    joints = read_robot("ur5").joints
    noisy = position + 1e-6 * np.random.default_rng(0).normal(size=position.size)
    columns = {f"position.{joint}": noisy for joint in joints} | {f"effort.{joint}": effort for joint in joints}
    return Log("log", SECONDS, np.zeros(SECONDS.size, dtype=np.int64), joints, columns)


@pytest.mark.parametrize(
    ("course", "effort"),
    [
        (np.sin(SECONDS), np.ones(SECONDS.size)),
        (1e-3 * np.sin(0.05 * SECONDS), NOISE),
        (0.1 * np.floor(SECONDS / 4.0), NOISE),
    ],
)
def test_a_log_in_which_no_joint_shows_anything_is_refused(course: np.ndarray, effort: np.ndarray) -> None:
    log = recorded(course, effort)
    with pytest.raises(LogError, match="log: no joint moves for a while and reports an effort or a current that"):
        measure_gap(log, read_robot("ur5"))


def test_a_joint_that_jumps_from_rest_to_rest_is_examined_with_no_robot() -> None:
    log, robot = recorded(np.sin(SECONDS), NOISE), read_robot("ur5")
    jumping = 0.1 * np.floor(SECONDS / 4.0) + 1e-6 * NOISE
    gap = measure_gap(replace(log, columns={**log.columns, "position.elbow_joint": jumping}), robot)
    assert gap.examined == (0, 1, 3, 4, 5)
    elbow = robot.joint("elbow_joint")
    loose = robot.with_joint(elbow.model_copy(update={"friction": ()}))
    assert gap_of(loose, gap).examined == gap.examined


def test_a_joint_whose_friction_another_robot_leaves_in_doubt_is_examined_all_the_same(demo: Log) -> None:
    robot = read_robot("ur5")
    gap = measure_gap(demo, robot)
    far = {"stiffness": (0.01,), "level": (20.0,), "viscous": 0.0}  # what its spring held is never forgotten
    table = robot.joint("elbow_joint").model_copy(
        update={"friction": (FrictionTerm(law="maxwell_slip", parameters=far),)}
    )
    doubtful = gap_of(robot.with_joint(table), gap)
    assert doubtful.examined == gap.examined
    np.testing.assert_array_equal(doubtful.clear[:, 2], gap.clear[:, 2])
