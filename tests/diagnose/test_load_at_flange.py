"""A last link that is off and a load at the flange do the same; of the two it is the load that was not stated."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import mujoco
import numpy as np
import pytest

from mjfriction.diagnose.causes import hung_payload
from mjfriction.diagnose.causes.cause import Cause, Site
from mjfriction.diagnose.causes.hung_payload import FAR_OUT
from mjfriction.diagnose.causes.links import LinkCentre, LinkScale, LoneWholeLink
from mjfriction.diagnose.causes.payload import Payload
from mjfriction.diagnose.fit.model import Chosen, Model, build_model
from mjfriction.diagnose.fit.nuisance import make_nuisance
from mjfriction.diagnose.fit.tangent import straightened
from mjfriction.diagnose.search.field import make_field
from mjfriction.diagnose.settle.load_at_flange import as_load
from mjfriction.diagnose.tell import alike
from mjfriction.diagnose.tell.alike import standing
from mjfriction.identify.measure import measure_gap
from mjfriction.record.readers import read_log
from mjfriction.robot.files import read_robot
from tests.hidden.machine import UR5_COULOMB, Machine, write_case

FOREARM, LAST = 2, 5
Change = Callable[[mujoco.MjModel], None]


def heavier(link: str, mass: float, at: float) -> Change:
    """Return a change by which a link holds a mass at a place along its z, m."""

    def change(model: mujoco.MjModel) -> None:
        body = model.body(link).id
        own, centre = model.body_mass[body], model.body_ipos[body].copy()
        model.body_ipos[body] = (own * centre + mass * np.array([0.0, 0.0, at])) / (own + mass)
        model.body_mass[body] = own + mass

    return change


def hung(mass: float, at: float) -> Change:
    """Return a change by which the last link holds a small body far along its z, m, and the link before has lost some
    mass.
    """

    def change(model: mujoco.MjModel) -> None:
        body = model.body("wrist_3_link").id
        apart, own = np.array([0.0, 0.0, at]) - model.body_ipos[body], model.body_mass[body]
        turned = np.empty(9)
        mujoco.mju_quat2Mat(turned, model.body_iquat[body])
        axes = turned.reshape(3, 3)
        moments = axes @ np.diag(model.body_inertia[body]) @ axes.T
        moments += own * mass / (own + mass) * (apart @ apart * np.eye(3) - np.outer(apart, apart))
        model.body_inertia[body], axes = np.linalg.eigh(moments)
        axes[:, 0] *= np.linalg.det(axes)
        mujoco.mju_mat2Quat(model.body_iquat[body], axes.ravel())
        heavier("wrist_3_link", mass, at)(model)
        model.body_mass[model.body("wrist_2_link").id] -= 0.12

    return change


def moved(model: mujoco.MjModel) -> None:
    model.body_ipos[model.body("wrist_3_link").id] += (0.0, 0.08, 0.0)


def found(folder: Path, change: Change, cause: Cause, joint: int, *, links: bool = False, noise: float = 0.02) -> Model:
    """Return the model of a machine with its true cause drawn as another."""
    machine = Machine(change=change, noise=noise, coulomb=tuple(0.2 * own for own in UR5_COULOMB))
    log, robot = write_case(folder, machine, seed=5)
    gap = measure_gap(read_log(log), read_robot(robot), highest=60.0)
    nuisance = make_nuisance(gap)
    kept = nuisance if links else nuisance.without_links()
    return straightened(build_model(gap, kept, (Chosen(cause, Site(joint)),)))


@pytest.mark.parametrize(
    ("change", "cause", "joint", "load"),
    [
        (heavier("wrist_3_link", 0.15, 0.04), LoneWholeLink(), LAST, True),
        (heavier("forearm_link", 0.3, 0.04), LoneWholeLink(), FOREARM, False),
        (moved, LinkCentre(), LAST, False),  # no load has a moment and no mass
    ],
)
def test_a_last_link_that_a_load_makes_up_for_is_a_load(
    tmp_path: Path, change: Change, cause: Cause, joint: int, *, load: bool
) -> None:
    model = found(tmp_path, change, cause, joint)
    (choice,) = as_load(model, exact=True).chosen
    assert isinstance(choice.cause, Payload) is load


def test_where_links_are_off_it_has_to_be_more_than_they_could_make_up_for(tmp_path: Path) -> None:
    small, large = (
        found(tmp_path / name, heavier("wrist_3_link", mass, 0.0), LinkScale(), LAST, links=True)
        for name, mass in (("small", 0.012), ("large", 0.3))
    )
    assert as_load(small, exact=False) is small
    assert [choice.cause.name for choice in as_load(large, exact=False).chosen] == ["body.payload"]
    assert [choice.cause.name for choice in as_load(small, exact=True).chosen] == ["body.payload"]


def test_a_load_whose_mass_hardly_shows_hangs_far_out(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    mass, at = 0.1, 0.28
    model = found(tmp_path, hung(mass, at), LinkCentre(), LAST, links=True, noise=0.3)
    (site,) = Payload().sites(model.gap)
    near = build_model(model.gap, model.nuisance, (Chosen(Payload(), site),))
    assert not Payload().admissible(model.gap, site, near.strengths[near.places[-1]])
    ((load, strengths),) = as_load(model, exact=False).fitted_causes
    robot = load.cause.extend(model.gap.robot, load.site, strengths)
    assert robot.table.payload is not None
    assert robot.table.payload.mass * np.array(robot.table.payload.com) == pytest.approx([0, 0, mass * at], abs=0.003)
    assert np.linalg.norm(robot.table.payload.com) == pytest.approx(FAR_OUT)
    # With moments of inertia as near the last link it fits less well.
    fits, about = as_load(model, exact=False), hung_payload.torques_about
    monkeypatch.setattr(hung_payload, "torques_about", lambda gap, _: about(gap, None))
    slightly = replace(load, site=load.site.shaped((0.0, 0.0, FAR_OUT)))  # no columns of it are cached
    other = build_model(model.gap, model.nuisance, (slightly,))
    assert np.sum(other.heldout_errors) > 1.01 * np.sum(fits.heldout_errors)


def test_how_a_link_or_a_load_spreads_is_not_known(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def stouter(model: mujoco.MjModel) -> None:
        body = model.body("wrist_3_link").id
        model.body_mass[body] *= 1.6
        model.body_inertia[body] *= 1.6

    model = found(tmp_path, stouter, LinkScale(), LAST, noise=1.0)
    field = make_field(model.gap, (Payload(), LinkScale()))
    assert standing(model, model.chosen[0], field).alternatives == ("body.payload",)
    # Four numbers cost more on motion not fitted than one.
    monkeypatch.setattr(alike, "AS_LITTLE", 1.0)
    assert standing(model, model.chosen[0], field).alternatives == ()
