"""A torque-limited pendulum whose efforts hardly fit its accelerations: what is fitted on simulated motion holds."""

from __future__ import annotations

from pathlib import Path

import pytest

from mjfriction.identify.comparison import compare_robots
from mjfriction.identify.identification import identify_log
from mjfriction.record.merge import merge_logs
from mjfriction.record.readers import read_log
from mjfriction.robot.files import read_robot

SECONDS = 1.0  # of swing at a time
# Of one run every row is 20 ms after the last, of the others the efforts jump by 17 N·m where gravity makes 2.8.


def errors_of(data: Path, runs: tuple[str, ...]) -> list[tuple[float, float, float]]:
    """Return how far the published robot ends up, one by inverse dynamics, and one by simulated motion, twice."""
    folder = data / "pendulum"
    stated = read_robot(folder / "robot.toml")
    log = merge_logs([read_log(folder / f"{run}.parquet") for run in runs])
    inverse = identify_log(log, stated, law="coulomb_viscous").robot
    forward = identify_log(log, stated, law="coulomb_viscous", simulated=SECONDS).robot
    robots = [("stated", stated), ("inverse", inverse), ("forward", forward)]
    unseen = read_log(folder / "ddp.parquet")
    out = []
    for seconds in (SECONDS, 2.0 * SECONDS):
        (joint,) = compare_robots(unseen, robots, simulated=seconds).joints
        published, by_inverse, by_forward = (error.position for error in joint.errors)
        out.append((published, by_inverse, by_forward))
    return out


def test_simulated_motion_tells_what_inverse_dynamics_cannot(data: Path) -> None:
    for published, by_inverse, by_forward in errors_of(data, ("ilqr",)):
        assert by_forward < 0.7 * min(published, by_inverse)


@pytest.mark.deep
def test_simulated_motion_tells_more_than_was_published(data: Path) -> None:
    # Of these two runs inverse dynamics tells as much.
    for published, _, by_forward in errors_of(data, ("direct_collocation", "system_identification")):
        assert by_forward < 0.7 * published
