"""A heavy joint under a coarse encoder, whose noise a link that swings would take part in no more."""

from __future__ import annotations

import numpy as np
import pyarrow as pa
import pytest

from mjfriction.benchmark.drawing import draw_case
from mjfriction.diagnose.causes import elasticity
from mjfriction.diagnose.causes.moved_link import noise_of_inertia
from mjfriction.diagnose.diagnosis import diagnose_log
from mjfriction.identify.measure import measure_gap
from mjfriction.plant.machine import simulate
from mjfriction.plant.motions import excitation
from mjfriction.plant.sensors import Recorder
from mjfriction.record.readers.table import log_from_table
from mjfriction.robot.files import read_robot

SEED = 3


@pytest.mark.parametrize("measured", [False, True])
def test_the_noise_of_position_adds_as_much_torque_as_is_said(measured: bool) -> None:
    robot = read_robot("linear_axis")
    motion = excitation(robot.joints, np.zeros(1), np.full(1, 0.15), np.full(1, 0.4), 60.0, seed=SEED)
    log = simulate(robot, motion, recorder=Recorder(250.0, velocity=measured), seed=SEED)
    noise = np.random.default_rng(SEED).standard_normal((2, log["time"].size))
    log["position.axis"] += 3e-5 * noise[0]
    if measured:
        log["velocity.axis"] += 3e-4 * noise[1]
    gap = measure_gap(log_from_table(pa.table(log), "axis"), robot)
    moving = np.abs(gap.at_rows("velocity")[:, 0]) > 0.1
    heard = np.mean(np.square(gap.residual[moving, 0])) - gap.noise_floor[0] ** 2
    # A position's noise is not white in velocity, as is taken: up to the band of the rows that is within a third.
    assert np.sqrt(heard) == pytest.approx(noise_of_inertia(gap, 0), rel=0.3)


@pytest.mark.deep
def test_what_the_noise_of_the_encoder_adds_is_no_link_that_swings(monkeypatch: pytest.MonkeyPatch) -> None:
    # The first joint of a heavy arm, with an encoder of 15 bit.
    case = draw_case(1080061).case()
    log = log_from_table(pa.table(case.log), "arm")
    swings = ("drive.elasticity", "joint_1")
    assert swings not in {(one.cause, one.joint) for one in diagnose_log(log, case.stated).findings}
    monkeypatch.setattr(elasticity, "noise_of_inertia", lambda *_: 0.0)
    assert swings in {(one.cause, one.joint) for one in diagnose_log(log, case.stated).findings}
