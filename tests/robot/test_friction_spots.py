"""Friction that is another at one place of the stroke: predicted, simulated, and written down."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pyarrow as pa
import pytest

from mjfriction.errors import RobotError
from mjfriction.laws.ambient import ambient
from mjfriction.plant.machine import simulate
from mjfriction.plant.motions import excitation
from mjfriction.plant.sensors import Recorder
from mjfriction.record.readers.table import log_from_table
from mjfriction.robot.files import read_robot, write_robot
from mjfriction.robot.friction import with_friction_spot
from mjfriction.robot.predict import predict_log
from mjfriction.robot.simulation import robot_laws
from mjfriction.robot.spots import APART, as_waves, spot_slopes_along, spots_along
from mjfriction.robot.table import Spot

ELBOW = "elbow_joint"
SPOT = Spot(position=1.3, width=0.08, coulomb=4.0)
WORN = with_friction_spot(read_robot("ur5"), ELBOW, SPOT)
STROKE = np.linspace(SPOT.position - 55.0 * SPOT.width, SPOT.position + 55.0 * SPOT.width, 8001)


def test_waves_that_stand_for_a_spot_are_that_spot_wherever_its_stroke_may_go() -> None:
    level, waves = as_waves(SPOT)
    series = level + sum(
        wave.cosine * np.cos(wave.wavenumber * STROKE) + wave.sine * np.sin(wave.wavenumber * STROKE) for wave in waves
    )
    np.testing.assert_allclose(series, spots_along([SPOT], STROKE), atol=1e-3 * SPOT.coulomb)
    assert waves[0].wavenumber == pytest.approx(2.0 * np.pi / (APART * SPOT.width))


def test_its_slope_is_that_of_the_curve() -> None:
    slope = np.gradient(spots_along([SPOT], STROKE), STROKE)
    np.testing.assert_allclose(spot_slopes_along([SPOT], STROKE)[1:-1], slope[1:-1], atol=2e-3 * np.max(slope))


def test_in_mujoco_the_level_is_what_the_file_says() -> None:
    (law,) = robot_laws(WORN)[ELBOW]
    (stated,) = WORN.joint(ELBOW).friction or ()
    for place, more in ((SPOT.position, SPOT.coulomb), (SPOT.position + SPOT.width, SPOT.coulomb * np.exp(-0.5))):
        torque = law.steady(np.array([0.5]), ambient(1, position=place))[0]
        assert torque == pytest.approx(stated.value("coulomb") + more + 0.5 * stated.value("viscous"), rel=1e-3)


def test_the_log_of_a_worn_machine_is_what_its_file_predicts() -> None:
    home, count = np.array([0.0, -1.2, 1.3, -0.4, 1.2, 0.0]), len(WORN.joints)
    motion = excitation(WORN.joints, home, np.full(count, 0.5), np.full(count, 0.8), 8.0, seed=1)
    log = log_from_table(pa.table(simulate(WORN, motion, recorder=Recorder(500.0))), "worn")
    speed = np.abs(np.gradient(log.columns[f"position.{ELBOW}"], log.time))
    sure = (speed > 0.2 * np.max(speed)) & (log.time > 1.0) & (log.time < 7.0)
    with_it, without = (
        np.std((log.columns[f"effort.{ELBOW}"] - predict_log(log, robot)[f"effort.{ELBOW}"])[sure])
        for robot in (WORN, read_robot("ur5"))
    )
    assert without > 0.2 * SPOT.coulomb
    assert with_it < 0.03 * without


def test_it_is_written_and_read_back_and_has_to_have_a_width(tmp_path: Path) -> None:
    path = write_robot(WORN, tmp_path)
    assert read_robot(path).joint(ELBOW).friction_spots == (SPOT,)
    path.write_text(path.read_text().replace("width = 0.08", "width = 0.0"))
    with pytest.raises(RobotError, match="width"):
        read_robot(path)
