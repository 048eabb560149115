"""A search for a shape that begins at a limit of its range finds what lies close to that limit."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from mjfriction.diagnose.causes.cause import Site
from mjfriction.diagnose.causes.waves import Cogging
from mjfriction.diagnose.fit.model import Chosen, build_model
from mjfriction.diagnose.fit.nuisance import make_nuisance
from mjfriction.diagnose.fit.shapes import best_shape
from mjfriction.identify.measure import measure_gap
from mjfriction.record.readers import read_log
from mjfriction.robot.files import read_robot
from tests.hidden.machine import UR5_COULOMB, Machine, write_case

ELBOW = 2


@pytest.mark.parametrize("beyond", [1.0, 1.03, 1.06])
def test_a_wave_that_is_hardly_shorter_than_the_longest_one(beyond: float, tmp_path: Path) -> None:
    log, robot = write_case(tmp_path, Machine(), seed=5, seconds=30.0)
    gap = measure_gap(read_log(log), read_robot(robot))
    ((longest, _),) = Cogging().shape_bounds(gap, Site(ELBOW))
    true = beyond * longest
    hidden = write_case(
        tmp_path,
        Machine(hidden={ELBOW: lambda at: 2.0 * UR5_COULOMB[ELBOW] * np.sin(true * at.q)}),
        seed=5,
        seconds=30.0,
    )
    gap = measure_gap(read_log(hidden[0]), read_robot(hidden[1]))
    model = build_model(gap, make_nuisance(gap), ())
    found = best_shape(model, Chosen(Cogging(), Site(ELBOW, (longest,))))
    assert found.site.shape[0] == pytest.approx(true, rel=0.005)
