"""The extended robot says the same as the fit it came from, and is again a robot file."""

from __future__ import annotations

import functools
import itertools
from dataclasses import replace
from pathlib import Path

import mujoco
import numpy as np
import pytest

from mjfriction.diagnose.causes.catalog import STRUCTURAL
from mjfriction.diagnose.diagnosis import diagnose_log
from mjfriction.identify.measure import measure_gap
from mjfriction.record.readers import read_log
from mjfriction.robot.files import read_robot
from mjfriction.robot.friction_tables import FrictionTerm
from mjfriction.robot.simulation import robot_laws
from tests.deep import deep
from tests.diagnose.in_the_file import left_by_the_file
from tests.hidden.machine import Instant, Machine, write_case

JOINT = "elbow_joint"
LOAD, HELD_AT = 2.0, np.array([0.0, 0.05, 0.1])  # kg; m from the last link


def everything(i: Instant) -> np.ndarray:
    return 3.0 * np.sign(i.v) * np.exp(-((i.v / 0.15) ** 2)) + 3.0 * np.abs(i.v) + 0.6


@pytest.mark.parametrize("off", [deep(0.0), 0.05])
def test_the_robot_file_predicts_what_the_fit_left(off: float, tmp_path: Path) -> None:
    log_path, robot_path = write_case(tmp_path, Machine(hidden={2: everything}), seed=3, off=off)
    diagnosis = diagnose_log(read_log(log_path), read_robot(robot_path))
    assert len(diagnosis.findings) >= 2
    again = left_by_the_file(diagnosis, tmp_path / "extended")
    np.testing.assert_allclose(again, diagnosis.residual_after, atol=1e-4 * np.abs(diagnosis.gap.measured).max())


@pytest.mark.deep
def test_a_scaled_sensor_scales_what_lies_before_it(tmp_path: Path) -> None:
    machine = Machine(hidden={1: lambda i: 0.15 * (i.rigid + i.friction)})
    log_path, robot_path = write_case(tmp_path, machine, seed=3)
    diagnosis = diagnose_log(read_log(log_path), read_robot(robot_path))
    assert diagnosis.robot.joint("shoulder_lift_joint").effort_sensor.scale == pytest.approx(1.15, abs=0.01)


@pytest.mark.deep
def test_diagnosing_the_extended_robot_finds_nothing_more(tmp_path: Path) -> None:
    log_path, robot_path = write_case(tmp_path, Machine(hidden={2: everything}), seed=3)
    log = read_log(log_path)
    first = diagnose_log(log, read_robot(robot_path))
    assert diagnose_log(log, first.robot).findings == ()


def test_any_two_causes_on_one_joint_make_a_robot_that_can_be_simulated(tmp_path: Path) -> None:
    log, path = write_case(tmp_path, Machine(), seed=3, seconds=10.0)
    robot = read_robot(path)
    curve = {"coulomb": 3.0, "static": 4.0, "stribeck_velocity": 0.05, "stribeck_exponent": 2.0, "viscous": 2.0}
    term = FrictionTerm(law="stribeck", parameters=curve)
    gap = measure_gap(read_log(log), robot.with_joint(robot.joint(JOINT).model_copy(update={"friction": (term,)})))
    extensions = []
    for cause in STRUCTURAL:
        sites = cause.sites(gap)
        at = next((site for site in sites if gap.robot.joints[site.joint] == JOINT), next(iter(sites), None))
        if at is None:
            continue  # its column is not in the log
        size = len(cause.quantities(gap, at))
        # A payload's moments go with its mass, and a play is drawn around its size.
        tried = [np.full(size, one) for one in (0.3, 5.0, 1.0, 1e-3, at.around)] + [
            np.append(0.3, np.full(size - 1, 0.01))
        ]
        strengths = next(own for own in tried if cause.admissible(gap, at, own))
        extensions.append(functools.partial(cause.extend, site=at, strengths=strengths))
    # No temperature and no pressures are logged, this robot states no rotors that could load their gears and no offset,
    # no link lands with a blow, and there is but one log.
    assert len(extensions) == len(STRUCTURAL) - 7
    for first, then in itertools.permutations(extensions, 2):
        robot_laws(then(first(gap.robot)))


def carried(model: mujoco.MjModel) -> None:
    """Let the last link carry a point mass of 2 kg."""
    link = model.body("wrist_3_link").id
    own, centre = float(model.body_mass[link]), model.body_ipos[link].copy()
    model.body_mass[link] = own + LOAD
    model.body_ipos[link] = (own * centre + LOAD * HELD_AT) / (own + LOAD)
    model.body_sameframe[link] = model.body_simple[link] = 0


@pytest.mark.deep
def test_what_all_joints_feel_is_not_divided_by_one_sensors_scale(tmp_path: Path) -> None:
    """A mass is no less for the drive that reports too much of it; the drive's own friction, fitted behind it, is."""
    machine = Machine(hidden={1: lambda i: 0.3 * (i.rigid + i.friction + 4.0 * np.abs(i.v)) + 4.0 * np.abs(i.v)})
    log_path, robot_path = write_case(tmp_path, replace(machine, change=carried), seed=3, seconds=40.0)
    diagnosis = diagnose_log(read_log(log_path), read_robot(robot_path))
    told = {finding.cause: {own.name: own.value for own in finding.parameters} for finding in diagnosis.findings}
    assert told.keys() == {"body.payload", "drive.torque_constant", "friction.asymmetry"}
    payload = diagnosis.robot.table.payload
    assert payload is not None
    assert told["body.payload"]["mass"] == payload.mass == pytest.approx(LOAD, rel=0.01)
    np.testing.assert_allclose(payload.com, HELD_AT, atol=2e-3)
    assert told["friction.asymmetry"]["viscous_asymmetry"] == pytest.approx(4.0, rel=0.05)
    again = left_by_the_file(diagnosis, tmp_path / "extended")
    np.testing.assert_allclose(again, diagnosis.residual_after, atol=2e-3 * np.abs(diagnosis.gap.measured).max())
