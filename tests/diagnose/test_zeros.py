"""What efforts read where there is none is refitted along where it is less than a machine's unevenness."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from mjfriction.diagnose.diagnosis import diagnose_log
from mjfriction.diagnose.fit import nuisance
from mjfriction.diagnose.fit.model import build_model
from mjfriction.diagnose.fit.nuisance import make_nuisance
from mjfriction.diagnose.fit.refitted import OUT_OF_CHANCE, ZERO
from mjfriction.diagnose.search.unevenness import with_unevenness
from mjfriction.diagnose.tell.outcome import Diagnosis
from mjfriction.identify.measure import measure_gap
from mjfriction.record.readers import read_log
from mjfriction.robot.files import read_robot
from tests.hidden.machine import UR5_COULOMB, Array, Instant, Machine, write_case

LIFT = 1
ZEROS = np.array([0.025, -0.025, 0.025, 0.025, -0.025, 0.025]) * UR5_COULOMB
OFF = 0.02  # rad


def uneven(joint: int) -> Callable[[Instant], Array]:
    """Return waves and a constant of a few percent of a joint's friction, as any real machine has."""
    return lambda at: ZEROS[joint] + 0.02 * UR5_COULOMB[joint] * np.sin(25.0 * at.q + joint)


def diagnosed(folder: Path, seconds: float = 40.0) -> Diagnosis:
    machine = Machine(
        hidden={joint: uneven(joint) for joint in range(6)}, sensed={LIFT: lambda at: OFF + 0.0 * at.q}, noise=0.1
    )
    log, robot = write_case(folder, machine, seed=5, seconds=seconds)
    return diagnose_log(read_log(log), read_robot(robot))


@pytest.mark.deep
def test_small_zeros_bend_no_cause(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    diagnosis = diagnosed(tmp_path)
    (finding,) = diagnosis.findings
    assert (finding.cause, finding.joint) == ("sensor.encoder_offset", "shoulder_lift_joint")
    (told,) = finding.parameters
    assert told.low < OFF < told.high
    moved = {one.joint: one.fitted for one in diagnosis.adjustments if one.what == "offset"}
    assert list(moved.values()) == pytest.approx(ZEROS, rel=0.4)
    sensors = [joint.effort_sensor.offset for joint in diagnosis.robot.table.joint]
    assert sensors == pytest.approx(ZEROS, rel=0.4)

    monkeypatch.setattr(nuisance, "zeros_of", lambda _: ())
    (bent,) = diagnosed(tmp_path).findings[0].parameters
    assert abs(bent.value - OFF) > 10.0 * abs(told.value - OFF)
    assert bent.high - bent.low > 2.0 * (told.high - told.low)


@pytest.mark.parametrize("waves", [0.02, 0.0])
def test_they_reach_as_far_as_what_is_no_offset_yet(tmp_path: Path, waves: float) -> None:
    # On a machine that is even an offset is told that would be nothing on others: that none is to hide.
    def hidden(joint: int) -> Callable[[Instant], Array]:
        offset = 0.2 if joint == LIFT else 0.0
        return lambda at: UR5_COULOMB[joint] * (offset + waves * np.sin(25.0 * at.q + joint))

    log, robot = write_case(tmp_path, Machine(hidden={j: hidden(j) for j in range(6)}, noise=0.05), seed=5)
    gap = measure_gap(read_log(log), read_robot(robot), highest=60.0)
    known = with_unevenness(gap, make_nuisance(gap))
    found = build_model(gap, known, ()).strengths[known.of_zeros][LIFT] / UR5_COULOMB[LIFT]
    assert (known.uneven > 0.8) is (waves > 0.0)
    assert 0.2 * ZERO * known.uneven < found < 1.06 * OUT_OF_CHANCE * ZERO * known.uneven
