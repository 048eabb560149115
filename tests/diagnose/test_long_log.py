"""Of a long log a part is searched; what is told is fitted to all of it, and what one moment changes is found."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import mujoco
import numpy as np
import pytest

from mjfriction.diagnose.diagnosis import diagnose_log
from mjfriction.diagnose.fit.nuisance import make_nuisance
from mjfriction.diagnose.tell.outcome import Diagnosis
from mjfriction.identify import excerpt as by
from mjfriction.identify.excerpt import excerpt
from mjfriction.identify.measure import measure_gap, thinned
from mjfriction.record.readers import read_log
from mjfriction.robot.files import read_robot
from tests.hidden.machine import UR5_COULOMB, UR5_JOINTS, Instant, Machine, write_case

PART = 15.0  # s
ELBOW, WRIST = 2, 3
LOADED, STEP, MOMENT = 0.1, 0.4 * UR5_COULOMB[WRIST], 23.4  # per N·m, N·m, s


PENDULUM = """<mujoco><worldbody><body name="arm"><joint name="axis" type="hinge" axis="0 1 0" range="-120 120"/>
<geom type="box" size="0.05 0.05 0.2" pos="0 0 0.3" mass="8"/></body></worldbody></mujoco>"""


def leaning(model: mujoco.MjModel) -> None:
    model.opt.gravity[:] = 9.81 * np.array([np.sin(0.03), 0.0, -np.cos(0.03)])


def turned(at: Instant) -> np.ndarray:
    return np.full_like(at.q, 0.04)


def rubbing_more_under_load(at: Instant) -> np.ndarray:
    return LOADED * np.abs(at.rigid) * np.sign(at.v)


def stepping(at: Instant) -> np.ndarray:
    return STEP * (at.time > MOMENT) * np.sign(at.v)


@pytest.fixture(scope="module")
def case(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path]:
    machine = Machine(hidden={ELBOW: rubbing_more_under_load, WRIST: stepping}, noise=0.1)
    return write_case(tmp_path_factory.mktemp("log"), machine, seed=8, seconds=60.0, rate=125.0)


def diagnosed(case: tuple[Path, Path]) -> Diagnosis:
    log, robot = case
    return diagnose_log(read_log(log), read_robot(robot))


@pytest.mark.deep
def test_a_part_tells_the_causes_and_the_whole_their_size(
    case: tuple[Path, Path], monkeypatch: pytest.MonkeyPatch
) -> None:
    whole = diagnosed(case)
    monkeypatch.setattr(by, "ENOUGH", PART)
    found = diagnosed(case)
    told = {(one.cause, one.joint): one for one in found.findings}
    assert told.keys() == {("friction.load", UR5_JOINTS[ELBOW]), ("event.change", UR5_JOINTS[WRIST])}
    assert found.gap.chain.time.size == whole.gap.chain.time.size
    for one in whole.findings:
        for value, searched in zip(one.parameters, told[one.cause, one.joint].parameters, strict=True):
            assert searched.value == pytest.approx(value.value, abs=0.2 * (value.high - value.low))
            assert searched.high - searched.low == pytest.approx(value.high - value.low, rel=0.2)
    # Only the whole says to a fraction of a second when it was.
    step = {one.name: one.value for one in told["event.change", UR5_JOINTS[WRIST]].parameters}
    assert step["coulomb"] == pytest.approx(STEP, rel=0.05)
    assert step["time"] == pytest.approx(MOMENT, abs=0.3)


@pytest.mark.parametrize(
    ("machine", "told"),
    [
        (Machine(change=leaning, noise=0.1), {"body.gravity_direction": ()}),
        (
            Machine(joints=("axis",), coulomb=(2.0,), viscous=(1.5,), sensed={0: turned}, noise=0.05),
            {"sensor.encoder_offset": ("body.link_inertia", "body.gravity_direction")},
        ),
    ],
)
def test_what_bends_and_its_rivals_are_told_of_a_part_too(
    machine: Machine, told: dict[str, tuple[str, ...]], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Their tangents are drawn along the rows of the part, or of the whole, and fit neither the other's."""
    if machine.joints == ("axis",):
        model = tmp_path / "pendulum.xml"
        model.write_text(PENDULUM, encoding="utf-8")
        machine = replace(machine, model=model)
    monkeypatch.setattr(by, "ENOUGH", PART)
    found = diagnosed(write_case(tmp_path, machine, seed=8, seconds=60.0, rate=125.0))
    assert {one.cause: one.alternatives for one in found.findings} == told


def test_what_is_held_in_a_part_is_held_in_the_whole(case: tuple[Path, Path], monkeypatch: pytest.MonkeyPatch) -> None:
    log, robot = case
    gap = thinned(measure_gap(read_log(log), read_robot(robot)))
    monkeypatch.setattr(by, "ENOUGH", PART)
    part = make_nuisance(excerpt(gap), drives=True).without_level(ELBOW).with_level_near(WRIST, (1.8, 1.8), 0.02)
    part = part.with_links_nearer(0.2)
    whole = part.along(gap, ())
    assert [own.site for own in whole.levels] == [own.site for own in part.levels]
    assert [own.near for own in whole.levels] == [own.near for own in part.levels]
    held = slice(part.of_zeros.start, part.of_links.stop)
    np.testing.assert_array_equal(whole.precision[held], part.precision[held])
    assert all(values.shape[0] == gap.chain.time.size for values in whole.columns.values())
    assert whole.without_drives().along(gap, ()).drives == ()
    assert whole.without_zeros().along(gap, ()).zeros == ()
    assert whole.without_links().along(gap, ()).links == ()
