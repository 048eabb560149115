"""A spring that is no more than an offset, once all else is settled, is told as one; and a straight one as straight."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from mjfriction.diagnose.causes.catalog import STRUCTURAL
from mjfriction.diagnose.causes.cause import Cause, Site
from mjfriction.diagnose.causes.offset import Offset
from mjfriction.diagnose.causes.spring import BentSpring, Spring
from mjfriction.diagnose.fit.model import Chosen, build_model
from mjfriction.diagnose.fit.nuisance import make_nuisance
from mjfriction.diagnose.search.field import make_field
from mjfriction.diagnose.settle import as_plain as module
from mjfriction.diagnose.settle.as_plain import as_plain
from mjfriction.identify.measure import measure_gap
from mjfriction.record.readers import read_log
from mjfriction.robot.files import read_robot
from tests.hidden.machine import Instant, Machine, write_case

ELBOW = 2
COURSES: dict[type[Cause], Callable[[Instant], np.ndarray]] = {
    Offset: lambda at: np.full_like(at.q, 3.0),
    Spring: lambda at: 3.0 + 4.0 * at.q,
    BentSpring: lambda at: 3.0 + 4.0 * at.q + 3.0 * at.q**3,
}


@pytest.mark.parametrize("hidden", COURSES)
@pytest.mark.parametrize("chosen", [Spring, BentSpring])
def test_of_causes_that_contain_each_other_the_plainest_that_leaves_as_little_is_told(
    hidden: type[Cause], chosen: type[Cause], tmp_path: Path
) -> None:
    log, robot = write_case(tmp_path, Machine(hidden={ELBOW: COURSES[hidden]}), seed=3, seconds=30.0)
    gap = measure_gap(read_log(log), read_robot(robot))
    found = build_model(gap, make_nuisance(gap), (Chosen(chosen(), Site(ELBOW)),))
    (left,) = as_plain(found, make_field(gap, STRUCTURAL)).chosen
    plainest = next(kind for kind in COURSES if kind in (hidden, chosen))
    assert type(left.cause) is plainest


@pytest.mark.parametrize(("constant", "told"), [(3.0, Offset), (0.3, Spring)])
def test_a_usual_error_that_follows_the_pose_beside_an_offset_is_a_small_part_of_it(
    constant: float, told: type[Cause], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def course(at: Instant) -> np.ndarray:
        return constant + 0.6 * at.q + 0.3 * np.sin(61.0 * at.q)

    log, robot = write_case(tmp_path, Machine(hidden={ELBOW: course}, noise=0.01), seed=3, seconds=30.0)
    gap = measure_gap(read_log(log), read_robot(robot))
    found, asked = build_model(gap, make_nuisance(gap), (Chosen(Spring(), Site(ELBOW)),)), make_field(gap, STRUCTURAL)
    (left,) = as_plain(found, asked).chosen
    assert type(left.cause) is told
    monkeypatch.setattr(module, "PART", 0.0)
    (left,) = as_plain(found, asked).chosen
    assert type(left.cause) is Spring


@pytest.mark.parametrize(("rippling", "told"), [(0.0, Spring), (0.6, Offset)])
def test_the_pull_of_a_cable_beside_an_offset_is_one_of_many_small_errors(
    rippling: float, told: type[Cause], tmp_path: Path
) -> None:
    # Ripple as every gear has some, of periods that no cause describes, leaves more than the cable pulls.
    def course(at: Instant) -> np.ndarray:
        return 3.0 + 0.6 * at.q + rippling * (np.sin(61.0 * at.q) + np.sin(43.0 * at.q) * np.sign(at.v))

    log, robot = write_case(tmp_path, Machine(hidden={ELBOW: course}, noise=0.01), seed=3, seconds=30.0)
    gap = measure_gap(read_log(log), read_robot(robot))
    found = build_model(gap, make_nuisance(gap), (Chosen(Spring(), Site(ELBOW)),))
    (left,) = as_plain(found, make_field(gap, STRUCTURAL)).chosen
    assert type(left.cause) is told
