"""Levels that are off at one joint are no drive that turns with two: the other joint's levels would have to undo it."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pyarrow as pa
import pytest

from mjfriction.diagnose.causes.catalog import STATED_LEVELS
from mjfriction.diagnose.causes.cause import Site
from mjfriction.diagnose.causes.coupling import SumDrive
from mjfriction.diagnose.fit.as_little import leaves_as_little
from mjfriction.diagnose.fit.model import Chosen, Model, build_model
from mjfriction.diagnose.fit.nuisance import make_nuisance
from mjfriction.diagnose.fit.trial import Trial, try_out
from mjfriction.diagnose.settle import stated
from mjfriction.identify.measure import measure_gap
from mjfriction.record.log import Log
from mjfriction.record.readers.table import log_from_table
from mjfriction.robot.files import read_robot
from mjfriction.robot.robot import Robot
from tests.diagnose.test_needless import CARRIAGES, ROBOT

LEVEL, NOISE, RATE = 20.0, 1.0, 250.0
LEGS = 30  # ways of one carriage at a time, x and y by turns


def one_at_a_time(folder: Path, shared: float) -> tuple[Log, Robot]:
    """Return a log of two carriages that move one after the other, and how they are stated: x with friction 12, and y
    without the friction of a ``shared`` drive.
    """
    (folder / "carriages.xml").write_text(CARRIAGES, encoding="utf-8")
    (folder / "robot.toml").write_text(ROBOT, encoding="utf-8")
    rng, going, resting = np.random.default_rng(4), 1.6, 0.3
    time = np.arange(int(LEGS * (going + resting) * RATE)) / RATE
    leg, s = (time // (going + resting)).astype(int), np.clip((time % (going + resting)) / going, 0.0, 1.0)
    columns = {"time": time}
    for number, (joint, mass, friction, damping) in enumerate((("x", 8.0, LEVEL, 4.0), ("y", 3.0, 8.0 + shared, 3.0))):
        ways = np.where(np.arange(LEGS) % 2 == number, rng.uniform(0.1, 0.4, LEGS) * rng.choice([-1, 1], LEGS), 0.0)
        before = np.concatenate([[0.0], np.cumsum(ways)[:-1]])
        q = before[leg] + ways[leg] * s**3 * (10.0 - 15.0 * s + 6.0 * s**2)
        v = ways[leg] * 30.0 * s**2 * (1.0 - s) ** 2 / going
        a = ways[leg] * 60.0 * s * (1.0 - s) * (1.0 - 2.0 * s) / going**2
        columns[f"position.{joint}"] = q
        columns[f"effort.{joint}"] = mass * a + friction * np.sign(v) + damping * v + NOISE * rng.normal(size=s.size)
    return log_from_table(pa.table(columns), "carriages"), read_robot(folder / "robot.toml")


def levels_and_drive(folder: Path, shared: float) -> tuple[Model, Trial, Chosen]:
    """Return a model with the levels of x as stated, these levels as tried in it, and a drive in their place."""
    log, robot = one_at_a_time(folder, shared)
    gap = measure_gap(log, robot, highest=60.0)
    held = build_model(gap, make_nuisance(gap).without_level(0), ())
    own = try_out(held, Chosen(STATED_LEVELS, Site(0)))
    assert own is not None
    return held, own, Chosen(SumDrive(), Site(0, other=1))


@pytest.mark.parametrize("shared", [0.0, LEVEL - 12.0])
def test_a_drive_that_only_one_joint_turns_puts_the_other_joints_level_off(
    shared: float, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Of a drive that turns with both, both levels are as stated, each with its part of the drive's friction."""
    held, own, drive = levels_and_drive(tmp_path, shared)
    assert leaves_as_little(held.with_also(drive), held.with_also(own.chosen), [0])
    rival = try_out(held, drive)
    monkeypatch.setattr(stated, "passing", lambda *_: [rival])
    modest = replace(own, improvement=0.9 * own.improvement)  # so that the drive is ahead
    found = stated._simpler(held, modest, (), bar=0.1)
    assert (found is None) is (shared == 0.0)
    monkeypatch.setattr(stated, "_put_off", lambda *_: False)
    assert stated._simpler(held, modest, (), bar=0.1) == drive
