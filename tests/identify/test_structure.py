"""Structure of a residual along a covariate."""

from __future__ import annotations

from importlib.resources import files
from pathlib import Path

import numpy as np
import pytest

from mjfriction.identify.gap import Gap
from mjfriction.identify.measure import measure_gap
from mjfriction.identify.structure import curve_share
from mjfriction.record.readers import read_log
from mjfriction.robot.files import read_robot


@pytest.fixture(scope="module")
def gap() -> Gap:
    return measure_gap(read_log(Path(str(files("mjfriction"))) / "bundled/demo/log.parquet"), read_robot("ur5"))


def test_a_smooth_curve_is_structure_and_noise_is_none(gap: Gap) -> None:
    rows, joints = gap.residual.shape
    along = np.random.default_rng(6).uniform(-1.0, 1.0, rows)
    noise = np.random.default_rng(7).normal(size=(rows, joints))
    curve = noise.copy()
    curve[:, 1] += 3.0 * np.sin(3.0 * along)
    variance = np.var(3.0 * np.sin(3.0 * along))
    assert curve_share(gap, 1, along, curve) == pytest.approx(variance / (variance + 1.0), abs=0.05)
    assert abs(curve_share(gap, 1, along, noise)) < 0.02


def test_a_covariate_may_die_away_to_the_last_digit(gap: Gap) -> None:
    # The velocity of an encoder that rests, through a filter: most of its quantiles are denormal numbers.
    along = np.geomspace(1.0, 1e-320, gap.residual.shape[0])
    share = curve_share(gap, 1, along, np.random.default_rng(7).normal(size=gap.residual.shape))
    assert abs(share) < 0.02
