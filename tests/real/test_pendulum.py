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


@pytest.mark.parametrize(
    ("runs", "peers"),
    [
        (("ilqr",), ("published", "inverse")),
        # Of these two inverse dynamics tells as much.
        pytest.param(("direct_collocation", "system_identification"), ("published",), marks=pytest.mark.bench),
    ],
)
def test_simulated_motion_tells_what_inverse_dynamics_cannot(
    data: Path, runs: tuple[str, ...], peers: tuple[str, ...]
) -> None:
    folder = data / "pendulum"
    stated = read_robot(folder / "robot.toml")
    log = merge_logs([read_log(folder / f"{run}.parquet") for run in runs])
    inverse = identify_log(log, stated, law="coulomb_viscous").robot
    forward = identify_log(log, stated, law="coulomb_viscous", simulated=SECONDS).robot
    robots = [("stated", stated), ("inverse", inverse), ("forward", forward)]
    unseen = read_log(folder / "ddp.parquet")
    for seconds in (SECONDS, 2.0 * SECONDS):
        (joint,) = compare_robots(unseen, robots, simulated=seconds).joints
        published, by_inverse, by_forward = (error.position for error in joint.errors)
        errors = {"published": published, "inverse": by_inverse}
        assert by_forward < 0.7 * min(errors[peer] for peer in peers)
