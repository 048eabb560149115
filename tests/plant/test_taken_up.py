"""What an arm takes up for a while weighs on it as a payload does, while it is held and no longer."""

from __future__ import annotations

import numpy as np
import pyarrow as pa
import pytest

from mjfriction.body.inverse import inverse_dynamics
from mjfriction.errors import RobotError, SimulationError
from mjfriction.plant.machine import run_machine, simulate
from mjfriction.plant.motions import excitation
from mjfriction.plant.sensors import Recorder
from mjfriction.plant.trajectory import Trajectory
from mjfriction.record.readers.table import log_from_table
from mjfriction.robot.body_tables import Payload, TakenUp
from mjfriction.robot.files import read_robot, write_robot
from mjfriction.robot.predict import predict_log
from mjfriction.robot.robot import Robot
from tests.cli.here import mjfriction_here
from tests.plant.bare import frictionless

HOME = np.array([0.0, -1.2, 1.4, -0.4, 1.2, 0.0])
PLACE = {"com": (0.03, -0.02, 0.1), "parent": "wrist_3_joint"}
MASS, BEGIN, END = 3.0, 2.0, 5.0


def arm(**changes: object) -> Robot:
    robot = frictionless(read_robot("ur5"))
    return Robot(robot.table.model_copy(update=changes), robot.folder)


def motion(robot: Robot) -> Trajectory:
    count = len(robot.joints)
    return excitation(robot.joints, HOME, np.full(count, 0.4), np.full(count, 0.8), 8.0, seed=1)


def still(robot: Robot) -> Trajectory:
    time = np.linspace(0.0, 8.0, 50)
    return Trajectory(robot.joints, time, np.tile(HOME, (time.size, 1)))


TAKES = arm(taken_up=(TakenUp(mass=MASS, begin=BEGIN, end=END, **PLACE),))
HOLDS = arm(payload=Payload(mass=MASS, **PLACE))
PUTS_DOWN = arm(payload=Payload(mass=MASS, **PLACE), taken_up=(TakenUp(mass=-MASS, begin=BEGIN, end=END, **PLACE),))


@pytest.mark.parametrize("puts_down", [False, True])
def test_the_machine_carries_it_from_its_beginning_to_its_end(*, puts_down: bool) -> None:
    machine, before, between = (PUTS_DOWN, HOLDS, arm()) if puts_down else (TAKES, arm(), HOLDS)
    run = run_machine(machine, still(machine), 1000.0)
    rest = np.zeros((1, HOME.size))
    for moment, robot in ((1.9, before), (4.9, between), (7.9, before)):
        k = round(1000 * moment)
        needed, otherwise = (
            inverse_dynamics(one.body(), run.played.position[k : k + 1], rest, rest)[0]
            for one in ((robot, HOLDS if robot is not HOLDS else arm()))
        )
        assert np.max(np.abs(needed - otherwise)) > 10.0
        np.testing.assert_allclose(run.played.torque[k], needed, atol=0.02)


def test_what_the_machine_logs_is_what_the_robot_predicts() -> None:
    log = log_from_table(pa.table(simulate(TAKES, motion(TAKES), recorder=Recorder(1000.0))), "log")
    told, empty, laden = (predict_log(log, robot) for robot in (TAKES, arm(), HOLDS))
    held = (log.time >= BEGIN) & (log.time < END)
    settled = np.all([np.abs(log.time - moment) > 0.3 for moment in (BEGIN, END, 0.0)], axis=0)
    for joint in TAKES.joints:
        name = f"effort.{joint}"
        np.testing.assert_allclose(told[name], np.where(held, laden[name], empty[name]), atol=1e-9)
        off = np.sqrt(np.mean(np.square(log.columns[name] - told[name])[settled]))
        assert off < 0.02 * max(1.0, float(np.ptp(laden[name])))


def test_what_is_set_down_is_a_mass_below_none() -> None:
    log = log_from_table(pa.table(simulate(arm(), motion(arm()), recorder=Recorder(250.0))), "log")
    down = Robot(
        HOLDS.table.model_copy(update={"taken_up": (TakenUp(mass=-MASS, begin=BEGIN, **PLACE),)}), HOLDS.folder
    )
    told, empty, laden = (predict_log(log, robot) for robot in (down, arm(), HOLDS))
    after = log.time >= BEGIN
    for name, values in told.items():
        if name.startswith("effort"):
            np.testing.assert_allclose(values, np.where(after, empty[name], laden[name]), atol=1e-9)


def test_it_is_written_and_read_back(tmp_path) -> None:
    assert read_robot(write_robot(TAKES, tmp_path)).table == TAKES.table


@pytest.mark.parametrize(
    ("entry", "said"),
    [
        ("{ mass = 1.0, parent = 'wrist_3_joint', begin = 3.0, end = 2.0 }", "begins at 3 s"),
        ("{ mass = 1.0, parent = 'wrist_3_joint' }", "begin"),
        ("{ mass = 1.0, parent = 'wrist_3_joint', from = 1.0 }", "unknown key 'from'"),
        ("{ mass = -1.0, parent = 'wrist_3_joint', begin = 1.0 }", "a mass below 0 puts a payload down"),
    ],
)
def test_what_makes_no_sense_is_one_line(entry: str, said: str, tmp_path) -> None:
    path = write_robot(arm(), tmp_path)
    path.write_text(f"taken_up = [{entry}]\n" + path.read_text())
    with pytest.raises(RobotError, match=said) as told:
        read_robot(path)
    assert "\n" not in str(told.value)


def test_a_link_that_there_is_not_is_named() -> None:
    lost = arm(taken_up=(TakenUp(mass=1.0, begin=0.0, parent="hand"),))
    log = log_from_table(pa.table(simulate(arm(), motion(arm()), recorder=Recorder(250.0))), "log")
    with pytest.raises(RobotError, match="taken_up: parent 'hand' is no link"):
        predict_log(log, lost)
    with pytest.raises(SimulationError, match="taken_up_0: there is no body or joint 'hand'"):
        run_machine(lost, still(lost), 500.0)


def test_what_plain_models_cannot_hold_is_said(tmp_path) -> None:
    path = write_robot(TAKES, tmp_path)
    done = mjfriction_here("export", "--robot", str(path), "--out", str(tmp_path / "plain.xml"))
    assert done.returncode == 0, done.stderr
    assert "not in the model: taken_up of the robot" in done.stdout
    assert "taken_up_0" not in (tmp_path / "plain.xml").read_text()
