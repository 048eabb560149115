"""Logs that say what mass was held: predicted like a payload, and friction that grows with it told by its passes."""

from __future__ import annotations

import functools
from dataclasses import replace
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from mjfriction.diagnose.diagnosis import diagnose_log
from mjfriction.diagnose.faults.look import SAMPLES, look_at
from mjfriction.diagnose.faults.which_log import logs_with
from mjfriction.errors import LogError, RobotError
from mjfriction.identify.identification import identify_log
from mjfriction.identify.measure import measure_gap
from mjfriction.identify.outcome import Identification
from mjfriction.identify.protocol import plan_passes
from mjfriction.identify.structure import Structure
from mjfriction.plant.machine import simulate
from mjfriction.plant.sensors import Recorder
from mjfriction.record.log import Log
from mjfriction.record.merge import merge_logs
from mjfriction.record.readers.table import log_from_table
from mjfriction.robot.body_tables import Payload, Place
from mjfriction.robot.files import read_robot, write_robot
from mjfriction.robot.friction_tables import FrictionTerm
from mjfriction.robot.links_torque import held_torque
from mjfriction.robot.predict import predict_log
from mjfriction.robot.robot import Robot
from tests.cli.here import mjfriction_here

ELBOW, MASSES = "elbow_joint", (0.0, 4.0)
TRUE = {"coulomb": 5.0, "load": 0.1, "viscous": 3.0}
HELD = Place(com=(0.02, 0.0, 0.1), parent="wrist_3_joint")


def stated(held: Place | None = HELD) -> Robot:
    robot = read_robot("ur5")
    return Robot(robot.table.model_copy(update={"held": held}), robot.folder)


def laden(mass: float) -> Robot:
    robot = read_robot("ur5")
    term = FrictionTerm(law="load_dependent", parameters=TRUE)
    robot = robot.with_joint(robot.joint(ELBOW).model_copy(update={"friction": (term,)}))
    payload = Payload(mass=mass, com=HELD.com, parent=HELD.parent)
    return Robot(robot.table.model_copy(update={"payload": payload}), robot.folder)


@functools.cache
def logs() -> tuple[Log, ...]:
    trajectory = plan_passes(stated(), [ELBOW], count=5).trajectory
    return tuple(
        log_from_table(
            pa.table(simulate(laden(mass), trajectory, recorder=Recorder(125.0), seed=k)), f"{mass} kg"
        ).holding(mass)
        for k, mass in enumerate(MASSES)
    )


@functools.cache
def identified(held: bool) -> Identification:
    own = logs() if held else logs()[1:]
    return identify_log(merge_logs(own), stated(), law={ELBOW: "load_dependent"})


@pytest.mark.deep
def test_a_mass_that_the_log_says_was_held_is_predicted_as_a_payload() -> None:
    log = logs()[1]
    told, without = (predict_log(log, robot) for robot in (stated(), stated(None)))
    truth = read_robot("ur5")
    payload = Payload(mass=MASSES[1], com=HELD.com, parent=HELD.parent)
    truth = Robot(truth.table.model_copy(update={"payload": payload}), truth.folder)
    as_payload = predict_log(log, truth)
    for joint in truth.joints:
        np.testing.assert_allclose(told[f"effort.{joint}"], as_payload[f"effort.{joint}"], atol=1e-9)
    assert np.max(np.abs(without[f"effort.{ELBOW}"] - told[f"effort.{ELBOW}"])) > 5.0


@pytest.mark.deep
def test_passes_at_two_masses_tell_what_a_load_adds() -> None:
    found = identified(True)
    (law,) = [own for own in found.laws if own.joint == ELBOW]
    assert law.how == "forward and backward passes"
    for parameter in law.parameters:
        assert parameter.low <= TRUE[parameter.name] <= parameter.high, parameter
        assert parameter.high - parameter.low < 0.2 * TRUE[parameter.name], parameter
    assert law.passes is not None
    assert law.passes.tells_load
    # What was held is no part of the pendulum that gravity is taken for: unsaid, the two would be 5 N·m apart.
    assert law.pendulum is not None
    assert np.all(law.pendulum.apart < 0.5)


def test_joined_logs_are_called_by_the_names_of_all_their_files() -> None:
    folders = [replace(log, source=f"runs/{k}/log{k}.csv") for k, log in enumerate(logs())]
    assert merge_logs(folders).name == "log0.csv + log1.csv"


