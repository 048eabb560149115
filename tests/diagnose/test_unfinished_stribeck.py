"""A Stribeck curve so wide that no motion sees its end: it is named, rather than levels and a bend."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pyarrow as pa
import pytest

from mjfriction.benchmark.drawing import draw_case
from mjfriction.diagnose.diagnosis import diagnose_log
from mjfriction.diagnose.settle import stated
from mjfriction.diagnose.tell import alike
from mjfriction.diagnose.tell.outcome import Finding
from mjfriction.record.readers import read_log
from mjfriction.record.readers.table import log_from_table
from mjfriction.robot.files import read_robot
from tests.hidden.machine import UR5_JOINTS, UR5_VISCOUS, Effect, Machine, write_case

WRIST = 5
EXCESS, VELOCITY = 3.0, 1.5  # N·m; rad/s, of a joint that turns at 2.2 at most


def found(folder: Path, hidden: Effect) -> Finding:
    log, robot = write_case(folder, Machine(noise=0.1, hidden={WRIST: hidden}), seed=6, seconds=25.0, rate=120.0)
    (finding,) = diagnose_log(read_log(log), read_robot(robot)).findings
    assert finding.joint == UR5_JOINTS[WRIST]
    return finding


@pytest.mark.deep
def test_it_is_neither_levels_that_are_off_nor_a_bend(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def fading(course: object) -> np.ndarray:
        return np.asarray(EXCESS * np.exp(-np.abs(course.v) / VELOCITY) * np.sign(course.v))  # type: ignore[attr-defined]

    finding = found(tmp_path / "wide", fading)
    fitted = {parameter.name: parameter for parameter in finding.parameters}
    assert finding.cause == "friction.stribeck"
    assert fitted["stribeck_excess"].value == pytest.approx(EXCESS, rel=0.15)
    for module in (stated, alike):
        monkeypatch.setattr(module, "in_place_of_levels", lambda *_, **__: ())
    assert found(tmp_path / "unasked", fading).cause == "friction.viscous_nonlinear"


@pytest.mark.deep
def test_levels_that_are_off_are_no_wide_curve(tmp_path: Path) -> None:
    def off(course: object) -> np.ndarray:
        v = course.v  # type: ignore[attr-defined]
        return np.asarray(0.8 * np.sign(v) - 0.4 * UR5_VISCOUS[WRIST] * v)

    assert found(tmp_path / "off", off).cause == "friction.coulomb_viscous"


@pytest.mark.deep
def test_one_that_ends_late_is_no_bend() -> None:
    """By three quarters of the top speed all but a twentieth has faded: a bend leaves clearly more."""
    case = draw_case(980038).case()
    (finding,) = diagnose_log(log_from_table(pa.table(case.log), "case"), case.stated).findings
    assert [(finding.cause, finding.joint)] == [(hidden.cause, hidden.joint) for hidden in case.hidden]
    assert finding.cause == "friction.stribeck"
