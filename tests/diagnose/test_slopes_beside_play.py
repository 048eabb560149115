"""Beside play, bodies are refitted by slopes of their own: landings jump as their load changes by ever so little."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pyarrow as pa
import pytest

from mjfriction.diagnose.causes.backlash import Backlash
from mjfriction.diagnose.causes.cause import Site
from mjfriction.diagnose.causes.payload import Payload
from mjfriction.diagnose.fit.model import Chosen, build_model
from mjfriction.diagnose.fit.nuisance import make_nuisance
from mjfriction.diagnose.fit.tangent import straightened
from mjfriction.identify.gap import Gap
from mjfriction.identify.measure import measure_gap
from mjfriction.plant.machine import simulate
from mjfriction.plant.motions import excitation
from mjfriction.plant.sensors import Recorder
from mjfriction.record.readers.table import log_from_table
from mjfriction.robot.files import read_robot

PLAY, LOAD = 0.006, np.array([0.5, 0.02, 0.025, 0.015])  # rad; kg and kg·m
PAN_PLAY = Chosen(Backlash(), Site(0, around=PLAY))


@pytest.fixture(scope="module")
def gap() -> Gap:
    """An arm with play at its pan joint, whose load turns about all the time, and a payload off its flange."""
    stated = read_robot("ur5")
    middle = np.array([0.0, -1.2, 1.2, -0.5, 0.5, 0.0])
    motion = excitation(stated.joints, middle, np.full(6, 0.8), np.full(6, 1.5), 30.0, seed=3)
    log = log_from_table(pa.table(simulate(stated, motion, recorder=Recorder(250.0), seed=1)), "as stated")
    gap = measure_gap(log, stated, highest=60.0)
    (load,) = Payload().sites(gap)
    machine = Payload().extend(PAN_PLAY.cause.extend(stated, PAN_PLAY.site, np.array([PLAY])), load, LOAD)
    return replace(gap, residual=gap.residual + gap.predicted(machine) - gap.predicted_as_stated)


def test_a_payload_is_found_beside_play(gap: Gap) -> None:
    (load,) = Payload().sites(gap)
    model = straightened(build_model(gap, make_nuisance(gap), (PAN_PLAY, Chosen(Payload(), load))))
    play, held = (model.strengths[place] for place in model.places)
    assert play == pytest.approx(PLAY, rel=0.01)
    assert held[0] == pytest.approx(LOAD[0], rel=0.03)
    assert np.linalg.norm(held[1:] - LOAD[1:]) < 0.03 * np.linalg.norm(LOAD[1:])