def test_passes_at_one_mass_do_not() -> None:
    (law,) = [own for own in identified(False).laws if own.joint == ELBOW]
    assert "differences do not tell load_dependent" in law.how


def test_what_was_held_is_no_less_than_nothing() -> None:
    with pytest.raises(LogError, match="0 kg or more"):
        logs()[0].holding(-1.0)


def test_a_place_that_there_is_not_is_named() -> None:
    with pytest.raises(RobotError, match="held: parent 'hand' is no link"):
        measure_gap(logs()[1], stated(Place(parent="hand")))


@pytest.mark.parametrize(
    ("held", "place", "said"),
    [
        (("1.0",), True, "given 1 times for 2 logs"),
        (("1.0", "-2.0"), True, "-2: a mass is 0 kg or more"),
        (("0.0", "2.0"), False, "does not say where it holds a mass"),
    ],
)
def test_held_masses_that_make_no_sense_are_one_line(
    held: tuple[str, ...], place: bool, said: str, tmp_path: Path
) -> None:
    robot = write_robot(stated(HELD if place else None), tmp_path)
    log = tmp_path / "log.parquet"
    pq.write_table(pa.table({"time": np.arange(300) / 100.0, f"position.{ELBOW}": np.zeros(300)}), log)
    words = [word for mass in held for word in ("--held", mass)]
    done = mjfriction_here(
        "identify", str(log), str(log), "--robot", str(robot), "--out", str(tmp_path / "out"), *words
    )
    assert done.returncode == 2
    assert said in done.stderr
    assert done.stderr.count("\n") == 1


@pytest.mark.deep
def test_logs_of_several_masses_are_diagnosed_together() -> None:
    diagnosis = diagnose_log(merge_logs(logs()), stated())
    assert {(finding.cause, finding.joint) for finding in diagnosis.findings} == {
        ("friction.coulomb_viscous", ELBOW),
        ("friction.load", ELBOW),
    }
    values = {own.name: own.value for finding in diagnosis.findings for own in finding.parameters}
    assert values == pytest.approx(TRUE, rel=0.05)
    # Unsaid, it is a payload that the second log alone has.
    unsaid = diagnose_log(merge_logs(logs()), stated(None))
    (payload,) = [finding for finding in unsaid.findings if finding.cause == "body.payload"]
    assert payload.parameters[0].value == pytest.approx(MASSES[1], rel=0.01)
    assert f"in {logs()[1].name} alone" in payload.evidence


def test_what_all_logs_have_is_in_none_alone() -> None:
    gap = measure_gap(merge_logs([logs()[0], replace(logs()[0], source="again")]), stated(None))
    remains = (Structure(ELBOW, "time", 0.5),)
    assert logs_with(gap, remains) == ()
    assert logs_with(measure_gap(logs()[1], stated(None)), remains) == ()


def test_a_log_in_which_a_joint_tells_nothing_is_no_quiet_one() -> None:
    gap = measure_gap(merge_logs(logs()), stated(None))
    remains = (Structure(ELBOW, "time", 0.5),)
    assert logs_with(gap, remains) == (logs()[1].name,)
    second = gap.chain.time >= gap.log.joined[1][1]
    assert logs_with(replace(gap, clear=gap.clear & second[:, None]), remains) == ()


def test_a_files_name_may_hold_what_names_are_joined_by() -> None:
    pair = [replace(log, source=f"{log.source} + tool.csv") for log in logs()]
    gap = measure_gap(merge_logs(pair), stated(None))
    assert logs_with(gap, (Structure(ELBOW, "time", 0.5),)) == (pair[1].name,)


def test_what_was_held_is_not_in_the_efforts_that_columns_are_told_by() -> None:
    # What explains these is the links' course alone, whichever columns are exchanged.
    gap = measure_gap(logs()[1], stated())
    look = look_at(gap)
    assert gap.examined == (stated().joints.index(ELBOW),)
    rows = (slice(None, None, max(1, gap.motion.time.size // SAMPLES)), list(gap.examined))
    laden = (gap.motion.torque * gap.per_reported)[rows]
    np.testing.assert_allclose(look.effort, laden - held_torque(gap.robot, gap.body, gap.motion)[rows])
    assert look.left(look.course, look.effort)[0] < look.left(look.course, laden)[0]
