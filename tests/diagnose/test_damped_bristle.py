"""A bristle whose deflection is damped, as LuGre's is: stiffness and damping are told apart."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from mjfriction.diagnose import diagnosis
from mjfriction.diagnose.causes.cause import Site
from mjfriction.diagnose.causes.presliding import SLIPS, DampedPresliding, Presliding, SlippingElements
from mjfriction.diagnose.diagnosis import diagnose_log
from mjfriction.record.readers import read_log
from mjfriction.robot.files import read_robot
from tests.hidden.machine import UR5_COULOMB, UR5_JOINTS, Instant, Machine, bristle, write_case

PAN, TRAVEL, DAMPING = 0, 0.02, 20.0


def damped(at: Instant) -> np.ndarray:
    built = bristle(at.q, TRAVEL)
    along = np.sign(at.v)
    return UR5_COULOMB[PAN] * (built - along) + DAMPING * at.v * (1.0 - built * along)


def found(folder: Path) -> dict[str, float]:
    log, robot = write_case(folder, Machine(hidden={PAN: damped}), seed=4)
    diagnosed = diagnose_log(read_log(log), read_robot(robot))
    (finding,) = diagnosed.findings
    assert (finding.cause, finding.joint) == ("friction.presliding", UR5_JOINTS[PAN])
    (law,) = [term.law for term in diagnosed.robot.joint(UR5_JOINTS[PAN]).friction or () if "bristle" in str(term)]
    return {value.name: value.value for value in finding.parameters} | {law: 1.0}


@pytest.mark.deep
def test_stiffness_and_damping_are_told_apart(tmp_path: Path) -> None:
    told = found(tmp_path)
    assert told["presliding_travel"] == pytest.approx(TRAVEL, rel=0.05)
    assert told["bristle_damping"] == pytest.approx(DAMPING, rel=0.05)
    assert "lugre" in told


@pytest.mark.parametrize("cause", [Presliding(), DampedPresliding(), SlippingElements()])
def test_where_no_level_is_stated_none_builds_up(cause: Presliding | DampedPresliding | SlippingElements) -> None:
    # A robot that states no friction has its levels refitted along; they are not built in yet when what bends is drawn.
    read = read_robot("linear_axis")
    stated = read.with_stated_friction(read.body())
    bare = stated.with_joint(stated.table.joint[0].model_copy(update={"friction": ()}))
    strengths = np.full(len(SLIPS), 2.0)
    assert cause.extend(bare, Site(0, (0.01,)), strengths) == bare
    assert cause.extend(stated, Site(0, (0.01,)), strengths) != stated


@pytest.mark.deep
def test_without_damping_the_travel_is_taken_for_shorter(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    others = tuple(cause for cause in diagnosis.STRUCTURAL if not isinstance(cause, DampedPresliding))
    monkeypatch.setattr(diagnosis, "STRUCTURAL", others)
    plain = found(tmp_path)
    assert "dahl" in plain
    assert plain["presliding_travel"] < 0.7 * TRAVEL
