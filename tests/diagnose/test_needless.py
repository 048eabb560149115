"""A cause that is not told and is not needed does not stay in the extended robot: elsewhere it would do harm."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from mjfriction.diagnose.causes.cause import Site
from mjfriction.diagnose.causes.coupling import SharedFriction
from mjfriction.diagnose.causes.offset import Offset
from mjfriction.diagnose.causes.spring import Spring
from mjfriction.diagnose.causes.torque_constant import TorqueConstant
from mjfriction.diagnose.fit.extend import extend_robot
from mjfriction.diagnose.fit.model import Chosen, Model, build_model
from mjfriction.diagnose.fit.nuisance import make_nuisance
from mjfriction.diagnose.search.stroke_curve import ALONG_STROKE
from mjfriction.diagnose.settle.stated import Settled
from mjfriction.diagnose.tell import needless
from mjfriction.diagnose.tell.left_over import LeftOver, left_over
from mjfriction.diagnose.tell.needless import spared, told_alone, without_needless
from mjfriction.diagnose.tell.untold import Untold
from mjfriction.identify.colour import NOTHING
from mjfriction.identify.measure import measure_gap
from mjfriction.identify.structure import Structure
from mjfriction.record.readers import read_log
from mjfriction.robot.files import read_robot
from mjfriction.robot.robot import Robot

CARRIAGES = """
<mujoco>
  <worldbody>
    <body name="lower"><joint name="x" type="slide" axis="1 0 0"/><inertial pos="0 0 0" mass="5" diaginertia="1 1 1"/>
      <body name="upper"><joint name="y" type="slide" axis="0 1 0"/><inertial pos="0 0 0" mass="3" diaginertia="1 1 1"/>
      </body>
    </body>
  </worldbody>
