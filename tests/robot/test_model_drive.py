"""What a robot states beside its MuJoCo model acts all the same where a log's efforts drive the model."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pyarrow as pa
import pytest

from mjfriction.errors import RobotError
from mjfriction.identify.measure import measure_gap
from mjfriction.identify.stretches import LOST, cut_stretches, missed, simulated_error
from mjfriction.plant.machine import simulate
from mjfriction.plant.motions import excitation
from mjfriction.plant.sensors import Recorder
from mjfriction.record.log import Log
from mjfriction.record.readers.table import log_from_table
from mjfriction.robot.body_tables import Payload, Place, TakenUp
from mjfriction.robot.files import read_robot
from mjfriction.robot.model_drive import drive_model
from mjfriction.robot.robot import Robot
from mjfriction.robot.schema import Joint

ELBOW, WRIST = "elbow_joint", "wrist_1_joint"
HOME = np.array([0.0, -1.2, 1.4, -0.4, 1.2, 0.0])
SECONDS = 0.25
STATED = read_robot("ur5")
HELD = TakenUp(mass=3.0, begin=2.0, end=6.0, com=(0.03, -0.02, 0.1), parent="wrist_3_joint")

WARM = {"coulomb": 9.0, "viscous": 6.0, "viscous_decay": 20.0, "coulomb_per_kelvin": -0.01}

BESIDE = {
    "cogging": {"cogging": [{"wavenumber": 9.0, "cosine": 4.0, "sine": 2.0}]},
    "ripple": {"actuator": {"ripple": [{"wavenumber": 9.0, "cosine": 0.2}]}},
    "one-way": {"coupling": [{"joint": WRIST, "coulomb": 3.0, "viscous": 2.0, "inertia": 0.5}]},
    "shared": {"coupling": [{"joint": WRIST, "effort": 0.8}]},
    "common drive": {"common_drive": [{"joint": WRIST, "ratio": 1.0, "coulomb": 2.0, "inertia": 0.4}]},
    "warm-up": {"warm_up": {"coulomb": -6.0, "time_constant": 3.0}},
    "event": {"events": [{"time": 3.0, "coulomb": 8.0}]},
    "thermal": {"thermal": {"coulomb_per_kelvin": -0.2, "reference_temperature": 25.0}},
    "a law of temperature": {"friction": {"law": "temperature_dependent", "parameters": WARM}},
    "play": {"transmission": {"backlash": 0.02}},
    "late": {"effort_sensor": {"delay": 0.02}},
    "scaled": {"effort_sensor": {"scale": 1.2, "offset": 4.0}},
    "zero": {"position_sensor": {"offset": 0.15}},
}


def elbow(**keys: object) -> Robot:
    own = STATED.joint(ELBOW)
    changed = Joint.model_validate({"name": ELBOW, "friction": own.friction, **keys})
    actuator = own.actuator.model_copy(update={"ripple": changed.actuator.ripple})
    return STATED.with_joint(changed.model_copy(update={"actuator": actuator}))


def logged(machine: Robot) -> Log:
    count = len(STATED.joints)
    motion = excitation(STATED.joints, HOME, np.full(count, 0.5), np.full(count, 1.0), 8.0, seed=1)
    warming = {f"temperature.{ELBOW}": np.linspace(25.0, 60.0, motion.time.size)}
    columns = simulate(machine, replace(motion, ambient=warming), recorder=Recorder(500.0))
    return log_from_table(pa.table(columns), "log")


def off(log: Log, robot: Robot) -> float:
    return float(simulated_error(measure_gap(log, robot), robot, SECONDS)[0][STATED.joints.index(ELBOW)])


@pytest.mark.parametrize("name", BESIDE)
def test_a_machine_with_something_beside_its_model_goes_where_its_log_says(name: str) -> None:
    machine = elbow(**BESIDE[name])
    log = logged(machine)
    assert off(log, machine) < 0.1 * off(log, STATED)


def test_what_a_robot_holds_for_a_while_weighs_on_its_model() -> None:
    machine = Robot(STATED.table.model_copy(update={"taken_up": (HELD,)}), STATED.folder)
    log = logged(machine)
    assert off(log, machine) < 0.1 * off(log, STATED)


def test_so_does_what_the_log_says_it_held() -> None:
    place = Place(com=HELD.com, parent=HELD.parent)
    laden = Robot(STATED.table.model_copy(update={"payload": Payload(mass=3.0, **place.model_dump())}), STATED.folder)
    holder = Robot(STATED.table.model_copy(update={"held": place}), STATED.folder)
    log = logged(laden)
    assert off(log.holding(3.0), holder) < 0.1 * off(log, holder)


def test_a_link_behind_a_transmission_that_gives_is_where_its_load_takes_it() -> None:
    machine = elbow(transmission={"compliance": 1e-3, "damping_ratio": 0.5})
    log = logged(machine)
    # The model is rigid: where the link swings it is known along the measured motion only.
    assert off(log, machine) < 0.6 * off(log, STATED)


def test_of_a_report_that_is_low_passed_a_falling_arm_feels_nothing() -> None:
    machine = elbow(effort_sensor={"bandwidth": 12.0})
    log = logged(machine)
    assert off(log, machine) == pytest.approx(off(log, STATED))


def test_a_robot_that_its_model_holds_is_driven_by_what_was_reported() -> None:
    gap = measure_gap(logged(STATED), STATED)
    alone = replace(gap.motion, columns={})
    np.testing.assert_array_equal(drive_model(STATED, alone).torque, gap.motion.torque)
    # Asked in full, as where the log has a temperature, it comes to the same.
    np.testing.assert_allclose(drive_model(STATED, gap.motion).torque, gap.motion.torque, atol=1e-9)


def test_a_joint_that_its_brake_holds_stays_where_it_is() -> None:
    log = logged(STATED)
    held, moved = STATED.joints[0], STATED.joints.index(ELBOW)
    # Its drive is off; without the brake the pan joint would have to answer for what the others do to it.
    columns = {
        **log.columns,
        f"position.{held}": np.zeros_like(log.time),
        f"effort.{held}": np.zeros_like(log.time),
    }
    braked = replace(log, columns=columns)
    gap = measure_gap(braked, STATED)
    assert STATED.joints.index(held) not in gap.examined
    error, _ = simulated_error(gap, STATED, SECONDS)
    assert error[0] < 1e-9
    assert np.isfinite(error[moved])


def test_a_joint_that_moves_by_an_effort_nobody_logged_is_named() -> None:
    log = logged(STATED)
    unlogged = replace(log, columns={name: own for name, own in log.columns.items() if name != f"effort.{ELBOW}"})
    with pytest.raises(RobotError, match=f"efforts of all joints, and {ELBOW} has none"):
        simulated_error(measure_gap(unlogged, STATED), STATED, SECONDS)


def test_a_joint_that_moves_while_its_drive_says_one_thing_is_named_too() -> None:
    log = logged(STATED)
    silent = replace(log, columns={**log.columns, f"effort.{ELBOW}": np.zeros_like(log.time)})
    with pytest.raises(RobotError, match=f"efforts of all joints, and {ELBOW} has none"):
        simulated_error(measure_gap(silent, STATED), STATED, SECONDS)


def test_a_robot_without_laws_has_what_its_model_file_states() -> None:
    bare = STATED
    for joint in STATED.table.joint:
        bare = bare.with_joint(joint.model_copy(update={"friction": None}))
    log = logged(bare)
    assert off(log, bare) < 1e-3
    assert off(log, STATED) > 10.0 * off(log, bare)


def test_a_model_that_flies_away_is_lost_and_does_not_begin_anew() -> None:
    gap = measure_gap(logged(STATED), STATED)
    fixed = cut_stretches(gap, STATED, SECONDS)
    mad = replace(fixed, reported=1e14 * fixed.reported)
    assert np.max(np.abs(missed(gap, [STATED], mad))) >= LOST
