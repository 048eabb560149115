"""Friction that is higher at one place of the stroke is told with the place and its width."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from mjfriction.diagnose import diagnosis
from mjfriction.diagnose.causes.cause import Site
from mjfriction.diagnose.causes.friction_edge import FrictionAbove, FrictionBelow
from mjfriction.diagnose.causes.friction_spot import FrictionSpot
from mjfriction.diagnose.causes.waves import Cogging, PositionFriction
from mjfriction.diagnose.diagnosis import diagnose_log
from mjfriction.diagnose.fit.model import Chosen, build_model
from mjfriction.diagnose.fit.nuisance import make_nuisance
from mjfriction.diagnose.fit.shapes import apart
from mjfriction.diagnose.search import refusal
from mjfriction.diagnose.tell.outcome import Diagnosis
from mjfriction.identify.gap import Gap
from mjfriction.identify.measure import measure_gap
from mjfriction.record.readers import read_log
from mjfriction.robot.effort import predict_effort
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


@pytest.mark.deep
@pytest.mark.parametrize(
    ("share", "width"),
    [(0.4, 0.05), (0.7, 0.15), (0.9, 0.1)],
)
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


@pytest.mark.deep
def test_a_worn_place_is_told_by_its_flank(tmp_path: Path) -> None:
    """It lies beyond the stroke by one and a half of its widths."""
    found = diagnosed(tmp_path, worn(-0.15, 0.1))
    (finding,) = found.findings
    assert (finding.cause, finding.joint) == ("friction.position", UR5_JOINTS[ELBOW])
    (elbow,) = [joint for joint in found.joints if joint.joint == UR5_JOINTS[ELBOW]]
    assert elbow.rms_heldout_after < 1.1 * elbow.noise_floor


@pytest.mark.deep
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
    # A course along the stroke that takes the waves' place follows it in part.
    assert left[1] > 1.15 * left[0]


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


def gap_with_offset(folder: Path, offset: float) -> Gap:
    log, path = write_case(folder, Machine(), seed=5, seconds=10.0)
    robot = read_robot(path)
    joint = robot.table.joint[ELBOW]
    sensor = joint.position_sensor.model_copy(update={"offset": offset})
    return measure_gap(read_log(log), robot.with_joint(joint.model_copy(update={"position_sensor": sensor})))


@pytest.mark.parametrize(
    "cause",
    [FrictionSpot(), FrictionAbove(), FrictionBelow(), PositionFriction(), Cogging()],
    ids=lambda cause: type(cause).__name__,
)
def test_what_lies_along_the_stroke_is_stated_where_the_joint_is(
    cause: FrictionSpot | FrictionAbove | FrictionBelow | PositionFriction | Cogging, tmp_path: Path
) -> None:
    gap = gap_with_offset(tmp_path, 0.4)
    middle = float(np.median(gap.motion.position[:, ELBOW]))
    wave = isinstance(cause, PositionFriction | Cogging)
    strengths, shape = (np.array([2.0, -1.0]), (5.0,)) if wave else (np.array([2.0]), (middle, 0.15))
    site = Site(ELBOW, shape)
    extended = cause.extend(gap.robot, site, strengths)
    before, after = (predict_effort(one, one.body(), gap.motion).reported for one in (gap.robot, extended))
    expected = cause.samples(gap, site) @ strengths
    np.testing.assert_allclose((after - before)[:, ELBOW], expected, atol=1e-9)


def test_a_place_is_passed_often_where_it_is_and_within_a_motion(tmp_path: Path) -> None:
    gap = gap_with_offset(tmp_path, 0.0)
    count, position = gap.motion.time.size, gap.motion.position.copy()
    spot, shape = FrictionSpot(), (0.5, 0.02)

    def told(course: np.ndarray, piece: np.ndarray | None = None) -> bool:
        position[:, ELBOW] = course
        motion = replace(gap.motion, position=position.copy())
        if piece is not None:
            motion = replace(motion, piece=piece)
        return spot.own_shape(replace(gap, motion=motion), Site(ELBOW, shape))

    share = np.arange(count) / count
    to_and_fro = 0.5 - 0.5 * np.cos(2.0 * np.pi * 4.0 * share)
    assert told(to_and_fro)
    # Often at both ends, and once between.
    ends = 0.1 * to_and_fro + 0.9 * (share > 0.5)
    assert not told(ends)
    # Upward in every motion: where one ends and the next begins the joint went elsewhere unseen.
    upward, motions = (6.0 * share) % 1.0, (6.0 * share).astype(np.int64)
    assert not told(upward, motions)
    # Three passes are none, four are.
    for passes, often in ((3.0, False), (4.0, True)):
        assert told(0.5 - 0.5 * np.cos(np.pi * passes * share)) is often


def test_a_spot_beside_waves_is_refused(tmp_path: Path) -> None:
    gap = gap_with_offset(tmp_path, 0.0)
    middle = float(np.median(gap.motion.position[:, ELBOW]))
    spot, wave = Chosen(FrictionSpot(), Site(ELBOW, (middle, 0.1))), Chosen(PositionFriction(), Site(ELBOW, (5.0,)))
    alone, both = (build_model(gap, make_nuisance(gap), chosen) for chosen in ((spot,), (spot, wave)))
    assert refusal._among_waves(alone) == []
    assert [choice.key for choice in refusal._among_waves(both)] == [spot.key]
    assert spot.key != wave.key
    assert apart(both, Chosen(PositionFriction(), Site(ELBOW, (middle,))))