</mujoco>
"""
ROBOT = """
name = "carriages"
model = "carriages.xml"
[[joint]]
name = "x"
friction = { law = "coulomb_viscous", parameters = { coulomb = 12.0, viscous = 4.0 } }
[[joint]]
name = "y"
friction = { law = "coulomb_viscous", parameters = { coulomb = 8.0, viscous = 3.0 } }
"""
LEVEL, NOISE, COUPLING = 20.0, 2.0, 6.0


def course(time: np.ndarray, seed: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    rng = np.random.default_rng(seed)
    waves = [(rng.uniform(0.02, 0.08), 2.0 * np.pi * rng.uniform(0.1, 0.7), rng.uniform(0.0, 6.0)) for _ in range(5)]
    phases = [(size, rate, rate * time + begun) for size, rate, begun in waves]
    return (
        np.asarray(sum(size * np.sin(phase) for size, _, phase in phases)),
        np.asarray(sum(size * rate * np.cos(phase) for size, rate, phase in phases)),
        np.asarray(sum(-size * rate**2 * np.sin(phase) for size, rate, phase in phases)),
    )


def written(folder: Path, name: str, seeds: tuple[int, int], *, coupled: bool = False) -> Path:
    # Two carriages with nothing between them but, if so asked, friction of the upper one that enters the lower one.
    rng, time = np.random.default_rng([*seeds, 3]), np.arange(10_000) / 250.0
    columns = {"time": time}
    moved = {joint: course(time, seed) for joint, seed in zip("xy", seeds, strict=True)}
    for joint, mass, level, damping in (("x", 8.0, LEVEL, 4.0), ("y", 3.0, 8.0, 3.0)):
        q, v, a = moved[joint]
        effort = mass * a + level * np.tanh(v / 1e-3) + damping * v + NOISE * rng.normal(size=time.size)
        if coupled and joint == "x":
            effort = effort + COUPLING * np.tanh(moved["y"][1] / 1e-3)
        columns |= {f"position.{joint}": q, f"effort.{joint}": effort}
    pq.write_table(pa.table(columns), folder / name)
    (folder / "carriages.xml").write_text(CARRIAGES, encoding="utf-8")
    (folder / "robot.toml").write_text(ROBOT, encoding="utf-8")
    return folder / name


def with_springs(folder: Path, wandering: float) -> Settled:
    # A load that wanders pulls at the lower carriage, and a spring at the upper one; the model has one at either.
    log = written(folder, "log.parquet", (2, 3))
    table = pq.read_table(log)
    time, position = (table[name].to_numpy() for name in ("time", "position.y"))
    lower = table["position.x"].to_numpy()
    own = {"x": wandering * (course(time, 11)[0] / 0.05 + 6.0 * lower), "y": 150.0 * position}
    for joint, load in own.items():
        place = table.column_names.index(f"effort.{joint}")
        table = table.set_column(place, f"effort.{joint}", pa.array(table[f"effort.{joint}"].to_numpy() + load))
    pq.write_table(table, log)
    gap = measure_gap(read_log(log), read_robot(log.parent / "robot.toml"), highest=60.0)
    springs = tuple(Chosen(Spring(), Site(joint)) for joint in range(2))
    return Settled(build_model(gap, make_nuisance(gap), springs), (), exact=True)


def with_a_coupling(log: Path) -> tuple[Model, Untold]:
    gap = measure_gap(read_log(log), read_robot(log.parent / "robot.toml"), highest=60.0)
    coupling = Chosen(SharedFriction(), Site(0, other=1))
    model = build_model(gap, make_nuisance(gap), (coupling,))
    return model, Untold(frozenset({coupling.key}), {}, model.heldout_residual())


def error(robot: Robot, log: Path) -> float:
    gap = measure_gap(read_log(log), robot, highest=60.0)
    return gap.rms(gap.residual[:, 0], 0)


def test_a_coupling_between_joints_that_only_move_together_leaves_the_level_to_one_of_them(tmp_path: Path) -> None:
    model, untold = with_a_coupling(written(tmp_path, "together.parquet", (1, 1)))
    less = without_needless(Settled(model, ()), untold).model
    apart = written(tmp_path, "apart.parquet", (2, 3))
    assert less.chosen == ()
    assert error(extend_robot(less), apart) < 1.03 * NOISE < 0.5 * error(extend_robot(model), apart)


@pytest.mark.parametrize("told", [False, True])
def test_a_coupling_that_shows_stays_and_so_does_one_that_is_told(told: bool, tmp_path: Path) -> None:
    seeds = (1, 1) if told else (2, 3)
    model, untold = with_a_coupling(written(tmp_path, "log.parquet", seeds, coupled=not told))
    asked = Untold(frozenset(), untold.left, untold.bare) if told else untold
    settled = Settled(model, ())
    assert without_needless(settled, asked) is settled


def test_what_was_untold_beside_a_cause_that_went_stays_untold(tmp_path: Path) -> None:
    model, untold = with_a_coupling(written(tmp_path, "log.parquet", (2, 3), coupled=True))
    settled = Settled(model, ())
    assert left_over(settled).untold.keys == frozenset()
    assert left_over(settled, untold=untold.keys).untold.keys == untold.keys


def test_what_is_no_finding_where_something_is_left_open_does_not_stay(tmp_path: Path) -> None:
    settled = with_springs(tmp_path, 8.0)
    before = left_over(settled)
    (x, y) = settled.model.chosen
    assert [one.joint for one in before.remaining] == ["x"]
    assert before.untold.keys == {x.key}
    kept, over = spared(settled)
    assert kept.model.chosen == (y,)
    assert [one.joint for one in over.remaining] == ["x"]
    # The robot's own lower carriage moves freely on another motion, and the upper one is pulled.
    extended = extend_robot(kept.model)
    assert extended.joint("x").spring.stiffness == 0.0
    assert extended.joint("y").spring.stiffness == pytest.approx(150.0, rel=0.1)
    apart = written(tmp_path, "apart.parquet", (5, 6))
    assert error(extended, apart) < error(extend_robot(settled.model), apart)


def test_what_only_showed_beside_that_goes_too_and_a_curve_stays_told(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A spring spells a curve at x; beside it an offset was a finding.  Drives that are a little off stay."""
    settled = with_springs(tmp_path, 8.0)
    gap, (spring, other) = settled.model.gap, settled.model.chosen
    offset, drive = Chosen(Offset(), Site(0)), Chosen(TorqueConstant(), Site(0))
    both = replace(settled, model=build_model(gap, settled.model.nuisance, (spring, offset, drive, other)))
    before = left_over(both)
    curve, rest = (Structure("x", covariate, 0.5) for covariate in (ALONG_STROKE, NOTHING))

    def found(remaining: tuple[Structure, ...], *untold: Chosen) -> LeftOver:
        keys = frozenset(choice.key for choice in untold)
        return replace(before, remaining=remaining, untold=replace(before.untold, keys=keys))

    monkeypatch.setattr(TorqueConstant, "usual", lambda *_: True)
    later = iter([found((rest,), spring, drive, offset), found((), spring, drive, offset)])
    monkeypatch.setattr(needless, "left_over", lambda _, untold: next(later))
    kept, over = told_alone(both, found((curve,), spring, drive))
    assert kept.model.chosen == (drive, other)
    assert over.remaining == (curve,)
