"""Contacts that yield before they slide, at every joint: known from the start, no findings, and nothing hides there."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from mjfriction.diagnose.causes.catalog import STRUCTURAL
from mjfriction.diagnose.causes.cause import Site
from mjfriction.diagnose.causes.offset import Offset
from mjfriction.diagnose.causes.presliding import SLIPS, Presliding, SlippingElements
from mjfriction.diagnose.diagnosis import diagnose_log
from mjfriction.diagnose.fit.exact import usual_nuisance
from mjfriction.diagnose.fit.model import Chosen, build_model
from mjfriction.diagnose.search.field import make_field
from mjfriction.diagnose.search.yielding import yielding
from mjfriction.diagnose.tell import contacts
from mjfriction.diagnose.tell.outcome import Diagnosis, Verdict
from mjfriction.identify.gap import Gap
from mjfriction.identify.measure import measure_gap
from mjfriction.record.readers import read_log
from mjfriction.robot.files import read_robot
from tests.hidden.machine import UR5_COULOMB, UR5_JOINTS, Instant, Machine, bristle, write_case

LIFT, ELBOW = 1, 2
TRAVEL = 1e-3  # rad, over which friction builds up at every joint: half a thousandth of the strokes
EXCESS, STRIBECK_VELOCITY = 9.0, 0.05


def more_near_rest(at: Instant) -> np.ndarray:
    """The Stribeck level of a contact that yields as all others do."""
    return EXCESS * np.exp(-((np.abs(at.v) / STRIBECK_VELOCITY) ** 1.5)) * bristle(at.q, TRAVEL)


YIELDS = Machine(bristle_travel=TRAVEL, noise=0.05, velocity="clean")
STICKS = Machine(bristle_travel=TRAVEL, noise=0.05, velocity="clean", hidden={LIFT: more_near_rest})
STIFF = Machine(noise=0.05, velocity="clean")


def gap(folder: Path, machine: Machine) -> Gap:
    log, robot = write_case(folder, machine, seed=3, seconds=25.0, rate=500.0)
    return measure_gap(read_log(log), read_robot(robot))


def diagnosed(folder: Path, machine: Machine) -> Diagnosis:
    log, robot = write_case(folder, machine, seed=3, seconds=25.0, rate=500.0)
    return diagnose_log(read_log(log), read_robot(robot))


def test_it_is_seen_at_all_joints_with_the_travel_it_has(tmp_path: Path) -> None:
    own = gap(tmp_path, YIELDS)
    found = yielding(own, usual_nuisance(own), make_field(own, STRUCTURAL))
    strokes = np.ptp(own.motion.position, axis=0)
    assert {choice.site.joint for choice in found} == set(np.flatnonzero(1e-3 * strokes > TRAVEL).tolist())
    assert [choice.site.shape[0] for choice in found] == pytest.approx([TRAVEL] * len(found), rel=0.25)


def test_where_contacts_are_stiff_none_is_there(tmp_path: Path) -> None:
    own = gap(tmp_path, STIFF)
    assert yielding(own, usual_nuisance(own), make_field(own, STRUCTURAL)) == ()


@pytest.mark.deep
def test_at_every_joint_it_is_no_finding(tmp_path: Path) -> None:
    found = diagnosed(tmp_path, YIELDS)
    assert (found.verdict, found.findings) == (Verdict.CONSISTENT, ())


@pytest.mark.deep
def test_a_stribeck_curve_beside_it_is_found(tmp_path: Path) -> None:
    found = diagnosed(tmp_path, STICKS)
    (finding,) = found.findings
    assert (finding.cause, finding.joint) == ("friction.stribeck", UR5_JOINTS[LIFT])
    excess, velocity, _ = finding.parameters
    assert excess.value == pytest.approx(EXCESS, rel=0.1)
    assert velocity.value == pytest.approx(STRIBECK_VELOCITY, rel=0.1)


def builds_up(at: Instant) -> np.ndarray:
    """What the joint's friction lacks after each of its reversals."""
    return UR5_COULOMB[LIFT] * (bristle(at.q, TRAVEL) - np.sign(at.v))


