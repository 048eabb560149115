"""A gap on fewer samples is the same gap: its rows need no more than show the motion."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from mjfriction.identify.gap import Gap
from mjfriction.identify.measure import measure_gap, thinned
from mjfriction.record.readers import read_log
from mjfriction.robot.files import read_robot
from tests.hidden.machine import Machine, write_case

HIGHEST = 25.0  # Hz


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> Gap:
    log, robot = write_case(tmp_path_factory.mktemp("log"), Machine(), seed=2, seconds=20.0, rate=1000.0)
    return measure_gap(read_log(log), read_robot(robot), highest=HIGHEST)


def test_residual_noise_and_doubt_are_those_of_all_samples(whole: Gap) -> None:
    thin = thinned(whole)
    assert thin.motion.time.size < whole.motion.time.size / 8
    np.testing.assert_allclose(thin.noise_floor, whole.noise_floor, rtol=0.05)
    for joint in whole.examined:
        assert thin.rms(thin.residual[:, joint], joint) == pytest.approx(
            whole.rms(whole.residual[:, joint], joint), rel=0.05
        )
        assert np.mean(thin.clear[:, joint]) == pytest.approx(np.mean(whole.clear[:, joint]), abs=0.03)


def test_friction_turns_over_at_the_same_instants(whole: Gap) -> None:
    """What a step of the Coulomb level would be in the rows, beside the same of all samples at these rows' times."""
    thin = thinned(whole)
    for joint in whole.examined:
        smooth = np.convolve(whole.forward(joint), whole.chain.taps, mode="same")
        expected = np.interp(thin.chain.time, whole.motion.time, smooth)
        column = thin.reported(joint, thin.forward(joint)[:, None])[:, 0]
        assert np.sqrt(np.mean(np.square(column - expected))) < 0.02
        np.testing.assert_allclose(column, expected, atol=0.15)


def test_a_log_of_few_samples_stays_as_it_is(whole: Gap, tmp_path: Path) -> None:
    log, robot = write_case(tmp_path, Machine(), seed=2, seconds=10.0, rate=100.0)
    gap = measure_gap(read_log(log), read_robot(robot), highest=HIGHEST)
    assert thinned(gap) is gap
