"""Several logs of one arm: what it held in some of them only is a payload, said of those."""

from __future__ import annotations

import functools

import numpy as np
import pyarrow as pa
import pytest

from mjfriction.diagnose.causes.payload_for_a_while import PayloadForAWhile
from mjfriction.diagnose.diagnosis import diagnose_log
from mjfriction.diagnose.tell.outcome import Diagnosis, Verdict
from mjfriction.identify.measure import measure_gap
from mjfriction.plant.machine import simulate
from mjfriction.plant.motions import excitation
from mjfriction.plant.sensors import Recorder
from mjfriction.record.log import Log
from mjfriction.record.merge import merge_logs
from mjfriction.record.readers.table import log_from_table
from mjfriction.robot.body_tables import Payload
from mjfriction.robot.files import read_robot
from mjfriction.robot.friction_tables import Event
from mjfriction.robot.links_torque import is_held
from mjfriction.robot.predict import predict_log
from mjfriction.robot.robot import Robot
from mjfriction.robot.schema import EffortSensor
from tests.deep import deep

HOME = np.array([0.0, -1.2, 1.4, -0.4, 1.2, 0.0])
CENTRE, FLANGE = (0.02, 0.01, 0.08), "wrist_3_joint"


def holding(mass: float) -> Robot:
    robot = read_robot("ur5")
    for joint in robot.table.joint:
        robot = robot.with_joint(joint.model_copy(update={"effort_sensor": EffortSensor(noise=0.3)}))
    payload = Payload(mass=mass, com=CENTRE, parent=FLANGE) if mass else None
    return Robot(robot.table.model_copy(update={"payload": payload}), robot.folder)


@functools.cache
def run(mass: float, seed: int) -> Log:
    return recorded(holding(mass), seed)


def recorded(robot: Robot, seed: int) -> Log:
    count = len(robot.joints)
    course = excitation(robot.joints, HOME, np.full(count, 0.7), np.full(count, 1.0), 25.0, seed=seed)
    return log_from_table(pa.table(simulate(robot, course, recorder=Recorder(125.0), seed=seed)), f"run{seed}.csv")


@functools.cache
def diagnosed(masses: tuple[float, ...], stated: float) -> Diagnosis:
    return diagnose_log(merge_logs([run(mass, seed) for seed, mass in enumerate(masses)]), holding(stated))


def told(diagnosis: Diagnosis) -> list[tuple[float, str]]:
    """Return the mass and the evidence of every payload that is told, nothing else being told."""
    assert {(finding.cause, finding.joint) for finding in diagnosis.findings} <= {("body.payload", None)}
    return [(finding.parameters[0].value, finding.evidence) for finding in diagnosis.findings]


@pytest.mark.parametrize(
    ("masses", "held", "logs"),
    [
        ((0.0, 1.5), 1.5, "run1.csv"),
        deep((1.5, 0.0), 1.5, "run0.csv"),
        deep((0.0, 1.5, 1.5), 1.5, "run1.csv and run2.csv"),
    ],
)
def test_it_is_told_of_the_logs_that_have_it(masses: tuple[float, ...], held: float, logs: str) -> None:
    diagnosis = diagnosed(masses, 0.0)
    assert diagnosis.verdict is Verdict.EXPLAINED
    ((mass, evidence),) = told(diagnosis)
    assert mass == pytest.approx(held, rel=0.05)
    assert f"in {logs} alone" in evidence


def test_the_extended_robot_predicts_both() -> None:
    log = merge_logs([run(0.0, 0), run(1.5, 1)])
    extended = predict_log(log, diagnosed((0.0, 1.5), 0.0).robot)
    for k, mass in enumerate((0.0, 1.5)):
        own = log.segment == k
        truth = predict_log(log, holding(mass))
        for joint in holding(0.0).joints:
            name = f"effort.{joint}"
            assert np.sqrt(np.mean(np.square(extended[name] - truth[name])[own])) < 0.1


@pytest.mark.deep
def test_a_payload_that_is_put_down_is_told_too() -> None:
    diagnosis = diagnosed((0.0, 1.5), 1.5)
    ((mass, evidence),) = told(diagnosis)
    assert mass == pytest.approx(-1.5, rel=0.05)
    assert "in run0.csv alone" in evidence
    (put_down,) = diagnosis.robot.table.taken_up
    assert put_down.mass == pytest.approx(-1.5, rel=0.05)
    assert put_down.com == pytest.approx(CENTRE, abs=0.01)


@pytest.mark.deep
def test_another_tool_of_the_same_mass_is_another_payload() -> None:
    robot = holding(1.5)
    longer = Payload(mass=1.5, com=(0.02, 0.01, 0.3), parent=FLANGE)
    second = recorded(Robot(robot.table.model_copy(update={"payload": longer}), robot.folder), 1)
    diagnosis = diagnose_log(merge_logs([run(1.5, 0), second]), robot)
    ((mass, _),) = told(diagnosis)
    assert mass == pytest.approx(0.0, abs=0.05)
    put_down, taken_up = diagnosis.robot.table.taken_up
    assert put_down.mass == -1.5
    assert taken_up.mass == pytest.approx(1.5, rel=0.05)
    assert taken_up.com[2] == pytest.approx(0.3, abs=0.02)


@pytest.mark.deep
def test_one_that_all_hold_and_more_in_one_are_two() -> None:
    payloads = told(diagnosed((1.0, 3.0, 1.0), 0.0))
    assert sorted(mass for mass, _ in payloads) == [pytest.approx(1.0, rel=0.05), pytest.approx(2.0, rel=0.05)]


@pytest.mark.deep
def test_what_all_logs_hold_is_held_throughout() -> None:
    ((_, evidence),) = told(diagnosed((1.5, 1.5), 0.0))
    assert "alone" not in evidence


@pytest.mark.deep
def test_friction_of_another_day_is_no_payload() -> None:
    log = merge_logs([run(0.0, 0), run(0.0, 1)])
    robot = holding(0.0)
    lift = robot.table.joint[1]
    eased = Event(time=float(log.joined[1][1]), coulomb=-4.0)  # stated of a machine whose friction stays as it was
    diagnosis = diagnose_log(log, robot.with_joint(lift.model_copy(update={"events": (eased,)})))
    assert [(finding.cause, finding.joint) for finding in diagnosis.findings] == [("event.change", lift.name)]


def test_one_log_has_no_while() -> None:
    assert PayloadForAWhile().sites(measure_gap(run(1.5, 1), holding(0.0))) == []


def test_its_columns_are_those_of_a_mass_that_is_held_from_begin_to_end() -> None:
    gap = measure_gap(merge_logs([run(0.0, 0), run(1.5, 1)]), holding(0.0))
    cause = PayloadForAWhile()
    for site in cause.sites(gap):
        held = is_held(site.begin, site.end, gap.motion.time)
        torques = cause.torques(gap) * held[:, None, None]
        for joint, values in cause.columns(gap, site).items():
            np.testing.assert_allclose(values, gap.reported(joint, torques[:, joint]), atol=1e-9)
