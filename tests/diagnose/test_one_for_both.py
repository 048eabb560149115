"""A slide that carries a quarter of its stated mass: not a drive half as strong beside twice the friction."""

from __future__ import annotations

import numpy as np
import pyarrow as pa
import pytest

from mjfriction.diagnose.causes.catalog import STRUCTURAL
from mjfriction.diagnose.causes.cause import Site
from mjfriction.diagnose.causes.torque_constant import TorqueConstant
from mjfriction.diagnose.fit.exact import level_changes
from mjfriction.diagnose.fit.model import Chosen, Model, build_model
from mjfriction.diagnose.fit.nuisance import make_nuisance
from mjfriction.diagnose.search.field import Field, make_field
from mjfriction.diagnose.settle import levels_kept, stated
from mjfriction.diagnose.settle.levels_kept import one_for_both
from mjfriction.diagnose.settle.stated import settle
from mjfriction.identify.measure import measure_gap
from mjfriction.plant.machine import simulate
from mjfriction.plant.motions import excitation
from mjfriction.plant.sensors import Recorder
from mjfriction.record.readers.table import log_from_table
from mjfriction.robot.files import read_robot
from mjfriction.robot.friction import raised_levels
from mjfriction.robot.links import scaled_link
from mjfriction.robot.robot import Robot
from mjfriction.robot.schema import EffortSensor

STATED = read_robot("linear_axis")
SCALE = 0.27


def model_of(machine: Robot) -> tuple[Model, Field]:
    """Levels that are free, and a torque constant that was found beside them."""
    joint = machine.joint("axis")
    sensor = joint.effort_sensor.model_copy(update={"noise": 2.5})
    machine = machine.with_joint(joint.model_copy(update={"effort_sensor": sensor}))
    motion = excitation(("axis",), np.zeros(1), np.full(1, 0.15), np.full(1, 0.4), 40.0, seed=2)
    log = log_from_table(pa.table(simulate(machine, motion, recorder=Recorder(250.0), seed=1)), "slide")
    gap = measure_gap(log, STATED)
    constant = Chosen(TorqueConstant(), Site(0))
    return build_model(gap, make_nuisance(gap, drives=True), (constant,)), make_field(gap, STRUCTURAL)


@pytest.mark.deep
def test_a_link_that_is_off_stands_for_a_constant_and_for_levels() -> None:
    model, field = model_of(scaled_link(STATED, "axis", SCALE))
    # A drive half as strong beside friction twice as large does as well.
    assert abs(model.strengths[model.places[0]][0]) > 0.3
    assert level_changes(model)[0] > 0.3
    one = one_for_both(model, 0, field)
    assert one is not None
    (choice,) = one.chosen
    assert choice.cause.name == "body.link_inertia"
    assert one.strengths[one.places[0]][0] == pytest.approx(SCALE - 1.0, abs=0.03)
    assert one.nuisance.levels == ()
    left = [own.gap.rms(own.heldout_residual()[:, 0], 0) for own in (one, model)]
    assert left[0] < 1.02 * left[1]


@pytest.mark.deep
def test_it_has_to_leave_as_little_everywhere(monkeypatch: pytest.MonkeyPatch) -> None:
    model, field = model_of(scaled_link(STATED, "axis", SCALE))
    # As good at the joint itself, and worse at another.
    monkeypatch.setattr(levels_kept, "leaves_as_little", lambda _model, _than, joints=None: joints is not None)
    assert one_for_both(model, 0, field) is None


@pytest.mark.deep
def test_so_it_is_settled(monkeypatch: pytest.MonkeyPatch) -> None:
    model, field = model_of(scaled_link(STATED, "axis", SCALE))
    monkeypatch.setattr(stated, "_simpler", lambda *_: None)  # nothing stands for the levels alone
    monkeypatch.setattr(stated, "one_number", lambda model: model)  # which on a lone axis says the same
    settled = settle(model, field)
    assert [choice.cause.name for choice in (*settled.model.chosen, *settled.levels)] == ["body.link_inertia"]
    monkeypatch.setattr(stated, "one_for_both", lambda *_: None)
    assert len(settle(model, field).levels) == 1


@pytest.mark.deep
def test_nothing_stands_for_a_constant_and_levels_that_are_both_off() -> None:
    machine = raised_levels(STATED, "axis", 20.0, 60.0)
    sensor = EffortSensor(scale=0.6)
    machine = machine.with_joint(machine.joint("axis").model_copy(update={"effort_sensor": sensor}))
    model, field = model_of(machine)
    assert one_for_both(model, 0, field) is None
