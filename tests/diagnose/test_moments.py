"""The moment of an event is known as far as the rows around it tell."""

from __future__ import annotations

import numpy as np
import pytest

from mjfriction.diagnose.diagnosis import diagnose_log
from mjfriction.robot.friction_tables import Event
from tests.deep import deep
from tests.diagnose.test_carried_payload import arm, recorded

JOINT = "elbow_joint"


@pytest.mark.parametrize("seed", [14, *(deep(seed) for seed in (1, 5, 8, 10, 12))])
def test_the_interval_of_a_moment_holds_it(seed: int) -> None:
    """Rows that fit neither side of a step are left out: anywhere among them, a moment fits as well."""
    random = np.random.default_rng(seed)
    moment, step = random.uniform(6.0, 18.0), random.uniform(2.0, 5.0)
    stated = arm()
    table = stated.joint(JOINT).model_copy(update={"events": (Event(time=moment, coulomb=step),)})
    (finding,) = diagnose_log(recorded(stated.with_joint(table), seed), stated).findings
    (told,) = (parameter for parameter in finding.parameters if parameter.name == "time")
    assert told.low <= moment <= told.high
    assert told.high - told.low < 0.5
