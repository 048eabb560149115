"""``compare`` on the manipulator document's motions: Coulomb-viscous, static and dynamic laws against a richer arm."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from mjfriction.identify.comparison import compare_robots
from mjfriction.identify.friction_map import FrictionMap
from mjfriction.identify.map_fit import fit_map
from mjfriction.laws.ambient import ambient
from mjfriction.laws.catalog import find_law
from mjfriction.report.comparison import write_comparison
from mjfriction.reproduce.manipulator.arm import FASTEST, SLOWEST, record, slow_sine, stated_arm, with_laws, work
from mjfriction.robot.robot import Robot
from tests.report.recordings import entities

NAMES = ("coulomb_viscous", "arctan", "lugre_arctan")


def arms(name: str) -> list[tuple[str, Robot]]:
    """The arm with each law: the published one, its statics, and Coulomb-viscous friction fitted to these."""
    robot, values = stated_arm(name), {law: [] for law in NAMES}
    speed = np.geomspace(SLOWEST, FASTEST, 12)
    for joint in robot.table.joint:
        (own,) = joint.friction or ()
        published = {name: own.value(name) for name in own.parameters}
        statics = {name: value for name, value in published.items() if not name.startswith("bristle")}
        law = find_law("arctan")
        friction = law.along(speed, ambient(speed.size), law.pack(statics))
        points = FrictionMap(0, speed, friction, 0.01 * friction, np.zeros(speed.size), np.ones(speed.size))
        values["coulomb_viscous"].append(fit_map(points, find_law("coulomb_viscous"), "joint", 1.0).values)
        values["arctan"].append(statics)
        values["lugre_arctan"].append(published)
    return [(law, with_laws(robot, law, own)) for law, own in values.items()]


@pytest.mark.deep
@pytest.mark.parametrize(
    ("name", "motion"),
    [
        ("comau_ns12", slow_sine),
        ("comau_ns12", work),
        ("comau_nj60", slow_sine),
        ("comau_nj60", work),
    ],
)
def test_laws_of_the_arms_come_out_in_their_order_in_torque_and_in_current(name: str, motion, tmp_path: Path) -> None:
    robots = arms(name)
    log = record(name, motion(stated_arm(name)), seed=10)
    comparison = compare_robots(log, robots)
    assert comparison.best in NAMES[1:]
    better = 0
    for joint in comparison.joints:
        plain, static, dynamic = (error.effort for error in joint.errors)
        assert static < plain, joint.joint
        better += dynamic < plain
        actuator = robots[0][1].joint(joint.joint).actuator
        assert actuator.torque_constant is not None
        for error in joint.errors:
            assert error.current == pytest.approx(error.effort / (actuator.torque_constant * actuator.gear_ratio))
    # Between dwells a bristle's damping (232 N·m·s/rad at the last motor) makes torque of what the encoder rounds.
    assert better >= (6 if motion is slow_sine else 5)
    write_comparison(comparison, tmp_path)
    table = json.loads((tmp_path / "comparison.json").read_text())
    assert [own["joint"] for own in table["joints"]] == list(robots[0][1].joints)
    for own, joint in zip(table["joints"], comparison.joints, strict=True):
        assert own["rms_current"] == pytest.approx([error.current for error in joint.errors])
    page = (tmp_path / "report.html").read_text()
    drawn = entities(tmp_path / "recording.rrd")
    for law in NAMES:
        assert law in page
        for joint in robots[0][1].joints:
            assert any(law in path and joint in path for path in drawn), (law, joint)
