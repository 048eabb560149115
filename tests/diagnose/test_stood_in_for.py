"""Causes for which links and drives that are refitted along could stand in: what those would have to be off decides."""

from __future__ import annotations

from collections.abc import Callable

import mujoco
import numpy as np
import pytest

from mjfriction.diagnose.diagnosis import diagnose_log
from mjfriction.diagnose.fit.trial import Trial
from mjfriction.diagnose.tell import untold
from mjfriction.record.readers import read_log
from mjfriction.robot.files import read_robot
from tests.diagnose.test_planar_arm import JOINT, LINK
from tests.hidden.machine import Machine, write_case

TWO_LINKS = (
    '<robot name="planar"><link name="base"/>'
    + LINK.format(name="upper", mass=5.0, centre=-0.1, inertia=0.05)
    + LINK.format(name="fore", mass=1.8, centre=-0.06, inertia=0.01)
    + JOINT.format(name="shoulder", parent="base", child="upper", z=0.0)
    + JOINT.format(name="elbow", parent="upper", child="fore", z=-0.25)
    + "</robot>"
)
Told = Callable[[], list[tuple[str, str | None]]]

FACTOR = 1.12  # of the torque constant at the elbow; at the shoulder it is a few percent off, as all the rest is
UPPER, FORE = 0.97, 0.96  # of the stated links' masses


def lighter(model: mujoco.MjModel) -> None:
    for body, share in zip((model.nbody - 2, model.nbody - 1), (UPPER, FORE), strict=True):
        model.body_mass[body] *= share
        model.body_inertia[body] *= share


@pytest.fixture(scope="module")
def told(tmp_path_factory: pytest.TempPathFactory) -> Told:
    folder = tmp_path_factory.mktemp("two_links")
    model = folder / "two_links.urdf"
    model.write_text(TWO_LINKS)
    machine = Machine(
        model=model,
        joints=("shoulder", "elbow"),
        coulomb=(0.55, 0.055),
        viscous=(0.4, 0.018),
        hidden={
            0: lambda at: -0.03 * (at.rigid + at.friction),
            1: lambda at: (FACTOR - 1.0) * (at.rigid + at.friction),
        },
        noise=0.02,
        change=lighter,
    )
    log, robot = write_case(folder, machine, seed=5, off=0.03)
    return lambda: [(one.cause, one.joint) for one in diagnose_log(read_log(log), read_robot(robot)).findings]


@pytest.mark.deep
def test_what_a_cause_spares_the_other_joints_counts(told: Told, monkeypatch: pytest.MonkeyPatch) -> None:
    # Links that are refitted to make up for the elbow's efforts are wrong at the shoulder.
    assert told() == [("drive.torque_constant", "elbow")]
    monkeypatch.setattr(Trial, "gain", property(lambda self: float(np.sum(self.improvement)) + self.relief))
    assert ("drive.torque_constant", "elbow") not in told()


@pytest.mark.deep
def test_a_cause_is_told_where_the_rest_would_be_off_as_it_hardly_ever_is(
    told: Told, monkeypatch: pytest.MonkeyPatch
) -> None:
    # However little it takes off what is left: links and the other drive could make up for nearly all of it.
    monkeypatch.setattr(untold, "shows", lambda *_, **__: False)
    assert told() == [("drive.torque_constant", "elbow")]
    monkeypatch.setattr(untold, "STRAINED", np.inf)
    assert told() == []
