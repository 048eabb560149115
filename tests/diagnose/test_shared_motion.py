"""What another joint's motion brings: its acceleration too, as a rotor does that turns along."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from mjfriction.diagnose import diagnosis
from mjfriction.diagnose.causes.cause import Site
from mjfriction.diagnose.causes.coupling import SharedEffort, SharedFriction, SharedMotion
from mjfriction.diagnose.diagnosis import diagnose_log
from mjfriction.diagnose.tell.outcome import Verdict
from mjfriction.identify.measure import measure_gap
from mjfriction.record.readers import read_log
from mjfriction.robot.files import read_robot
from tests.hidden.machine import UR5_JOINTS, Instant, Machine, write_case

ELBOW, WRIST = 2, 3
VISCOUS, INERTIA = -0.9, -0.35


def brought(at: Instant, viscous: float = VISCOUS) -> np.ndarray:
    return viscous * at.velocities[:, WRIST] + INERTIA * np.gradient(at.velocities[:, WRIST], at.time)


@pytest.mark.deep
@pytest.mark.parametrize(("viscous", "seed"), [(VISCOUS, 4), (0.0, 4), (0.0, 5), (0.0, 6)])
def test_a_rotor_that_turns_with_another_joint_is_told_with_it(viscous: float, seed: int, tmp_path: Path) -> None:
    # Without friction that enters as well, what little is found of it may go either way.
    machine = Machine(hidden={ELBOW: lambda at: brought(at, viscous)})
    log, robot = write_case(tmp_path, machine, seed=seed)
    (finding,) = diagnose_log(read_log(log), read_robot(robot)).findings
    assert (finding.cause, finding.joint) == ("drive.coupling", UR5_JOINTS[ELBOW])
    told = {value.name: value.value for value in finding.parameters}
    assert told["inertia"] == pytest.approx(INERTIA, rel=0.05)
    assert told["viscous"] == pytest.approx(viscous, abs=-0.1 * VISCOUS)


@pytest.mark.parametrize(
    ("coulomb", "viscous", "may_be"),
    [
        (1.0, 0.5, True),
        (-1.0, -0.5, True),
        (0.02, -0.5, True),
        (1.0, -0.2, True),
        (0.6, -1.0, False),
        (-0.6, 1.0, False),
    ],
)
def test_friction_that_enters_goes_one_way(coulomb: float, viscous: float, may_be: bool, tmp_path: Path) -> None:
    log, robot = write_case(tmp_path, Machine(), seed=4, seconds=15.0)
    gap = measure_gap(read_log(log), read_robot(robot))
    fast = float(np.quantile(np.abs(gap.motion.velocity[:, WRIST]), 0.9))
    strengths = np.array([coulomb, viscous / fast])
    assert SharedFriction().admissible(gap, Site(ELBOW, other=WRIST), strengths) is may_be


@pytest.mark.deep
def test_no_coupling_without_an_acceleration_does_as_well(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    log, robot = write_case(tmp_path, Machine(hidden={ELBOW: brought}), seed=4)
    others = tuple(cause for cause in diagnosis.STRUCTURAL if not isinstance(cause, SharedMotion))
    monkeypatch.setattr(diagnosis, "STRUCTURAL", others)
    assert diagnose_log(read_log(log), read_robot(robot)).verdict is Verdict.UNEXPLAINED


@pytest.mark.parametrize(
    ("sliding", "units"),
    [
        ((False, False), ["N·m", "N·m·s/rad", "N·m·s²/rad", "1"]),
        ((True, False), ["N", "N·s/rad", "N·s²/rad", "N/(N·m)"]),
        ((False, True), ["N·m", "N·m·s/m", "N·m·s²/m", "N·m/N"]),
    ],
)
def test_units_between_a_slide_and_a_turning_joint_are_of_both(sliding: tuple[bool, bool], units: list[str]) -> None:
    gap: Any = SimpleNamespace(body=SimpleNamespace(sliding=sliding))
    site = Site(0, other=1)
    quantities = (*SharedMotion().quantities(gap, site), *SharedEffort().quantities(gap, site))
    assert [own.parameter.unit_for(sliding=sliding[0]) for own in quantities] == units
