"""Friction that is another at one place of the stroke, or from there on: predicted, simulated, and written down."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pyarrow as pa
import pytest

from mjfriction.errors import RobotError
from mjfriction.laws.ambient import ambient
from mjfriction.plant.machine import simulate
from mjfriction.plant.motions import excitation
from mjfriction.plant.sensors import Recorder
from mjfriction.record.log import Floats
from mjfriction.record.readers.table import log_from_table
from mjfriction.robot import edges, spots
from mjfriction.robot.edges import edge_as_waves, edge_slopes_along, edges_along
from mjfriction.robot.files import read_robot, write_robot
from mjfriction.robot.friction import with_friction_edge, with_friction_spot
from mjfriction.robot.predict import predict_log
from mjfriction.robot.robot import Robot
from mjfriction.robot.simulation import robot_laws
from mjfriction.robot.spots import as_waves, spot_slopes_along, spots_along
from mjfriction.robot.table import Edge, Spot, Wave

ELBOW = "elbow_joint"
SPOT = Spot(position=1.3, width=0.08, coulomb=4.0)
EDGE = Edge(position=1.3, width=0.02, coulomb=4.0)


@dataclass(frozen=True)
class Place:
    """One form of such friction, with the robot that states it."""

    robot: Robot
    course: Callable[[Floats], Floats]
    slope: Callable[[Floats], Floats]
    waves: tuple[float, tuple[Wave, ...]]
    period: float
    reach: float  # how far on both sides the waves have to stand for it


def edge(side: str) -> Place:
    own = EDGE.model_copy(update={"side": side})
    return Place(
        with_friction_edge(read_robot("ur5"), ELBOW, own),
        lambda q: edges_along([own], q),
        lambda q: edge_slopes_along([own], q),
        edge_as_waves(own),
        edges.APART * own.width,
        0.48 * edges.APART * own.width,
    )


PLACES = {
    "spot": Place(
        with_friction_spot(read_robot("ur5"), ELBOW, SPOT),
        lambda q: spots_along([SPOT], q),
        lambda q: spot_slopes_along([SPOT], q),
        as_waves(SPOT),
        spots.APART * SPOT.width,
        55.0 * SPOT.width,
    ),
    "above": edge("above"),
    "below": edge("below"),
}
each = pytest.mark.parametrize("place", PLACES.values(), ids=PLACES.keys())


@each
def test_waves_stand_for_it_wherever_its_stroke_may_go(place: Place) -> None:
    level, waves = place.waves
    stroke = np.linspace(1.3 - place.reach, 1.3 + place.reach, 8001)
    series = level + sum(
        wave.cosine * np.cos(wave.wavenumber * stroke) + wave.sine * np.sin(wave.wavenumber * stroke) for wave in waves
    )
    np.testing.assert_allclose(series, place.course(stroke), atol=2e-3 * 4.0)
    assert waves[0].wavenumber == pytest.approx(2.0 * np.pi / place.period)


@each
def test_its_slope_is_that_of_the_curve(place: Place) -> None:
    stroke = np.linspace(0.9, 1.7, 8001)
    slope = np.gradient(place.course(stroke), stroke)
    np.testing.assert_allclose(place.slope(stroke)[1:-1], slope[1:-1], atol=2e-3 * np.max(np.abs(slope)))


def test_an_edge_is_on_its_side_and_two_sides_make_a_level() -> None:
    far = np.array([EDGE.position - 1.0, EDGE.position, EDGE.position + 1.0])
    above, below = (PLACES[side].course(far) for side in ("above", "below"))
    np.testing.assert_allclose(above, [0.0, 0.5 * EDGE.coulomb, EDGE.coulomb], atol=1e-12)
    np.testing.assert_allclose(above + below, EDGE.coulomb)


@each
def test_in_mujoco_the_level_is_what_the_file_says(place: Place) -> None:
    (law,) = robot_laws(place.robot)[ELBOW]
    (stated,) = place.robot.joint(ELBOW).friction or ()
    for where in (0.8, 1.28, 1.3, 1.38, 1.9):
        torque = law.steady(np.array([0.5]), ambient(1, position=where))[0]
        (more,) = place.course(np.array([where]))
        assert torque == pytest.approx(stated.value("coulomb") + more + 0.5 * stated.value("viscous"), rel=1e-3)


@each
def test_the_log_of_such_a_machine_is_what_its_file_predicts(place: Place) -> None:
    home, count = np.array([0.0, -1.2, 1.3, -0.4, 1.2, 0.0]), len(place.robot.joints)
    motion = excitation(place.robot.joints, home, np.full(count, 0.5), np.full(count, 0.8), 8.0, seed=1)
    log = log_from_table(pa.table(simulate(place.robot, motion, recorder=Recorder(500.0))), "worn")
    speed = np.abs(np.gradient(log.columns[f"position.{ELBOW}"], log.time))
    sure = (speed > 0.2 * np.max(speed)) & (log.time > 1.0) & (log.time < 7.0)
    with_it, without = (
        np.std((log.columns[f"effort.{ELBOW}"] - predict_log(log, robot)[f"effort.{ELBOW}"])[sure])
        for robot in (place.robot, read_robot("ur5"))
    )
    assert without > 0.2 * SPOT.coulomb
    assert with_it < 0.03 * without


@each
def test_it_is_written_and_read_back_and_has_to_have_a_width(place: Place, tmp_path: Path) -> None:
    path = write_robot(place.robot, tmp_path)
    assert read_robot(path).joint(ELBOW) == place.robot.joint(ELBOW)
    path.write_text(re.sub("width = [0-9.]+", "width = 0.0", path.read_text()))
    with pytest.raises(RobotError, match="width"):
        read_robot(path)


def test_an_edge_is_above_or_below(tmp_path: Path) -> None:
    path = write_robot(PLACES["below"].robot, tmp_path)
    path.write_text(path.read_text().replace('side = "below"', 'side = "left"'))
    with pytest.raises(RobotError, match="above"):
        read_robot(path)
