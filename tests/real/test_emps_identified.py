"""The prismatic axis EMPS identified from one run, and simulated open loop on the other."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from mjfriction.identify.identification import identify_log
from mjfriction.record.readers import read_log
from mjfriction.robot.files import read_robot
from scripts.real_runs.emps import force_error, open_loop_error


def test_the_published_four_parameters_are_found(data: Path) -> None:
    stated = read_robot(data / "emps/robot.toml")
    found = identify_log(read_log(data / "emps/estimation.parquet"), stated, law="coulomb_viscous")
    (law,) = found.laws
    values = {fitted.name: fitted.value for fitted in law.parameters}
    assert values["coulomb"] == pytest.approx(20.3935, rel=0.05)
    assert values["viscous"] == pytest.approx(203.5034, rel=0.05)
    assert found.robot.table.link_inertia["axis"].mass == pytest.approx(95.1089, rel=0.01)
    (mass, _) = found.background  # a slide shows a mass, and its effort's zero
    assert mass.name == "mass.axis"
    assert mass.value == pytest.approx(95.1089, rel=0.01)
    assert found.robot.joint("axis").effort_sensor.offset == pytest.approx(-3.1648, rel=0.1)
    assert not law.trusted  # the directions differ, which no symmetric law can say


def test_the_law_of_two_directions_is_chosen(data: Path) -> None:
    found = identify_log(read_log(data / "emps/estimation.parquet"), read_robot(data / "emps/robot.toml"))
    (law,) = found.laws
    assert law.fit.law.name == "asymmetric"
    values = {fitted.name: fitted.value for fitted in law.parameters}
    # Published: 166.7 and 240.4 N·s/m.
    assert values["viscous_positive"] == pytest.approx(166.7, rel=0.05)
    assert values["viscous_negative"] == pytest.approx(240.4, rel=0.05)


def test_open_loop_position_on_the_other_run(data: Path) -> None:
    stated = read_robot(data / "emps/robot.toml")
    estimation, pulses = (read_log(data / f"emps/{run}.parquet") for run in ("estimation", "pulses"))
    found = identify_log(estimation, stated, law="asymmetric", simulated=np.inf)
    assert open_loop_error(found.robot, pulses) < 5.17e-3


@pytest.mark.parametrize(
    ("law", "published"),
    [("coulomb_viscous", (4.083, 5.982)), ("asymmetric", (3.112, 5.34))],
    ids=["four", "directions"],
)
def test_force_errors_are_those_published_for_the_law(law: str, published: tuple[float, float], data: Path) -> None:
    runs = [read_log(data / f"emps/{run}.parquet") for run in ("estimation", "pulses")]
    found = identify_log(runs[0], read_robot(data / "emps/robot.toml"), law=law)
    assert [force_error(run, found.robot) for run in runs] == pytest.approx(published, abs=0.3)
