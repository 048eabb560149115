"""Friction that grows with the load, whether that is what the links need or what the rotor takes too."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pyarrow as pa
import pytest

from mjfriction.diagnose.causes.cause import JointCause, Site
from mjfriction.diagnose.causes.load import DriveLoad, GearedLoad, Load
from mjfriction.diagnose.diagnosis import diagnose_log
from mjfriction.identify.measure import measure_gap
from mjfriction.plant.machine import simulate
from mjfriction.plant.motions import excitation
from mjfriction.plant.sensors import Recorder
from mjfriction.record.readers import read_log
from mjfriction.record.readers.table import log_from_table
from mjfriction.robot.files import read_robot, write_robot
from mjfriction.robot.friction import with_term
from mjfriction.robot.load_friction import stated_load
from mjfriction.robot.robot import Robot
from tests.deep import deep
from tests.diagnose.test_planar_arm import planar
from tests.hidden.machine import Instant, Machine, write_case

LOAD = 0.15


def geared(folder: Path) -> Robot:
    """Return the planar arm with rotors that weigh as much as its links do."""
    robot = planar(folder)
    for joint in robot.table.joint:
        inertia = {"shoulder": 6e-5, "elbow": 2e-5, "wrist": 1e-6}[joint.name]
        drive = joint.actuator.model_copy(update={"gear_ratio": 100.0, "rotor_inertia": inertia})
        robot = robot.with_joint(joint.model_copy(update={"actuator": drive}))
    return robot


@pytest.mark.parametrize("includes_rotor", [False, deep(True)])
def test_the_load_is_told_with_or_without_the_rotor_as_it_is(*, includes_rotor: bool, tmp_path: Path) -> None:
    stated = geared(tmp_path)
    values = {"coulomb": 0.0, "load": LOAD, "viscous": 0.0}
    machine = with_term(stated, "shoulder", "load_dependent", values, load_includes_rotor=includes_rotor)
    motion = excitation(stated.joints, np.zeros(3), np.full(3, 1.2), np.full(3, 3.0), 40.0, seed=5)
    columns = simulate(machine, motion, recorder=Recorder(250.0), controller_robot=stated, seed=1)
    found = diagnose_log(log_from_table(pa.table(columns), "planar"), stated)
    (finding,) = found.findings
    assert (finding.cause, finding.joint) == ("friction.load", "shoulder")
    (load,) = finding.parameters
    assert load.value == pytest.approx(LOAD, rel=0.05)
    assert ("rotor included" in finding.evidence) is includes_rotor
    added = [term for term in found.robot.joint("shoulder").friction or () if term.law == "load_dependent"]
    assert [term.load_includes_rotor for term in added] == [includes_rotor]


@pytest.mark.parametrize(("cause", "rotor"), [(Load(), False), (DriveLoad(), True)])
def test_less_load_than_is_stated_lowers_the_law_that_states_it(
    cause: Load | DriveLoad, rotor: bool, tmp_path: Path
) -> None:
    robot = planar(tmp_path)
    stated = {"coulomb": 0.2, "load": LOAD, "viscous": 0.1}
    robot = with_term(robot, "elbow", "load_dependent", stated, load_includes_rotor=rotor)
    site = Site(robot.joints.index("elbow"))
    lower = cause.extend(robot, site, np.array([-0.6 * LOAD]))
    assert stated_load(lower.joint("elbow"), includes_rotor=rotor) == pytest.approx(0.4 * LOAD)
    # A law that pushes could not be written: every command would refuse the file.
    (tmp_path / "lower").mkdir()
    assert read_robot(write_robot(lower, tmp_path / "lower")).joint("elbow").friction == lower.joint("elbow").friction
    assert all(
        term.value("load") >= 0.0 for term in lower.joint("elbow").friction or () if term.law == "load_dependent"
    )


@pytest.mark.deep
def test_the_stated_level_may_be_that_of_some_load(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    # Friction that does not know of small loads is, where it grows with them, less by a constant.
    share, known = 0.3, 10.0

    def rubs(instant: Instant) -> np.ndarray:
        return share * (np.hypot(instant.rigid, known) - known) * np.sign(instant.v)

    log, robot = write_case(tmp_path, Machine(noise=0.1, hidden={2: rubs}), seed=5)
    found = diagnose_log(read_log(log), read_robot(robot))
    assert [(one.cause, one.joint) for one in found.findings] == [("friction.load", "elbow_joint")]
    monkeypatch.setattr(Load, "level_shifts", JointCause.level_shifts)
    found = diagnose_log(read_log(log), read_robot(robot))
    assert ("friction.coulomb_viscous", "elbow_joint") in [(one.cause, one.joint) for one in found.findings]


@pytest.mark.parametrize(("cause", "strengths"), [(Load(), [0.2]), (GearedLoad(), [0.3, 0.1])])
def test_levels_are_asked_from_no_load_to_the_most_there_was(
    cause: Load | GearedLoad, strengths: list[float], tmp_path: Path
) -> None:
    log, robot = write_case(tmp_path, Machine(), seed=5, seconds=20.0)
    gap = measure_gap(read_log(log), read_robot(robot))
    level, damping = cause.level_shifts(gap, Site(2), np.array(strengths)).T
    most = 0.2 * np.max(np.abs(gap.effort.load[:, 2]))
    assert (level[0], level[-1]) == pytest.approx((0.0, most))
    assert not np.any(damping)
