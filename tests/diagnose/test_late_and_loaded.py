"""A drive that reports late, beside a load that was not stated: each is fitted wrong before the other is there."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from mjfriction.diagnose.diagnosis import diagnose_log
from mjfriction.diagnose.fit import shapes, tangent
from mjfriction.diagnose.fit.model import Chosen, Model
from mjfriction.identify.regression import Columns
from mjfriction.record.log import Log
from mjfriction.record.readers import read_log
from mjfriction.robot.files import read_robot
from mjfriction.robot.robot import Robot
from tests.hidden.machine import Instant, Machine, write_case

SLIDE = """<mujoco><worldbody><body name="carriage">
<joint name="axis" type="slide" axis="1 0 0" range="-2 2"/>
<geom type="box" size="0.1 0.1 0.1" mass="60"/></body></worldbody></mujoco>"""
LATE = 15  # samples, 60 ms
LOAD = 24.0  # kg


def late_and_heavy(at: Instant) -> np.ndarray:
    stated = at.rigid + at.friction
    force = stated + LOAD * at.a
    return np.concatenate([np.full(LATE, force[0]), force[:-LATE]]) - stated


def at_any_strength(model: Model, choice: Chosen, own: Columns | None = None) -> float:
    own = choice.cause.columns(model.gap, choice.site) if own is None else own
    columns = {joint: values[:, None, :] for joint, values in own.items()}
    (strengths,), (gain,) = model.system.screen(columns)
    return float(gain) if choice.cause.admissible(model.gap, choice.site, strengths) else 0.0


def told(log: Log, robot: Robot) -> dict[str, set[str]]:
    """Return what is found, with its alternatives."""
    return {one.cause: {one.cause, *one.alternatives} for one in diagnose_log(log, robot).findings}


@pytest.mark.deep
def test_a_delay_is_drawn_anew_where_a_load_beside_it_lets_it_go(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    # Before the load is found, half of the delay fits best, beside causes that stand for the load.
    model = tmp_path / "slide.xml"
    model.write_text(SLIDE)
    machine = Machine(
        model=model, joints=("axis",), coulomb=(24.0,), viscous=(180.0,), hidden={0: late_and_heavy}, noise=0.03
    )
    path, stated = write_case(tmp_path, machine, seed=3)
    log, robot = read_log(path), read_robot(stated)
    mass, delay = told(log, robot).values()
    assert delay == {"sensor.delay"}
    assert mass == {"drive.rotor_inertia", "body.link_inertia", "body.payload"}
    # Either is enough: that columns are compared at the delay that they were drawn for, or that they are drawn anew.
    monkeypatch.setattr(shapes, "_taken_off", at_any_strength)
    assert "sensor.delay" in told(log, robot)
    monkeypatch.setattr(tangent, "_moved", lambda site, _: site)
    assert "sensor.delay" not in told(log, robot)
