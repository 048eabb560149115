"""Effects outside all causes: they push as hard as asked, and the drive gives what they take."""

from __future__ import annotations

import numpy as np
import pytest

from mjfriction.benchmark.cases import Setting, make_case
from mjfriction.benchmark.effects.outside import OUTSIDE

SETTING = Setting("linear_axis", seconds=20.0, rate=250.0, noise=0.1)


@pytest.mark.deep
@pytest.mark.parametrize("draw", OUTSIDE, ids=lambda draw: draw.__name__)
def test_it_stands_out_as_asked_in_the_log_and_in_no_other_motion(draw) -> None:
    case, clean = make_case(4, SETTING, (draw,), 3.0), make_case(4, SETTING, (), 3.0)
    (hidden,) = case.hidden
    assert hidden.outside
    assert hidden.severity == pytest.approx(3.0, rel=0.06)
    noise = case.machine.joint("axis").effort_sensor.noise
    added = case.log["effort.axis"] - clean.log["effort.axis"]  # the same noise in both
    assert 1.5 * noise < np.sqrt(np.mean(np.square(added))) < 6.0 * noise
    assert np.array_equal(case.other["effort.axis"], clean.other["effort.axis"])
    assert not any(name.startswith("push") for name in case.log)
