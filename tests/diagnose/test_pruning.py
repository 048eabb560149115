"""Of causes that nature does not allow together at a joint, the one that does least is dropped."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from mjfriction.diagnose.causes.catalog import STRUCTURAL
from mjfriction.diagnose.causes.cause import Site
from mjfriction.diagnose.causes.presliding import Presliding
from mjfriction.diagnose.causes.rotor_inertia import RotorInertia
from mjfriction.diagnose.fit.exact import usual_nuisance
from mjfriction.diagnose.fit.model import Chosen, build_model
from mjfriction.diagnose.fit.trial import try_out
from mjfriction.diagnose.search import compete
from mjfriction.diagnose.search.field import chances_in, make_field
from mjfriction.identify.measure import measure_gap
from mjfriction.record.readers import read_log
from mjfriction.robot.files import read_robot
from tests.hidden.machine import Instant, Machine, write_case

WRIST = 4
TRAVEL, TOO_SHORT = 1e-3, 2.5e-4  # rad, of the contact, and with which more than the level would have to build up


def heavier(at: Instant) -> np.ndarray:
    return 0.3 * at.a


def test_a_bristle_that_cannot_be_does_not_take_the_rotor_with_it(tmp_path: Path) -> None:
    machine = Machine(bristle_travel=TRAVEL, noise=0.05, velocity="clean", hidden={WRIST: heavier})
    log, robot = write_case(tmp_path, machine, seed=3, seconds=25.0, rate=500.0)
    gap = measure_gap(read_log(log), read_robot(robot))
    rotor, bristle = Chosen(RotorInertia(), Site(WRIST)), Chosen(Presliding(), Site(WRIST, (TOO_SHORT,)))
    model = build_model(gap, usual_nuisance(gap), (rotor, bristle))
    # Either one is impossible beside what the bristle makes of the joint's level.
    assert try_out(model.without(rotor), rotor) is None
    assert try_out(model.without(bristle), bristle) is None
    left = compete.pruned(model, chances_in(make_field(gap, STRUCTURAL)))
    assert left.chosen == (rotor,)