@pytest.mark.deep
def test_at_one_joint_alone_it_is_one_where_it_is_most_of_what_is_wrong(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    machine = Machine(noise=0.01, velocity="clean", hidden={LIFT: builds_up})
    (finding,) = diagnosed(tmp_path, machine).findings
    assert (finding.cause, finding.joint) == ("friction.presliding", UR5_JOINTS[LIFT])
    level, travel = finding.parameters
    assert level.value == pytest.approx(UR5_COULOMB[LIFT], rel=0.1)
    assert travel.value == pytest.approx(TRAVEL, rel=0.1)
    monkeypatch.setattr(contacts, "RIGID", -np.inf)
    assert [one.cause for one in diagnosed(tmp_path, machine).findings] == ["friction.presliding"]
    monkeypatch.setattr(contacts, "NO_CONTACT", np.inf)
    assert diagnosed(tmp_path, machine).findings == ()


@pytest.mark.deep
def test_at_one_joint_alone_it_is_one_where_others_are_seen_to_be_rigid(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The sensor's noise is most of what is left there."""
    machine = Machine(noise=0.25, velocity="clean", hidden={LIFT: builds_up})
    found = diagnosed(tmp_path, machine)
    (finding,) = found.findings
    assert (finding.cause, finding.joint) == ("friction.presliding", UR5_JOINTS[LIFT])
    error = found.joints[LIFT]
    assert error.rms_heldout_before < 2.0 * error.rms_heldout_after
    # Where nobody knows what others would show, any contact may yield so.
    monkeypatch.setattr(contacts, "RIGID", -np.inf)
    assert diagnosed(tmp_path, machine).findings == ()


STROKE_TO_SLIP = 8e-4  # rad, half of which an ordinary contact is drawn either way until it slides


def clamped(joint: int) -> Callable[[Instant], np.ndarray]:
    """What friction that builds up evenly lacks after every reversal."""

    def lacks(at: Instant) -> np.ndarray:
        drawn = np.zeros(at.q.size)
        for k, step in enumerate(np.diff(at.q)):
            drawn[k + 1] = np.clip(drawn[k] + 2.0 * step / STROKE_TO_SLIP, -1.0, 1.0)
        return np.asarray(UR5_COULOMB[joint] * (drawn - np.sign(at.v)))

    return lacks


def told_beside(
    folder: Path, alike: tuple[int, ...], others: dict[int, Callable[[Instant], np.ndarray]] | None = None
) -> int:
    """Return how many causes are told of one joint's elements, where other joints yield as it does, or have something
    else.
    """
    hidden = {joint: clamped(joint) for joint in (LIFT, *alike)} | (others or {})
    own = gap(folder, Machine(noise=0.25, velocity="clean", hidden=hidden))
    elements = Chosen(SlippingElements(), Site(LIFT, (0.5 * STROKE_TO_SLIP / SLIPS[0],)))
    model = build_model(own, usual_nuisance(own), (elements,))
    before = {elements.key: model.without(elements).heldout_residual()}
    assert model.strengths_of(elements)[0] == pytest.approx(UR5_COULOMB[LIFT], rel=0.1)
    return len(contacts.more_than_contacts(model, before, model.heldout_residual()))


def test_elements_that_slip_soon_are_compared_by_the_travel_over_which_they_build_up(tmp_path: Path) -> None:
    """Not by that of the longest, which holds nothing: over that every other joint would look rigid."""
    others = tuple(joint for joint in range(6) if joint != LIFT)
    assert told_beside(tmp_path, ()) == 1
    assert told_beside(tmp_path, others) == 0


def test_where_other_small_errors_show_it_is_one_of_them(tmp_path: Path) -> None:
    def ripple(size: float) -> dict[int, Callable[[Instant], np.ndarray]]:
        return {0: lambda at: size * np.sin(17.0 * at.q)}

    assert told_beside(tmp_path, (), ripple(2.0)) == 1
    assert told_beside(tmp_path, (), ripple(5.0)) == 0


@pytest.mark.parametrize(
    ("able", "alike", "told"), [((ELBOW,), (), 1), ((ELBOW,), (ELBOW,), 0), ((), (), 0), ((ELBOW, 0), (0,), 0)]
)
def test_those_joints_are_asked_whose_motion_would_show_it(
    able: tuple[int, ...], alike: tuple[int, ...], told: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    known = Presliding.shape_bounds

    def bounds(cause: Presliding, gap: Gap, site: Site) -> list[tuple[float, float]]:
        return known(cause, gap, site) if site.joint in (LIFT, *able) else [(0.1, 0.2)]

    monkeypatch.setattr(Presliding, "shape_bounds", bounds)
    assert told_beside(tmp_path, alike) == told


@pytest.mark.deep
def test_beside_a_stribeck_curve_it_is_a_part_of_that_contact(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def sticks(at: Instant) -> np.ndarray:
        return builds_up(at) + more_near_rest(at)

    machine = Machine(noise=0.4, velocity="clean", hidden={LIFT: sticks})
    assert [one.cause for one in diagnosed(tmp_path, machine).findings] == ["friction.stribeck"]
    monkeypatch.setattr(contacts, "Stribeck", Offset)  # which none of its joints has
    found = {one.cause for one in diagnosed(tmp_path, machine).findings}
    assert found == {"friction.stribeck", "friction.presliding"}


def test_a_gear_yields_as_far_where_its_joint_is_turned_by_little(tmp_path: Path) -> None:
    short = gap(tmp_path, Machine(reach=(1.0, 0.3, *(1.0,) * 4)))
    stroke = np.ptp(short.motion.position[:, LIFT])
    assert stroke < 0.8
    for travel, told in ((0.9e-3, False), (1.1e-3, True)):
        assert travel > 1e-3 * stroke
        assert Presliding().noteworthy(short, Site(LIFT, (travel,)), np.ones(1)) is told
