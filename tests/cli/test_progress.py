"""Long work tells a person at a terminal how far it is, and says nothing in a pipe."""

from __future__ import annotations

import os
import pty
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from mjfriction.diagnose.diagnosis import diagnose_log
from mjfriction.diagnose.tell.visible import visible_causes
from mjfriction.identify.comparison import compare_robots
from mjfriction.identify.identification import identify_log
from mjfriction.identify.measure import measure_gap
from mjfriction.identify.protocol import plan_excitation, plan_passes
from mjfriction.plant.machine import run_machine
from mjfriction.plant.motions import sine
from mjfriction.record.readers import read_log
from mjfriction.robot.files import read_robot
from tests.hidden.machine import Machine, write_case


def test_a_run_tells_how_far_it_is() -> None:
    told: list[tuple[str, float | None]] = []
    robot = read_robot("linear_axis")
    run_machine(
        robot, sine("axis", 0.0, 0.05, 0.5, 8.0), 2000.0, tell=lambda step, done=None: told.append((step, done))
    )
    shares = [done for _, done in told]
    assert len(shares) > 2
    assert shares[0] == 0.0
    assert np.all(np.diff(shares) > 0.0)
    assert shares[-1] < 1.0


@pytest.mark.parametrize("verb", ["diagnose", "identify"])
def test_long_work_tells_its_steps(verb: str, tmp_path: Path) -> None:
    log_path, robot_path = write_case(tmp_path, Machine(hidden={2: lambda i: 3.0 * np.abs(i.v)}), seed=2, seconds=12.0)
    log, robot = read_log(log_path), read_robot(robot_path)
    told: list[tuple[str, float | None]] = []

    def tell(step: str, done: float | None = None) -> None:
        told.append((step, done))

    if verb == "diagnose":
        diagnose_log(log, robot, tell=tell)
        assert "searching for causes, 1 so far" in dict(told)
    else:
        identify_log(log, robot, law="coulomb_viscous", tell=tell)
        assert "fitting laws, joint 6 of 6" in dict(told)
    shares = [done for _, done in told]
    assert told[0] == ("measuring the gap", 0.0)
    assert np.all(np.diff(shares) >= 0.0)
    assert 0.5 < shares[-1] < 1.0


def test_what_has_steps_alike_counts_them(tmp_path: Path) -> None:
    log_path, robot_path = write_case(tmp_path, Machine(), seed=2, seconds=8.0)
    log, robot = read_log(log_path), read_robot(robot_path)
    told: list[float | None] = []

    def tell(step: str, done: float | None = None) -> None:
        told.append(done)

    works: tuple[Callable[[], object], ...] = (
        lambda: plan_passes(robot, robot.joints[:3], count=3, tell=tell),
        lambda: plan_excitation(robot, 5.0, tell=tell),
        lambda: compare_robots(log, [("a", robot), ("b", robot), ("c", robot)], tell),
        lambda: visible_causes(measure_gap(log, robot), tell),
    )
    for work in works:
        told.clear()
        work()
        assert len(told) > 2
        np.testing.assert_allclose(told, np.arange(len(told)) / len(told))


def test_a_terminal_sees_the_time_that_is_left(tmp_path: Path) -> None:
    time = np.linspace(0.0, 5.0, 100)
    course = "\n".join(["time,position.axis", *(f"{t:.4f},{0.05 * np.sin(t):.6f}" for t in time)])
    (tmp_path / "motion.csv").write_text(course + "\n")
    words = [
        "simulate",
        "--robot",
        "linear_axis",
        "--trajectory",
        "motion.csv",
        "--out",
        "run.parquet",
        "--rate",
        "2000",
    ]
    command = [sys.executable, "-c", "from mjfriction.cli.main import run; run()", *words]
    screen, terminal = pty.openpty()
    done = subprocess.Popen(command, cwd=tmp_path, stdout=subprocess.DEVNULL, stderr=terminal)
    os.close(terminal)
    seen = b""
    while True:
        try:
            piece = os.read(screen, 4096)
        except OSError:  # the other end is closed
            break
        if not piece:
            break
        seen += piece
    assert done.wait() == 0
    assert b"simulating" in seen
    assert b"left about" in seen
    quiet = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=True)
    assert quiet.stderr == ""
