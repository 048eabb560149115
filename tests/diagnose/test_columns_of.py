"""Columns of many sites of one joint are those of each by itself."""

from __future__ import annotations

import numpy as np
import pytest

from mjfriction.diagnose.causes.cause import Cause
from mjfriction.diagnose.causes.elasticity import HardeningElasticity, SwingingElasticity
from mjfriction.diagnose.causes.springy_play import SpringyPlay
from mjfriction.identify.gap import Gap
from mjfriction.identify.measure import measure_gap, thinned
from mjfriction.record.readers import read_log
from mjfriction.robot.files import read_robot
from tests.hidden.machine import Machine, write_case

LIFT = 1


@pytest.fixture(scope="module")
def gap(tmp_path_factory: pytest.TempPathFactory) -> Gap:
    log, robot = write_case(tmp_path_factory.mktemp("case"), Machine(), seed=12, seconds=15.0, rate=250.0)
    return measure_gap(read_log(log), read_robot(robot))


@pytest.mark.parametrize("cause", [SwingingElasticity(), HardeningElasticity(), SpringyPlay()])
def test_many_at_once_are_as_each_by_itself(cause: Cause, gap: Gap) -> None:
    (first, *_) = [site for site in cause.sites(gap) if site.joint == LIFT]
    sites = [first, *cause.around_sites(gap, first)]
    alone = [cause.columns(thinned(gap), site) for site in sites]
    at_once = cause.columns_of(thinned(gap), sites)
    for own, many in zip(alone, at_once, strict=True):
        assert own.keys() == many.keys()
        for joint, columns in own.items():
            np.testing.assert_allclose(many[joint], columns, rtol=1e-9, atol=1e-12 * np.max(np.abs(columns)))
    # They differ from site to site, or the comparison would show nothing.
    assert not np.allclose(at_once[0][LIFT], at_once[1][LIFT])
