"""A Stribeck curve with a long tail is told as it is, and not as a shorter one beside levels that are off."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from mjfriction.diagnose.causes.cause import Site
from mjfriction.diagnose.causes.stribeck import LorentzianStribeck, Stribeck, UnfinishedStribeck
from mjfriction.diagnose.diagnosis import diagnose_log
from mjfriction.diagnose.tell.outcome import Diagnosis, Verdict
from mjfriction.laws.ambient import ambient
from mjfriction.laws.catalog import find_law
from mjfriction.record.readers import read_log
from mjfriction.robot.files import read_robot
from tests.hidden.machine import Instant, Machine, write_case

EXCESS, VELOCITY = 18.0, 0.12


def falling(i: Instant) -> np.ndarray:
    return np.asarray(EXCESS * np.sign(i.v) / (1.0 + np.square(i.v / VELOCITY)))


def curve_of(found: Diagnosis) -> dict[str, float]:
    curve = next(finding for finding in found.findings if finding.cause == "friction.stribeck")
    return {parameter.name.removeprefix("stribeck_"): parameter.value for parameter in curve.parameters}


def test_it_is_one_curve(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    log, robot = write_case(tmp_path, Machine(hidden={2: falling}, noise=0.05), seed=21, seconds=40.0)
    found = diagnose_log(read_log(log), read_robot(robot))
    fitted = curve_of(found)
    (finding,) = found.findings
    assert (finding.cause, finding.joint, found.verdict) == ("friction.stribeck", "elbow_joint", Verdict.EXPLAINED)
    assert fitted == pytest.approx({"excess": EXCESS, "velocity": VELOCITY, "exponent": 2.0}, rel=0.05)
    assert [term.law for term in found.robot.joint("elbow_joint").friction or ()][-1] == "lorentzian"
    again = diagnose_log(read_log(log), found.robot)
    assert (again.verdict, again.findings) == (Verdict.CONSISTENT, ())
    monkeypatch.setattr(LorentzianStribeck, "sites", lambda *_: [])
    without = diagnose_log(read_log(log), read_robot(robot))
    assert curve_of(without)["exponent"] < 1.5
    left = [one.joints[2].rms_heldout_after for one in (found, without)]
    assert left[0] < left[1]


@pytest.mark.parametrize("cause", [Stribeck(), UnfinishedStribeck(), LorentzianStribeck()])
@pytest.mark.parametrize("exponent", [1.0, 2.0])
def test_a_twentieth_is_left_where_it_is_said_to_have_faded(cause: Stribeck, exponent: float) -> None:
    site = Site(0, (0.3, exponent))
    assert cause.left_at(np.array([cause.faded_at(site)]), site)[0] == pytest.approx(0.05, rel=0.01)


@pytest.mark.parametrize("cause", [Stribeck(), LorentzianStribeck()])
@pytest.mark.parametrize("exponent", [0.8, 2.0])
def test_the_curve_is_that_of_the_law_that_the_robot_file_gets(cause: Stribeck, exponent: float) -> None:
    robot = cause.extend(read_robot("ur5"), Site(2, (0.3, exponent)), np.array([1.0]))
    term = (robot.joint("elbow_joint").friction or ())[-1]
    speed = np.linspace(0.01, 3.0, 40)
    law = find_law(term.law)
    torque = law.along(speed, ambient(speed.size), law.pack(term.parameters))
    np.testing.assert_allclose(torque, cause.left_at(speed, Site(2, (0.3, exponent))), rtol=1e-9, atol=1e-15)
