"""Damping that levels off otherwise than the usual curve does is one finding, and no level beside a bend."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from mjfriction.diagnose.causes.stribeck import UnfinishedStribeck
from mjfriction.diagnose.diagnosis import diagnose_log
from mjfriction.diagnose.search.field import make_field
from mjfriction.record.readers import read_log
from mjfriction.robot.files import read_robot
from tests.diagnose.in_the_file import left_by_the_file
from tests.hidden.machine import Instant, Machine, write_case

WRIST = 4
CURVES: dict[str, Callable[[np.ndarray], np.ndarray]] = {
    "hyperbolic tangent": lambda v: 6.0 * np.tanh(v / 0.3),
    "root": lambda v: 6.0 * np.sign(v) * np.sqrt(np.abs(v)),
}


@pytest.mark.deep
@pytest.mark.parametrize("curve", ["hyperbolic tangent", "root"])
def test_the_curve_is_the_only_finding(curve: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def bends(at: Instant) -> np.ndarray:
        return CURVES[curve](at.v)

    case = write_case(tmp_path, Machine(hidden={WRIST: bends}, noise=0.05), seed=4, seconds=30.0)
    log, stated = read_log(case[0]), read_robot(case[1])
    found = diagnose_log(log, stated)
    (finding,) = found.findings
    assert (finding.cause, finding.joint) == ("friction.viscous_nonlinear", "wrist_2_joint")
    assert finding.gain.reduction > 0.95
    # The robot file says the same as the fit.
    again = left_by_the_file(found, tmp_path / "extended")
    np.testing.assert_allclose(again, found.residual_after, atol=1e-4 * np.abs(found.gap.measured).max())
    # Only the usual curve levels off like this beside a level that is off.
    usual = "mjfriction.diagnose.settle.stated.in_place_of_levels"
    monkeypatch.setattr(usual, lambda gap, joint, *, bent=False: make_field(gap, (UnfinishedStribeck(),)))
    poor = diagnose_log(log, stated).findings
    assert len(poor) > 1 or poor[0].gain.reduction < 0.9 * finding.gain.reduction
