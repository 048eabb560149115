"""Friction that is higher at one place of the stroke is told with the place and its width."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from mjfriction.diagnose import diagnosis
from mjfriction.diagnose.causes.cause import Site
from mjfriction.diagnose.causes.friction_spot import FrictionSpot
from mjfriction.diagnose.diagnosis import diagnose_log
from mjfriction.diagnose.outcome import Diagnosis
from mjfriction.identify.gap import measure_gap
from mjfriction.record.readers import read_log
from mjfriction.robot.files import read_robot
from tests.hidden.machine import UR5_COULOMB, UR5_JOINTS, Instant, Machine, write_case

ELBOW = 2
HEIGHT = 0.7 * UR5_COULOMB[ELBOW]


def worn(share: float, width: float) -> Machine:
    """A machine whose elbow is worn at a share of its stroke; the width is one too."""

    def spot(at: Instant) -> np.ndarray:
        low, stroke = np.min(at.q), np.ptp(at.q)
        return HEIGHT * np.exp(-0.5 * np.square((at.q - low - share * stroke) / (width * stroke))) * np.sign(at.v)

    return Machine(hidden={ELBOW: spot})


def diagnosed(folder: Path, machine: Machine) -> Diagnosis:
    log, robot = write_case(folder, machine, seed=5, seconds=50.0)
    return diagnose_log(read_log(log), read_robot(robot))


@pytest.mark.parametrize(("share", "width"), [(0.4, 0.05), (0.7, 0.15), (0.9, 0.1)])
def test_a_worn_place_is_told_with_where_it_is_and_how_wide(share: float, width: float, tmp_path: Path) -> None:
    found = diagnosed(tmp_path, worn(share, width))
    (finding,) = found.findings
    assert (finding.cause, finding.joint) == ("friction.position", UR5_JOINTS[ELBOW])
    position = found.gap.motion.position[:, ELBOW]
    low, stroke = np.min(position), np.ptp(position)
    told = {value.name: value for value in finding.parameters}
    for name, true in (("coulomb", HEIGHT), ("position", low + share * stroke), ("width", width * stroke)):
        # Intervals of 95 %, of nine in all: twice their width leaves room for none.
        assert abs(told[name].value - true) < 2.0 * (told[name].high - told[name].value), name
    assert told["coulomb"].value == pytest.approx(HEIGHT, rel=0.15)
    assert told["position"].value == pytest.approx(low + share * stroke, abs=0.05 * stroke)


def test_waves_alone_leave_more_of_it(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    machine = worn(0.4, 0.05)
    left = []
    for causes in (
        diagnosis.STRUCTURAL,
        tuple(cause for cause in diagnosis.STRUCTURAL if not isinstance(cause, FrictionSpot)),
    ):
        monkeypatch.setattr(diagnosis, "STRUCTURAL", causes)
        (elbow,) = [j for j in diagnosed(tmp_path, machine).joints if j.joint == UR5_JOINTS[ELBOW]]
        left.append(elbow.rms_heldout_after / elbow.noise_floor)
    assert left[0] < 1.1
    assert left[1] > 1.3


def test_a_place_that_is_passed_one_way_only_tells_of_no_friction(tmp_path: Path) -> None:
    log, robot = write_case(tmp_path, Machine(), seed=5, seconds=20.0)
    gap = measure_gap(read_log(log), read_robot(robot))
    position = gap.motion.position.copy()
    middle = float(np.median(position[:, ELBOW]))
    spot = FrictionSpot()
    assert spot.own_shape(gap, Site(ELBOW, (middle, 0.1)))
    position[:, ELBOW] = np.linspace(0.0, 2.0 * middle, position.shape[0])
    once = replace(gap, motion=replace(gap.motion, position=position))
    assert not spot.own_shape(once, Site(ELBOW, (middle, 0.1)))
    assert not any(site.joint == ELBOW for site in spot.sites(once))
