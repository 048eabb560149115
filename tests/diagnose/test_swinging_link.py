"""A link that swings on a transmission that gives, simulated as two masses in MuJoCo under a controller."""

from __future__ import annotations

import functools
from pathlib import Path

import mujoco
import numpy as np
import pyarrow as pa
import pytest

import mjfriction.diagnose.diagnosis as module
from mjfriction.diagnose.causes import elasticity, moved_link
from mjfriction.diagnose.causes.backlash import Backlash
from mjfriction.diagnose.causes.catalog import STRUCTURAL
from mjfriction.diagnose.causes.cause import Site
from mjfriction.diagnose.causes.elasticity import HardeningElasticity, Swinging, SwingingElasticity
from mjfriction.diagnose.causes.moved_link import own_slopes
from mjfriction.diagnose.diagnosis import diagnose_log
from mjfriction.diagnose.fit.exact import usual_nuisance
from mjfriction.diagnose.fit.model import Chosen, build_model
from mjfriction.diagnose.search import compete, oscillations, short_list
from mjfriction.diagnose.search.field import chances_in, make_field
from mjfriction.diagnose.tell.outcome import Verdict
from mjfriction.identify.measure import measure_gap, thinned
from mjfriction.plant.machine import simulate
from mjfriction.plant.motions import excitation, pick_and_place
from mjfriction.plant.sensors import Recorder
from mjfriction.record.log import Log
from mjfriction.record.readers import read_log
from mjfriction.record.readers.table import log_from_table
from mjfriction.robot import effort
from mjfriction.robot.files import read_robot
from mjfriction.robot.schema import Transmission
from mjfriction.robot.transmission import natural_frequency
from mjfriction.sim import closed_loop
from tests.hidden.machine import Machine, write_case

PAN, COMPLIANCE, DAMPING = "shoulder_pan_joint", 6e-4, 0.04
WELL_DAMPED = 0.2
SOFT, HARDENING = 2e-3, 1e6  # rad per N·m; N·m/rad³
STIFF, STIFFER, SPARSE, QUIET = 2e-4, 1e-4, 100.0, 0.05  # rad per N·m; Hz; N·m


@functools.cache
def swinging(
    damping: float = DAMPING,
    compliance: float = COMPLIANCE,
    rate: float = 250.0,
    noise: float = 0.3,
    joint: str = PAN,
    hardening: float = 0.0,
) -> Log:
    robot = read_robot("ur5")
    soft = Transmission(compliance=compliance, damping_ratio=damping, hardening=hardening)
    machine = robot.with_joint(robot.joint(joint).model_copy(update={"transmission": soft}))
    for table in machine.table.joint:
        sensor = table.effort_sensor.model_copy(update={"noise": noise})
        machine = machine.with_joint(table.model_copy(update={"effort_sensor": sensor}))
    poses = np.array([0.0, -1.2, 1.0, 0.0, 0.6, 0.0]) + np.random.default_rng(5).uniform(-0.6, 0.6, (14, 6))
    motion = pick_and_place(robot.joints, poses, np.full(6, 1.2), np.full(6, 6.0))
    return log_from_table(pa.table(simulate(machine, motion, recorder=Recorder(rate), seed=1)), "swinging")


@pytest.mark.deep
def test_a_link_that_swings_on_its_transmission_is_one_that_gives() -> None:
    found = diagnose_log(swinging(), read_robot("ur5"))
    assert [(finding.cause, finding.joint) for finding in found.findings] == [("drive.elasticity", PAN)]
    assert found.verdict is Verdict.EXPLAINED
    compliance, damping = found.findings[0].parameters
    assert compliance.value == pytest.approx(COMPLIANCE, rel=0.05)
    assert 0.5 * DAMPING < damping.value < 2.0 * DAMPING
    assert "swings on it" in found.findings[0].evidence
    own = found.robot.joint(PAN).transmission
    assert (own.compliance, own.damping_ratio) == (compliance.value, damping.value)
    again = diagnose_log(swinging(), found.robot)
    assert (again.verdict, again.findings) == (Verdict.CONSISTENT, ())


@pytest.mark.deep
@pytest.mark.parametrize("slowest", [0.8, 2.5])
def test_so_is_one_that_swings_hardly_faster_than_it_is_moved(slowest: float, monkeypatch: pytest.MonkeyPatch) -> None:
    slow, faster = 6e-3, tuple(own for own in elasticity.RESONANCES if own > 0.99 * slowest)
    monkeypatch.setattr(elasticity, "RESONANCES", faster)
    found = diagnose_log(swinging(WELL_DAMPED, slow), read_robot("ur5"))
    named = [(finding.cause, finding.joint) for finding in found.findings]
    assert (named == [("drive.elasticity", PAN)]) is (slowest < 1.0)
    assert slowest > 1.0 or found.findings[0].parameters[0].value == pytest.approx(slow, rel=0.1)


