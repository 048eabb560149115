"""Intervals mean what they say under the right structure; under a wrong one the report says that they do not."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pyarrow as pa
import pytest
from scipy.signal import lfilter

from mjfriction.identify.identification import identify_log
from mjfriction.record.readers.table import log_from_table
from mjfriction.robot.files import read_robot
from tests.deep import deep
from tests.hidden.machine import UR5_COULOMB, UR5_JOINTS, UR5_VISCOUS, Machine, record, robot_toml

ELBOW = 2
LEAST_COVERED = 0.90  # of 95 % intervals


def covered(machine: Machine, logs: int, folder: Path) -> dict[str, np.ndarray]:
    """Whether each interval holds the truth, by parameter (logs, joints)."""
    out = {"coulomb": np.zeros((logs, 6), dtype=bool), "viscous": np.zeros((logs, 6), dtype=bool)}
    for k in range(logs):
        (folder / "robot.toml").write_text(robot_toml(machine, off=0.1, seed=k), encoding="utf-8")
        log = log_from_table(pa.table(record(machine, 900 + k, 25.0)), str(k))
        found = identify_log(log, read_robot(folder / "robot.toml"), law="coulomb_viscous")
        for i, law in enumerate(found.laws):
            for fitted in law.parameters:
                truth = {"coulomb": UR5_COULOMB, "viscous": UR5_VISCOUS}[fitted.name][i]
                out[fitted.name][k, i] = fitted.low <= truth <= fitted.high
    return out


@pytest.mark.parametrize("logs", [3, deep(200)])
def test_intervals_hold_the_truth_as_often_as_they_say(logs: int, tmp_path: Path) -> None:
    held = covered(Machine(noise=0.1), logs, tmp_path)
    for name, own in held.items():
        # So few logs can be unlucky: two standard deviations of a share of 95 %.
        luck = 2.0 * np.sqrt(0.95 * 0.05 / own.size)
        assert np.mean(own) > min(LEAST_COVERED, 0.95 - luck), name
        if logs >= 200:
            assert np.all(np.mean(own, axis=0) > LEAST_COVERED), (name, np.mean(own, axis=0))


def low_passed(rng: np.random.Generator, count: int, rate: float, corner: float) -> np.ndarray:
    """Noise of unit deviation behind a filter of first order."""
    share = np.exp(-2.0 * np.pi * corner / rate)
    noise = lfilter([1.0], [1.0, -share], rng.normal(size=count + 1000))[1000:]
    return np.asarray(noise * np.sqrt(1.0 - share**2))


STRUCTURES: dict[str, tuple[str, dict[str, float], Machine]] = {
    "stribeck": (
        "stribeck",
        {"static": UR5_COULOMB[ELBOW] + 5.0, "stribeck_velocity": 0.15, "stribeck_exponent": 2.0},
        Machine(noise=0.1, hidden={ELBOW: lambda i: 5.0 * np.sign(i.v) * np.exp(-((i.v / 0.15) ** 2))}),
    ),
    "load": (
        "load_dependent",
        {"load": 0.1},
        Machine(noise=0.1, hidden={ELBOW: lambda i: 0.1 * np.abs(i.rigid) * np.sign(i.v)}),
    ),
    "two directions": (
        "asymmetric",
        {
            **{f"coulomb_{way}": UR5_COULOMB[ELBOW] for way in ("positive", "negative")},
            "viscous_positive": UR5_VISCOUS[ELBOW] + 1.0,
            "viscous_negative": UR5_VISCOUS[ELBOW] - 1.0,
        },
        Machine(noise=0.1, hidden={ELBOW: lambda i: np.abs(i.v)}),
    ),
    "coloured noise": ("coulomb_viscous", {}, Machine(noise=0.02)),
}


@pytest.mark.deep
@pytest.mark.parametrize("kind", list(STRUCTURES))
def test_intervals_of_every_structure_hold_the_truth(kind: str, tmp_path: Path) -> None:
    law, own, machine = STRUCTURES[kind]
    truth = {"viscous": UR5_VISCOUS[ELBOW], "coulomb": UR5_COULOMB[ELBOW], **own}
    laws = {name: law if joint == ELBOW else "coulomb_viscous" for joint, name in enumerate(UR5_JOINTS)}
    held: dict[str, list[bool]] = {}
    for k in range(200):
        (tmp_path / "robot.toml").write_text(robot_toml(machine, off=0.1, seed=k), encoding="utf-8")
        columns = record(machine, 2000 + k, 25.0)
        if kind == "coloured noise":
            rng, rate = np.random.default_rng(k), 1.0 / float(np.median(np.diff(columns["time"])))
            for name in UR5_JOINTS:
                effort = columns[f"effort.{name}"]
                columns[f"effort.{name}"] = effort + 0.3 * low_passed(rng, effort.size, rate, 3.0)
        log = log_from_table(pa.table(columns), str(k))
        found = identify_log(log, read_robot(tmp_path / "robot.toml"), law=laws)
        (elbow,) = [one for one in found.laws if one.joint == UR5_JOINTS[ELBOW]]
        for fitted in elbow.parameters:
            held.setdefault(fitted.name, []).append(fitted.low <= truth[fitted.name] <= fitted.high)
    shares = {name: float(np.mean(own)) for name, own in held.items()}
    assert min(shares.values()) > LEAST_COVERED, shares


def test_a_wrong_structure_is_said_where_its_intervals_miss(tmp_path: Path) -> None:
    # Stribeck and load in the machine, Coulomb-viscous fitted: the interval is narrow, and wrong.
    hidden = {ELBOW: lambda i: np.sign(i.v) * (4.0 * np.exp(-((i.v / 0.15) ** 2)) + 0.1 * np.abs(i.rigid))}
    machine = Machine(noise=0.1, hidden=hidden)
    (tmp_path / "robot.toml").write_text(robot_toml(machine, off=0.05), encoding="utf-8")
    log = log_from_table(pa.table(record(machine, 12, 40.0)), "wrong")
    found = identify_log(log, read_robot(tmp_path / "robot.toml"), law="coulomb_viscous")
    trusted = {law.joint: law.trusted for law in found.laws}
    wrong = found.laws[ELBOW]
    viscous = next(fitted for fitted in wrong.parameters if fitted.name == "viscous")
    assert abs(viscous.value - UR5_VISCOUS[ELBOW]) > 2.0 * (viscous.high - viscous.value)
    assert not trusted.pop(wrong.joint)
    assert wrong.structure > 0.1
    assert all(trusted.values())
