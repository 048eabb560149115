"""A cylinder's friction from constant voltages: what steady speeds tell, and what only looks as if they did."""

from __future__ import annotations

import numpy as np
import pyarrow as pa
import pytest

from mjfriction.errors import LogError
from mjfriction.identify.identification import identify_log
from mjfriction.identify.pressure import (
    SteadyPoints,
    choose_variant,
    fit_variant,
    pressure_law,
    steady_points,
)
from mjfriction.laws.ambient import ambient
from mjfriction.laws.friction import friction
from mjfriction.plant.machine import simulate
from mjfriction.plant.motions import valve_steps
from mjfriction.plant.sensors import Recorder
from mjfriction.plant.trajectory import Trajectory
from mjfriction.record.log import Log
from mjfriction.record.merge import merge_logs
from mjfriction.record.readers.table import log_from_table
from mjfriction.robot.files import read_robot

VOLTS = [1.5, 3.0, 5.0, 8.0]


def recorded(supply: float) -> Log:
    robot = read_robot("hydraulic_cylinder")
    of = robot.joint("piston").hydraulics
    assert of is not None
    steps = valve_steps("piston", of, 0.06, VOLTS)
    course = {**steps.ambient, "supply_pressure": np.full(steps.time.size, supply)}
    columns = simulate(robot, Trajectory((), steps.time, steps.position, course), recorder=Recorder(500.0))
    return log_from_table(pa.table(columns), "voltages")


@pytest.fixture(scope="module")
def logs() -> list[Log]:
    return [recorded(8e6), recorded(4e6)]


@pytest.fixture(scope="module")
def points(logs: list[Log]) -> SteadyPoints:
    return steady_points(logs, read_robot("hydraulic_cylinder"), "piston")


@pytest.mark.deep
def test_the_law_found_predicts_the_force_at_every_speed_and_supply(points: SteadyPoints) -> None:
    chosen = [choose_variant(points, way)[0] for way in ("extending", "retracting")]
    assert [variant.number for variant in chosen] == [5, 5]
    law = friction("pressure", pressure_law(*chosen))
    told = law.steady(points.speed, ambient(points.speed.size, pressure_head=points.head, pressure_rod=points.rod))
    assert np.max(np.abs(told - points.force)) < 5.0
    # The supply's part is what it takes: without the pressures some tens of newtons remain.
    assert fit_variant(points, "extending", 4).rms > 10.0 * chosen[0].rms


@pytest.mark.deep
def test_two_free_pressures_find_the_pistons_areas_whatever_friction_is(points: SteadyPoints) -> None:
    of = read_robot("hydraulic_cylinder").joint("piston").hydraulics
    assert of is not None
    for way, sign in (("extending", 1.0), ("retracting", -1.0)):
        whole, less = (fit_variant(points, way, number) for number in (2, 3))  # type: ignore[arg-type]
        assert less.rms < 1e-2
        assert less.values["pressure_difference"] == pytest.approx(of.head_area, rel=1e-3)
        assert less.values["rod_pressure"] == pytest.approx(sign * (of.head_area - of.rod_area), rel=1e-3)
        assert less.criterion < whole.criterion, "a parameter that takes nothing off does not earn its keep"
    # Pressures drawn by lot, as no friction makes them: the areas fit those as well.
    head, rod = 1e6 * np.random.default_rng(0).uniform(1.0, 8.0, (2, points.speed.size))
    drawn = SteadyPoints(points.speed, of.head_area * head - of.rod_area * rod, head, rod, points.error)
    assert fit_variant(drawn, "extending", 3).rms < 1e-2
    assert fit_variant(drawn, "extending", 5).rms > 100.0


@pytest.mark.deep
def test_friction_that_follows_the_pressures_is_identified_from_the_motion(logs: list[Log]) -> None:
    stated = read_robot("hydraulic_cylinder")
    left = {}
    for law in ("pressure", "asymmetric"):
        found = identify_log(merge_logs(logs), stated, law=law)
        left[law] = found.joints[0].rms_heldout_after
        if law == "pressure":
            fitted = {parameter.name: parameter for parameter in found.laws[0].parameters}
            assert fitted["rod_pressure_extending"].low > 0.0
            assert fitted["rod_pressure_retracting"].low > fitted["rod_pressure_extending"].high
    assert left["pressure"] < 0.4 * left["asymmetric"]


def test_growth_with_speed_is_found_where_there_is_one() -> None:
    speed = np.linspace(0.02, 1.5, 12)
    force = 300.0 * np.exp(0.9 * speed) + 20.0 * speed
    zeros = np.zeros(speed.size)
    made = SteadyPoints(speed, force, 1e5 + zeros, 1e5 + zeros, 0.1 + zeros)
    found = fit_variant(made, "extending", 1)
    assert found.values["growth"] == pytest.approx(0.9, rel=0.02)
    assert found.values["level"] == pytest.approx(300.0, rel=0.02)


@pytest.mark.deep
def test_what_cannot_be_told_is_refused_by_name(points: SteadyPoints, logs: list[Log]) -> None:
    robot = read_robot("hydraulic_cylinder")
    few = SteadyPoints(*(values[:3] for values in (points.speed, points.force, points.head, points.rod, points.error)))
    with pytest.raises(LogError, match=r"model 2 of law 'pressure' has 5 parameters.*at least 6"):
        fit_variant(few, "extending", 2)
    with pytest.raises(LogError, match="moved by no cylinder"):
        steady_points(logs, read_robot("machine_table"), "axis")
    table = pa.table({name: values for name, values in logs[0].columns.items() if not name.startswith("pressure")})
    bare = log_from_table(table.append_column("time", pa.array(logs[0].time)), "bare")
    with pytest.raises(LogError, match="no column 'pressure_head.piston'"):
        steady_points([bare], robot, "piston")