@pytest.mark.deep
def test_the_frequencies_of_a_link_that_swings_are_its_own_in_every_pose() -> None:
    gap = measure_gap(swinging(), read_robot("ur5"))
    soft = Chosen(SwingingElasticity(), Site(0, (DAMPING,), around=COMPLIANCE))
    model = build_model(gap, usual_nuisance(gap), (soft,))
    own = soft.cause.resonances(gap, soft.site, model.strengths[model.places[0]])
    inertia = 1.0 / (COMPLIANCE * np.square(2.0 * np.pi * own))  # kg·m² of the arm about its first joint
    assert 0.5 < np.min(inertia) < np.max(inertia) < 10.0
    assert all(oscillations._of_own_link(model, float(frequency)) for frequency in (np.min(own), np.max(own)))
    assert not oscillations._of_own_link(model, float(2.0 * np.max(own)))
    assert not oscillations._of_own_link(model.without(soft), float(np.median(own)))


@pytest.mark.deep
@pytest.mark.parametrize("cause", [SwingingElasticity(), Backlash()])
@pytest.mark.parametrize("at_a_time", [1, 2, 100])
def test_many_places_of_a_joint_are_screened_as_each_by_itself(
    cause: SwingingElasticity | Backlash, at_a_time: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    gap = thinned(measure_gap(swinging(), read_robot("ur5")))
    sites = [site for site in cause.sites(gap) if site.joint == 0][::6]
    assert len(sites) > 2
    monkeypatch.setattr(moved_link, "AT_A_TIME", at_a_time * gap.motion.time.size)
    (many,) = cause.screening(gap, sites, 2).values()
    for own, site in zip(many.swapaxes(0, 1), sites, strict=True):
        (alone,) = cause.screening(gap, [site], 2).values()
        np.testing.assert_allclose(own, alone[:, 0], rtol=1e-9, atol=1e-12 * np.max(np.abs(own)))
    assert not np.allclose(many[:, 0], many[:, -1])


@pytest.mark.deep
def test_one_that_swings_well_damped_is_found_too() -> None:
    (finding,) = diagnose_log(swinging(WELL_DAMPED), read_robot("ur5")).findings
    assert (finding.cause, finding.joint) == ("drive.elasticity", PAN)
    compliance, damping = finding.parameters
    assert compliance.value == pytest.approx(COMPLIANCE, rel=0.1)
    assert 0.5 * WELL_DAMPED < damping.value < 2.0 * WELL_DAMPED


@pytest.mark.deep
def test_one_that_stiffens_as_it_gives_is_found_with_the_spring_it_has(monkeypatch: pytest.MonkeyPatch) -> None:
    log = swinging(0.06, SOFT, hardening=HARDENING)
    found = diagnose_log(log, read_robot("ur5"))
    assert [(finding.cause, finding.joint) for finding in found.findings] == [("drive.elasticity", PAN)]
    assert found.verdict is Verdict.EXPLAINED
    compliance, damping, hardening = found.findings[0].parameters
    assert compliance.value == pytest.approx(SOFT, rel=0.1)
    assert hardening.value == pytest.approx(HARDENING, rel=0.2)
    assert 0.03 < damping.value < 0.12
    own = found.robot.joint(PAN).transmission
    assert (own.compliance, own.damping_ratio, own.hardening) == (compliance.value, damping.value, hardening.value)
    again = diagnose_log(log, found.robot)
    assert (again.verdict, again.findings) == (Verdict.CONSISTENT, ())
    rest = tuple(cause for cause in STRUCTURAL if not isinstance(cause, HardeningElasticity))
    monkeypatch.setattr(module, "STRUCTURAL", rest)
    assert diagnose_log(log, read_robot("ur5")).verdict is not Verdict.EXPLAINED


@pytest.mark.deep
def test_following_its_load_at_once_it_is_not_explained(monkeypatch: pytest.MonkeyPatch) -> None:
    rest = tuple(cause for cause in STRUCTURAL if not isinstance(cause, Swinging))
    monkeypatch.setattr(module, "STRUCTURAL", rest)
    found = diagnose_log(swinging(), read_robot("ur5"))
    assert found.verdict is not Verdict.EXPLAINED or [f.cause for f in found.findings] != ["drive.elasticity"]


@pytest.mark.deep
@pytest.mark.parametrize(("compliance", "below", "above"), [(STIFF, 0.3, 0.5), (STIFFER, 0.5, 0.8)])
def test_one_that_swings_at_up_to_four_fifths_of_the_cutoff_is_found(
    compliance: float, below: float, above: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    stiff = swinging(WELL_DAMPED, compliance, SPARSE, QUIET)
    gap = measure_gap(stiff, read_robot("ur5"))
    resonance = np.median(natural_frequency(own_slopes(gap, 0)[2], compliance)) / (2.0 * np.pi)
    assert below * gap.motion.cutoff < resonance < above * gap.motion.cutoff
    found = diagnose_log(stiff, read_robot("ur5"))
    assert found.robot.joint(PAN).transmission.compliance == pytest.approx(compliance, rel=0.05)
    assert found.robot.joint(PAN).transmission.damping_ratio == pytest.approx(WELL_DAMPED, rel=0.5)
    # The stiffer one makes a fifth of a percent of the effort, and is told since no more than noise is left anywhere.
    assert [(finding.cause, finding.joint) for finding in found.findings] == [("drive.elasticity", PAN)]
    monkeypatch.setattr(elasticity, "RESONANCE_BAND", below)
    found = diagnose_log(stiff, read_robot("ur5"))
    assert found.robot.joint(PAN).transmission.damping_ratio == Transmission().damping_ratio


@pytest.mark.deep
def test_a_link_that_others_may_feel_more_is_tried_beside_one_of_its_kind_that_ranks_before_it(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    lift, elbow = 1, 2
    gap = thinned(measure_gap(swinging(0.1, 1e-3, SPARSE, joint="shoulder_lift_joint"), read_robot("ur5")))
    model = build_model(gap, usual_nuisance(gap), ())
    field = make_field(gap, (SwingingElasticity(),))
    last = sorted(short_list.ranked(model, field), key=lambda choice: choice.site.joint == lift)
    assert [choice.site.joint for choice in last] == [elbow, lift]
    # One at the elbow could do by itself, were the other not asked.
    monkeypatch.setattr(compete, "ranked", lambda *_: last)
    monkeypatch.setattr(compete, "SHORT_LIST", 1)
    monkeypatch.setattr(compete, "passing", lambda trials, _: [trial for trial in trials if trial.merit > 0.0])

    def able() -> set[int]:
        return {
            trial.chosen.site.joint
            for trial in compete._passing(model, field, chances_in(field), short_list.Tried({}, {}))
        }

    assert able() == {elbow, lift}
    monkeypatch.setattr(SwingingElasticity, "ranked_alone", False)
    assert able() == {elbow}


def test_a_joint_that_carries_nothing_has_no_spring_to_try(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path, robot = write_case(tmp_path, Machine(), seed=1, seconds=10.0)
    gap = measure_gap(read_log(path), read_robot(robot))
    assert {site.joint for site in HardeningElasticity().sites(gap)} == set(gap.examined)
    load = HardeningElasticity.load
    monkeypatch.setattr(HardeningElasticity, "load", lambda *asked: (asked[2] != 0) * load(*asked))
    assert {site.joint for site in HardeningElasticity().sites(gap)} == set(gap.examined) - {0}


@pytest.mark.deep
def test_a_spring_that_hardens_is_tried_though_no_straight_one_is_drawn_near_its_fit() -> None:
    gap = thinned(measure_gap(swinging(0.03, 4e-3, SPARSE, QUIET, hardening=1e6), read_robot("ur5")))
    model = build_model(gap, usual_nuisance(gap), ())
    field = make_field(gap, (SwingingElasticity(), HardeningElasticity()))
    # Straight springs gain a little, but none of the strength that it was drawn for: the motion shows a stiffer one.
    ranked = [(type(choice.cause), choice.site.joint) for choice in short_list.ranked(model, field)]
    assert (SwingingElasticity, 0) not in ranked
    assert ranked[0] == (HardeningElasticity, 0)


LIFT = "shoulder_lift_joint"


@pytest.fixture(scope="module")
def ringing_from_before() -> Log:
    """A log that begins while the link swings, as one does that was held where its motor is and let go."""
    robot = read_robot("ur5")
    soft = Transmission(compliance=7.2e-4, damping_ratio=0.01)
    machine = robot.with_joint(robot.joint(LIFT).model_copy(update={"transmission": soft}))
    for own in machine.table.joint:
        (term,) = own.friction or ()
        noisy = own.effort_sensor.model_copy(update={"noise": 0.2 * float(term.parameters["coulomb"])})
        machine = machine.with_joint(own.model_copy(update={"effort_sensor": noisy}))
    home = np.array([0.0, -1.2, 1.4, -0.4, 1.2, 0.0])
    motion = excitation(robot.joints, home, np.full(6, 0.8), np.full(6, 1.5), 40.0, seed=3)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(closed_loop, "SETTLING", 0.0)
        patch.setattr(closed_loop, "sag", lambda model, data, *_: mujoco.mj_forward(model, data))
        columns = simulate(machine, motion, recorder=Recorder(250.0), controller_robot=robot, seed=3)
    return log_from_table(pa.table(columns), "ringing")


@pytest.mark.deep
def test_a_link_that_swings_from_before_the_log_is_one_that_gives(ringing_from_before: Log) -> None:
    (finding,) = diagnose_log(ringing_from_before, read_robot("ur5")).findings
    assert (finding.cause, finding.joint) == ("drive.elasticity", LIFT)
    assert finding.parameters[0].value == pytest.approx(7.2e-4, rel=0.1)


@pytest.mark.deep
@pytest.mark.parametrize("without", ["promising", "given_along"])
def test_it_is_found_by_what_its_drive_passes_on_and_by_what_columns_damped_otherwise_show(
    without: str, ringing_from_before: Log, monkeypatch: pytest.MonkeyPatch
) -> None:
    if without == "promising":
        monkeypatch.setattr(Swinging, "promises", None)
    else:
        for place in (elasticity, effort):
            monkeypatch.setattr(place, "given_along", lambda *_: None)
    assert not diagnose_log(ringing_from_before, read_robot("ur5")).findings
