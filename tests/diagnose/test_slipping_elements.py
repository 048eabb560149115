"""Presliding over a travel as long as the motion's: elements that slip one after the other lean as a spring does."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from mjfriction.diagnose.causes.cause import Site
from mjfriction.diagnose.causes.presliding import DampedPresliding, Presliding, SlippingElements
from mjfriction.diagnose.causes.spring import BentSpring
from mjfriction.diagnose.diagnosis import diagnose_log
from mjfriction.diagnose.fit.exact import usual_nuisance
from mjfriction.diagnose.fit.model import Chosen, Model, build_model
from mjfriction.diagnose.search.allowed import as_allowed
from mjfriction.diagnose.search.field import make_field
from mjfriction.diagnose.settle.stated import settle
from mjfriction.diagnose.tell.outcome import Diagnosis
from mjfriction.identify.doubt import YIELDING
from mjfriction.identify.measure import measure_gap
from mjfriction.laws.ambient import ambient
from mjfriction.laws.maxwell_slip import MAXWELL_SLIP
from mjfriction.record.readers import read_log
from mjfriction.robot.files import read_robot
from mjfriction.robot.predict import predict_log
from tests.hidden.machine import UR5_COULOMB, UR5_JOINTS, Array, Instant, Machine, bristle, write_case

ELBOW = 2
DISTANCES = np.array([0.06, 0.12, 0.25, 0.5])  # rad, over which each of four alike elements is drawn until it slips


def slipping(at: Instant) -> Array:
    drawn = np.zeros((at.q.size, DISTANCES.size))
    for i in range(1, at.q.size):
        drawn[i] = np.clip(drawn[i - 1] + (at.q[i] - at.q[i - 1]) / DISTANCES, -1.0, 1.0)
    return np.asarray(UR5_COULOMB[ELBOW] * (np.mean(drawn, axis=1) - np.sign(at.v)))


def diagnosed(folder: Path) -> Diagnosis:
    log, robot = write_case(folder, Machine(hidden={ELBOW: slipping}), seed=4)
    return diagnose_log(read_log(log), read_robot(robot))


@pytest.fixture(scope="module")
def diagnosis(tmp_path_factory: pytest.TempPathFactory) -> Diagnosis:
    return diagnosed(tmp_path_factory.mktemp("slipping"))


@pytest.mark.deep
def test_they_are_presliding_and_nothing_else(diagnosis: Diagnosis) -> None:
    (finding,) = diagnosis.findings
    assert (finding.cause, finding.joint) == ("friction.presliding", UR5_JOINTS[ELBOW])
    levels = [value.value for value in finding.parameters if value.name.startswith("presliding_level")]
    assert sum(levels) == pytest.approx(UR5_COULOMB[ELBOW], rel=0.05)
    assert finding.gain.reduction > 0.9


def test_the_extended_robot_predicts_another_motion(diagnosis: Diagnosis, tmp_path: Path) -> None:
    extended = diagnosis.robot
    assert "maxwell_slip" in {term.law for term in extended.joint(UR5_JOINTS[ELBOW]).friction or ()}
    column = f"effort.{UR5_JOINTS[ELBOW]}"
    paths = write_case(tmp_path, Machine(hidden={ELBOW: slipping}, noise=1e-3), 21)
    log, stated = read_log(paths[0]), read_robot(paths[1])
    left, before = (log.columns[column] - predict_log(log, robot)[column] for robot in (extended, stated))
    rms = [float(np.sqrt(np.mean(np.square(course)))) for course in (left, before)]
    assert rms[0] < 0.12 * rms[1], rms


@pytest.mark.deep
def test_a_bristle_needs_a_spring_beside_it(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for cause in (Presliding, DampedPresliding):
        monkeypatch.setattr(cause, "richer", None)
    monkeypatch.setattr(BentSpring, "least_cleared", 0.0)
    assert {finding.cause for finding in diagnosed(tmp_path).findings} == {"friction.presliding", "body.spring"}


@pytest.mark.deep
def test_elements_that_hardly_slip_within_the_stroke_are_elements_and_no_spring(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    distances = 1.6 * np.array([0.06, 0.2, 0.5, 1.0])

    def long(at: Instant) -> Array:
        drawn = np.zeros((at.q.size, distances.size))
        for i in range(1, at.q.size):
            drawn[i] = np.clip(drawn[i - 1] + (at.q[i] - at.q[i - 1]) / distances, -1.0, 1.0)
        return np.asarray(UR5_COULOMB[ELBOW] * (np.mean(drawn, axis=1) - np.sign(at.v)))

    log, robot = write_case(tmp_path, Machine(hidden={ELBOW: long}), seed=4)

    def told() -> list[str]:
        return [finding.cause for finding in diagnose_log(read_log(log), read_robot(robot)).findings]

    assert told() == ["friction.presliding"]
    monkeypatch.setattr(SlippingElements, "longest", Presliding.longest)
    assert "body.spring" in told()


@pytest.mark.deep
def test_a_spring_beside_a_bristle_is_a_spring(tmp_path: Path) -> None:
    def both(at: Instant) -> Array:
        return np.asarray(0.8 * UR5_COULOMB[ELBOW] * (bristle(at.q, 0.06) - np.sign(at.v)) + 6.0 * at.q)

    log, robot = write_case(tmp_path, Machine(hidden={ELBOW: both}), seed=4)
    told = {finding.cause for finding in diagnose_log(read_log(log), read_robot(robot)).findings}
    assert told == {"friction.presliding", "body.spring"}


@pytest.mark.parametrize(
    ("travel", "levels", "told"),
    [(0.6, (0.0, 1.0, 1.5), True), (0.4, (0.0, 1.0, 1.5), False), (0.6, (1.0, 1.0, 0.1), False)],
)
def test_elements_that_all_slip_within_what_any_contact_yields_are_refitted_along(
    travel: float, levels: tuple[float, ...], told: bool, tmp_path: Path
) -> None:
    # The last element that holds a part slips after twice the travel, or after three quarters of it.
    log, robot = write_case(tmp_path, Machine(), seed=4, seconds=15.0)
    gap = measure_gap(read_log(log), read_robot(robot))
    yields = YIELDING * float(np.ptp(gap.motion.position[:, ELBOW]))
    assert SlippingElements().noteworthy(gap, Site(ELBOW, (travel * yields,)), np.array(levels)) is told


@pytest.mark.parametrize("levels", [(1.0, 0.0, 0.0), (0.0, 0.0, 2.0), (1.0, 2.0, 0.5), (3.0, -0.1, 1.0)])
def test_their_travel_is_that_over_which_so_much_of_the_change_builds_up(levels: tuple[float, ...]) -> None:
    cause, site, strengths = SlippingElements(), Site(ELBOW, (0.2,)), np.array(levels)
    law, values = cause.law(float(np.sum(np.maximum(strengths, 0.0))), 0.2, strengths)
    steps = 20000
    velocity = np.repeat([1.0, -1.0], steps)
    friction = law.follow(velocity, ambient(velocity.size), 1.0 / steps, law.pack(values))[0]
    built = 1.0 - (friction[steps:] / friction[steps - 1] + 1.0) / 2.0
    travel = np.interp(1.0 - 1.0 / np.e, built, np.arange(1, steps + 1) / steps)
    assert cause.travel(site, strengths) == pytest.approx(travel, rel=1e-3)


def test_an_element_that_holds_nothing_is_not_built_in() -> None:
    robot, strengths = read_robot("ur5"), np.array([1.0, -0.04, 2.0])
    extended = SlippingElements().extend(robot, Site(ELBOW, (0.2,)), strengths)
    (term,) = [own for own in extended.joint(UR5_JOINTS[ELBOW]).friction or () if own.law == "maxwell_slip"]
    assert term.parameters["level"] == pytest.approx([1.0 * 2.96 / 3.0, 2.0 * 2.96 / 3.0])
    assert len(term.parameters["stiffness"]) == 2
    MAXWELL_SLIP.pack(term.parameters)


@pytest.mark.deep
@pytest.mark.parametrize("seed", range(4))
def test_two_elements_are_elements_and_no_damped_bristle(seed: int, tmp_path: Path) -> None:
    distances = np.random.default_rng(seed).uniform([0.03, 0.2], [0.08, 0.5])

    def two(at: Instant) -> Array:
        drawn = np.zeros((at.q.size, 2))
        for i in range(1, at.q.size):
            drawn[i] = np.clip(drawn[i - 1] + (at.q[i] - at.q[i - 1]) / distances, -1.0, 1.0)
        return np.asarray(UR5_COULOMB[ELBOW] * (np.mean(drawn, axis=1) - np.sign(at.v)))

    log, robot = write_case(tmp_path, Machine(hidden={ELBOW: two}), seed=seed)
    diagnosis = diagnose_log(read_log(log), read_robot(robot))
    assert [finding.cause for finding in diagnosis.findings] == ["friction.presliding"]
    assert "maxwell_slip" in {term.law for term in diagnosis.robot.joint(UR5_JOINTS[ELBOW]).friction or ()}
    predict_log(read_log(log), diagnosis.robot)


@pytest.fixture(scope="module")
def driving(tmp_path_factory: pytest.TempPathFactory) -> Model:
    log, robot = write_case(tmp_path_factory.mktemp("driving"), Machine(hidden={ELBOW: slipping}), seed=4, seconds=20.0)
    gap = measure_gap(read_log(log), read_robot(robot))
    too_short = Chosen(SlippingElements(), Site(ELBOW, (0.05,)))  # so that the middle one of them drives the joint
    return build_model(gap, usual_nuisance(gap), (too_short,))


def test_elements_of_which_one_drives_come_in_a_form_in_which_none_does(driving: Model) -> None:
    assert driving.admissible().chosen == ()
    allowed = as_allowed(driving, make_field(driving.gap, (Presliding(), DampedPresliding())))
    (choice,) = allowed.chosen
    assert isinstance(choice.cause, SlippingElements)
    assert np.min(allowed.strengths[allowed.places[0]]) > 0.0
    assert as_allowed(allowed, ()) is allowed


def test_what_has_no_form_that_nature_allows_is_left_out(driving: Model) -> None:
    assert as_allowed(driving, ()).chosen == ()


def test_what_is_settled_keeps_them(driving: Model) -> None:
    settled = settle(driving, make_field(driving.gap, (Presliding(), DampedPresliding())))
    assert [choice.cause.name for choice in settled.model.chosen] == ["friction.presliding"]


def test_a_bristle_whose_damping_drives_it_is_one_without(driving: Model) -> None:
    driven = Chosen(DampedPresliding(), Site(ELBOW, (0.2,)))
    model = build_model(driving.gap, driving.nuisance, (driven,))
    assert model.admissible().chosen == ()
    (choice,) = as_allowed(model, make_field(model.gap, (Presliding(), DampedPresliding()))).chosen
    assert isinstance(choice.cause, Presliding)
