"""How uneven a machine is: what its friction shows along the strokes, and full measure where nothing could show."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import mujoco
import numpy as np
import pytest

from mjfriction.diagnose.causes.catalog import STRUCTURAL
from mjfriction.diagnose.causes.cause import Site
from mjfriction.diagnose.causes.offset import Offset
from mjfriction.diagnose.fit.exact import usual_nuisance
from mjfriction.diagnose.fit.model import Chosen, build_model
from mjfriction.diagnose.fit.trial import EVENEST
from mjfriction.diagnose.search.field import make_field
from mjfriction.diagnose.search.free_links import compete_for_links
from mjfriction.diagnose.search.unevenness import as_uneven, with_unevenness
from mjfriction.identify.gap import Gap
from mjfriction.identify.measure import measure_gap
from mjfriction.record.readers import read_log
from mjfriction.robot.files import read_robot
from tests.hidden.machine import UR5_COULOMB, Array, Instant, Machine, write_case


def wave(joint: int, share: float) -> Callable[[Instant], Array]:
    return lambda at: share * UR5_COULOMB[joint] * np.cos((5.0 + joint) * at.q + joint) * np.sign(at.v)


def gap_of_machine(folder: Path, machine: Machine) -> Gap:
    log, robot = write_case(folder, machine, seed=21)
    return measure_gap(read_log(log), read_robot(robot))


def unevenness_of(gap: Gap) -> float:
    return with_unevenness(gap, usual_nuisance(gap)).uneven


def test_a_quiet_log_of_an_even_machine_says_that_it_is_even(tmp_path: Path) -> None:
    assert unevenness_of(gap_of_machine(tmp_path, Machine(noise=0.03))) == EVENEST


def test_what_noise_hides_is_not_taken_to_be_absent(tmp_path: Path) -> None:
    assert unevenness_of(gap_of_machine(tmp_path, Machine(noise=1.0))) == 1.0


@pytest.mark.deep
def test_waves_that_wrong_links_hide_are_seen_once_the_links_are_right(tmp_path: Path) -> None:
    def stouter(model: mujoco.MjModel) -> None:
        body = model.body("upper_arm_link").id
        model.body_mass[body] *= 2.0
        model.body_inertia[body] *= 2.0

    machine = Machine(noise=0.03, change=stouter, hidden={joint: wave(joint, 0.03) for joint in (1, 2)})
    gap = gap_of_machine(tmp_path, machine)
    before = with_unevenness(gap, usual_nuisance(gap))
    found, _ = compete_for_links(gap, before, make_field(gap, STRUCTURAL))
    after = as_uneven(found)
    assert before.uneven < 0.7
    assert after.nuisance.uneven == 1.0
    # What zeros may be off by goes with it.
    again = build_model(gap, after.nuisance, after.chosen)
    np.testing.assert_allclose(after.strengths, again.strengths, rtol=1e-9)


def test_waves_of_a_torque_tell_it_as_waves_of_the_level_do(tmp_path: Path) -> None:
    def cogs(joint: int) -> Callable[[Instant], Array]:
        level = 0.03 * UR5_COULOMB[joint]
        return lambda at: level * np.cos((9.0 + joint) * at.q)

    two = Machine(noise=0.03, hidden={1: wave(1, 0.03), 2: cogs(2)})
    assert unevenness_of(gap_of_machine(tmp_path / "two", two)) == 1.0
    # One alone may be a cause.
    assert unevenness_of(gap_of_machine(tmp_path / "one", Machine(noise=0.03, hidden={2: cogs(2)}))) == EVENEST


@pytest.mark.parametrize(("joints", "rippling"), [((1, 2), False), ((1, 2, 3), True)])
def test_two_joints_of_six_may_each_have_a_wave_as_a_cause(
    joints: tuple[int, ...], *, rippling: bool, tmp_path: Path
) -> None:
    gap = gap_of_machine(tmp_path, Machine(noise=0.03, hidden={joint: wave(joint, 0.1) for joint in joints}))
    model = as_uneven(build_model(gap, usual_nuisance(gap), (Chosen(Offset(), Site(0)),)))
    assert (model.nuisance.wavy > 0.05) == rippling
    assert model.nuisance.uneven == 1.0  # what is required of other causes
