"""Beside play a rotor a few percent off is no finding: accelerations in between are a matter of how play is drawn."""

from __future__ import annotations

import numpy as np
import pyarrow as pa
import pytest

from mjfriction.diagnose.causes.backlash import Backlash
from mjfriction.diagnose.causes.rotor_inertia import RotorInertia
from mjfriction.diagnose.fit.model import Chosen, build_model
from mjfriction.diagnose.fit.nuisance import make_nuisance
from mjfriction.diagnose.settle.stated import Settled
from mjfriction.diagnose.tell.untold import find_untold
from mjfriction.identify.gap import Gap
from mjfriction.identify.measure import measure_gap
from mjfriction.plant.machine import simulate
from mjfriction.plant.motions import excitation
from mjfriction.plant.sensors import Recorder
from mjfriction.record.readers.table import log_from_table
from mjfriction.robot.files import read_robot
from mjfriction.robot.friction_tables import FrictionTerm

WRIST = 3


@pytest.fixture(scope="module")
def gap() -> Gap:
    stated = read_robot("ur5")
    wrist = stated.table.joint[WRIST]
    light = FrictionTerm(law="coulomb_viscous", parameters={"coulomb": 0.1, "viscous": 0.1})
    wrist = wrist.model_copy(update={"friction": (light,)})
    stated = stated.with_joint(wrist)
    actuator = wrist.actuator.model_copy(update={"rotor_inertia": 1.06 * wrist.actuator.rotor_inertia})
    machine = stated.with_joint(wrist.model_copy(update={"actuator": actuator}))
    middle = np.array([0.0, -1.2, 1.2, -0.5, 0.5, 0.0])
    motion = excitation(stated.joints, middle, np.full(6, 0.8), np.full(6, 1.5), 30.0, seed=3)
    log = log_from_table(pa.table(simulate(machine, motion, recorder=Recorder(250.0), seed=1)), "heavier rotor")
    return measure_gap(log, stated, highest=60.0)


@pytest.mark.parametrize("play", [False, True])
def test_a_rotor_six_percent_off_is_told_where_nothing_gives(play: bool, gap: Gap) -> None:
    cause = Backlash()
    rotor = Chosen(RotorInertia(), next(site for site in RotorInertia().sites(gap) if site.joint == WRIST))
    beside = [Chosen(cause, site) for site in cause.sites(gap) if site.joint == WRIST][:1] if play else []
    model = build_model(gap, make_nuisance(gap), (rotor, *beside))
    untold = find_untold(Settled(model, (), exact=True), (), (), model.heldout_residual())
    assert (rotor.key in untold.keys) is play
