"""Play that a link crosses slowly: an arm held upright, whose weight hardly pulls it over."""

from __future__ import annotations

from functools import cache

import numpy as np
import pyarrow as pa
import pytest

from mjfriction.diagnose.diagnosis import diagnose_log
from mjfriction.diagnose.search import short_list
from mjfriction.diagnose.tell.outcome import Verdict
from mjfriction.plant.machine import simulate
from mjfriction.plant.motions import excitation
from mjfriction.plant.sensors import Recorder
from mjfriction.record.log import Log
from mjfriction.record.readers.table import log_from_table
from mjfriction.robot.files import read_robot
from mjfriction.robot.schema import Transmission

LIFT = "shoulder_lift_joint"
UPRIGHT = np.array([0.0, -1.57, 0.0, -1.57, 0.0, 0.0])
NOISE = 0.3  # N·m


@cache
def upright(play: float, seed: int, speed: float) -> Log:
    robot = read_robot("ur5")
    machine = robot.with_joint(robot.joint(LIFT).model_copy(update={"transmission": Transmission(backlash=play)}))
    for own in machine.table.joint:
        noisy = own.effort_sensor.model_copy(update={"noise": NOISE})
        machine = machine.with_joint(own.model_copy(update={"effort_sensor": noisy}))
    motion = excitation(robot.joints, UPRIGHT, np.full(6, 0.3 + 0.2 * speed), np.full(6, speed), 40.0, seed=seed)
    return log_from_table(pa.table(simulate(machine, motion, recorder=Recorder(250.0), seed=seed)), "upright")


@pytest.mark.deep
@pytest.mark.parametrize(
    ("play", "seed", "speed"),
    # Between two of the grid's, so that the link lands half a second earlier or later with either of them.
    [(0.0055, 1, 0.15), (0.0366, 2, 0.15), (0.0366, 1, 0.3), (0.0458, 2, 0.6), (0.0458, 1, 0.15)],
)
def test_play_is_found_though_its_landings_come_at_other_moments_for_any_play_but_it(
    play: float, seed: int, speed: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    log, robot = upright(play, seed, speed), read_robot("ur5")
    found = diagnose_log(log, robot)
    (finding,) = found.findings
    assert (finding.cause, finding.joint, found.verdict) == ("drive.backlash", LIFT, Verdict.EXPLAINED)
    assert finding.parameters[0].value == pytest.approx(play, rel=0.02)
    if play > 0.04 and speed < 0.3:
        monkeypatch.setattr(short_list, "PROMISED", np.inf)
        assert not diagnose_log(log, robot).findings
