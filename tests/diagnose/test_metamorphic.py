"""What must not change a finding: names, order, units, zero of the clock, segments, mirror; what must not lose one."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet
import pytest

from mjfriction.diagnose.diagnosis import diagnose_log
from mjfriction.diagnose.tell.outcome import Diagnosis
from mjfriction.record.mapping import read_mapping
from mjfriction.record.readers import read_log
from mjfriction.record.readers.table import log_from_table
from mjfriction.robot.files import read_robot
from tests.deep import deep
from tests.hidden.machine import UR5, UR5_JOINTS, Instant, Machine, multisine, record, robot_toml

Columns = dict[str, np.ndarray]
ELBOW = 2
SECONDS = 24.0


def fading(i: Instant) -> np.ndarray:
    return 3.0 * np.sign(i.v) * np.exp(-((i.v / 0.15) ** 2))


def bump(i: Instant) -> np.ndarray:
    return 1.5 * np.cos(9.0 * i.q)


def columns_of(effect: Callable[[Instant], np.ndarray], noise: float = 0.1) -> Columns:
    return record(Machine(hidden={ELBOW: effect}, noise=noise), seed=21, seconds=SECONDS)


def diagnosed(columns: Columns, toml: str, folder: Path) -> Diagnosis:
    (folder / "robot.toml").write_text(toml, encoding="utf-8")
    return diagnose_log(log_from_table(pa.table(columns), "log"), read_robot(folder / "robot.toml"))


def named(diagnosis: Diagnosis) -> set[tuple[str, str | None]]:
    return {(finding.cause, finding.joint) for finding in diagnosis.findings}


def values(diagnosis: Diagnosis) -> dict[str, float]:
    return {fitted.name: fitted.value for fitted in diagnosis.findings[0].parameters}


def shifted(columns: Columns) -> Columns:
    return {**columns, "time": columns["time"] + 1.0e3}


def reordered(columns: Columns) -> Columns:
    return dict(reversed(columns.items()))


def in_segments(columns: Columns) -> Columns:
    return {**columns, "segment": (columns["time"] // 8.0).astype(np.int64)}


@pytest.mark.deep
@pytest.mark.parametrize("effect", [fading, bump], ids=["stribeck", "cogging"])
@pytest.mark.parametrize("change", [shifted, reordered, in_segments])
def test_the_same_log_told_otherwise_gives_the_same_finding(
    change: Callable[[Columns], Columns], effect: Callable[[Instant], np.ndarray], tmp_path: Path
) -> None:
    columns, toml = columns_of(effect), robot_toml(Machine())
    before, after = (diagnosed(own, toml, tmp_path) for own in (columns, change(columns)))
    assert named(before) == named(after) == {(before.findings[0].cause, "elbow_joint")}
    for one, other in zip(before.findings[0].parameters, after.findings[0].parameters, strict=True):
        # Segments cost the ends of every piece; the others leave every number as it was.
        half = 0.5 * (one.high - one.low)
        assert other.value == pytest.approx(one.value, rel=1e-6, abs=half if change is in_segments else 1e-9)


@pytest.mark.deep
def test_other_names_give_the_same_finding(tmp_path: Path) -> None:
    columns, toml, model = columns_of(fading), robot_toml(Machine()), UR5.read_text(encoding="utf-8")
    renamed = dict(zip(UR5_JOINTS, ("a1", "a2", "a3", "b1", "b2", "b3"), strict=True))
    for old, new in renamed.items():
        toml, model = toml.replace(f'"{old}"', f'"{new}"'), model.replace(f'name="{old}"', f'name="{new}"')
    (tmp_path / "other.urdf").write_text(model, encoding="utf-8")
    toml = toml.replace(str(UR5), "other.urdf")
    other = {}
    for name, own in columns.items():
        quantity, dot, joint = name.partition(".")
        other[quantity + dot + renamed.get(joint, joint)] = own
    after = diagnosed(other, toml, tmp_path)
    assert named(after) == {("friction.stribeck", "a3")}
    before = diagnosed(columns, robot_toml(Machine()), tmp_path)
    assert values(after) == pytest.approx(values(before), rel=1e-6)


def test_the_order_of_joints_in_the_robot_file_does_not_matter(tmp_path: Path) -> None:
    columns, toml = columns_of(fading), robot_toml(Machine())
    head, *joints = toml.split("[[joint]]")
    turned = head + "".join("[[joint]]" + joint for joint in reversed(joints))
    before, after = (diagnosed(columns, own, tmp_path) for own in (toml, turned))
    assert named(before) == named(after) == {("friction.stribeck", "elbow_joint")}
    # Each of the two is searched to a hundredth of a step of a tenth.
    assert values(after) == pytest.approx(values(before), rel=2e-3)


@pytest.mark.deep
def test_other_units_at_the_border_give_the_same_finding(tmp_path: Path) -> None:
    columns, toml = columns_of(fading), robot_toml(Machine())
    units = {"time": 1e-3, "position": np.pi / 180.0, "effort": 1e-3}  # ms, degrees, mN·m
    foreign = {f"x{i}": values / units[name.partition(".")[0]] for i, (name, values) in enumerate(columns.items())}
    pyarrow.parquet.write_table(pa.table(foreign), tmp_path / "log.parquet")
    lines = [
        f'"{name}" = {{ column = "x{i}", scale = {units[name.partition(".")[0]]!r} }}' for i, name in enumerate(columns)
    ]
    (tmp_path / "columns.toml").write_text("\n".join(lines), encoding="utf-8")
    (tmp_path / "robot.toml").write_text(toml, encoding="utf-8")
    log = read_log(tmp_path / "log.parquet", read_mapping(tmp_path / "columns.toml"))
    before, after = diagnosed(columns, toml, tmp_path), diagnose_log(log, read_robot(tmp_path / "robot.toml"))
    assert named(before) == named(after) == {("friction.stribeck", "elbow_joint")}
    assert values(after) == pytest.approx(values(before), rel=1e-6)


@pytest.mark.deep
def test_the_mirrored_motion_gives_the_same_finding(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    before = diagnosed(columns_of(fading), robot_toml(Machine()), tmp_path)

    def mirrored(*words: float) -> tuple[np.ndarray, ...]:
        time, *course = multisine(*words)
        return (time, *(-one for one in course))

    monkeypatch.setattr("tests.hidden.machine.multisine", mirrored)
    after = diagnosed(columns_of(fading), robot_toml(Machine()), tmp_path)
    assert named(before) == named(after) == {("friction.stribeck", "elbow_joint")}
    assert values(after)["stribeck_excess"] == pytest.approx(values(before)["stribeck_excess"], rel=0.05)


@pytest.mark.deep
def test_less_noise_never_loses_a_finding(tmp_path: Path) -> None:
    for noise in (0.3, 0.03, 0.0):
        found = diagnosed(columns_of(fading, noise), robot_toml(Machine()), tmp_path)
        assert named(found) == {("friction.stribeck", "elbow_joint")}, noise


@pytest.mark.parametrize("seed", [0, *(deep(seed) for seed in range(1, 20))])
def test_a_clean_log_has_no_finding_whatever_the_seed(seed: int, tmp_path: Path) -> None:
    rng = np.random.default_rng(seed)
    machine = Machine(
        noise=float(rng.choice([0.05, 0.2])),
        encoder_bits=int(rng.choice([15, 17, 19])),
        velocity=str(rng.choice(["none", "noisy"])),
        bristle_travel=float(rng.choice([0.0, 3e-4])),
        pauses=bool(rng.random() < 0.5),
    )
    rate = float(rng.choice([120.0, 250.0]))
    columns = record(machine, seed=500 + seed, seconds=30.0, rate=rate)
    off = float(rng.choice([0.0, 0.03]))
    assert named(diagnosed(columns, robot_toml(machine, off=off, seed=seed), tmp_path)) == set()
