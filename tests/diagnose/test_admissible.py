"""What nature does not allow explains nothing, however well it fits."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from mjfriction.body.regressor import tip_mass
from mjfriction.diagnose.causes.cause import Site
from mjfriction.diagnose.causes.coupling import DifferenceDrive, DifferenceRotor, SumDrive
from mjfriction.diagnose.causes.elasticity import Elasticity
from mjfriction.diagnose.causes.payload import Payload
from mjfriction.diagnose.causes.varying import Step, WarmUpDrift
from mjfriction.identify.gap import Gap
from mjfriction.identify.measure import measure_gap
from mjfriction.record.readers import read_log
from mjfriction.robot.body_tables import Payload as PayloadTable
from mjfriction.robot.files import read_robot
from tests.hidden.machine import UR5_COULOMB, UR5_VISCOUS, Machine, write_case

LIFT, ELBOW = 1, 2


@pytest.fixture(scope="module")
def gap(tmp_path_factory: pytest.TempPathFactory) -> Gap:
    log, robot = write_case(tmp_path_factory.mktemp("case"), Machine(), seed=12, seconds=25.0)
    return measure_gap(read_log(log), read_robot(robot))


def test_a_shared_drive_does_not_push_its_joints(gap: Gap) -> None:
    site = Site(LIFT, (1.0,), other=ELBOW)
    for drive in (SumDrive(), DifferenceDrive()):
        assert drive.admissible(gap, site, np.array([2.0, 0.5]))
        assert not drive.admissible(gap, site, np.array([-2.0, 0.5]))
        assert not drive.admissible(gap, site, np.array([0.5, -5.0]))
    assert DifferenceRotor().admissible(gap, site, np.array([2.0, 0.5, 0.1]))
    assert not DifferenceRotor().admissible(gap, site, np.array([2.0, 0.5, -0.1]))


def test_of_a_shared_drive_that_is_stated_there_may_be_less(gap: Gap) -> None:
    site = Site(LIFT, (1.0,), other=ELBOW)
    shared = SumDrive().extend(gap.robot, site, np.array([2.0, 0.5]))
    assert SumDrive().admissible(replace(gap, robot=shared), site, np.array([-1.5, -0.4]))
    assert not SumDrive().admissible(replace(gap, robot=shared), site, np.array([-2.5, -0.6]))


def test_a_drive_that_is_stated_turns_as_it_is_stated_to(gap: Gap) -> None:
    site = Site(LIFT, (0.6,), other=ELBOW)
    stated = replace(gap, robot=DifferenceDrive().extend(gap.robot, site, np.array([2.0, 0.5])))
    (there,) = [own for own in DifferenceDrive().sites(stated) if own.shape]
    assert there == site
    # Less than is stated of it, but not of one that turns otherwise.
    less = np.array([-1.5, -0.4])
    assert DifferenceDrive().admissible(stated, there, less)
    assert not DifferenceDrive().admissible(stated, replace(there, shape=()), less)
    assert not [own for own in SumDrive().sites(stated) if own.shape]


def test_a_slide_and_a_turn_share_no_drive(gap: Gap) -> None:
    pairs = {(site.joint, site.other) for site in SumDrive().sites(gap)}
    assert pairs == {(i, i + 1) for i in range(5)}
    sliding = tuple(i == ELBOW for i in range(6))
    mixed = replace(gap, body=replace(gap.body, sliding=sliding))
    assert {(site.joint, site.other) for site in SumDrive().sites(mixed)} == pairs - {(1, 2), (2, 3)}


@pytest.mark.parametrize("course", [Step(), WarmUpDrift()])
def test_friction_rises_or_falls_at_all_speeds(course: Step | WarmUpDrift, gap: Gap) -> None:
    fast = float(gap.motion.top_speed[ELBOW])
    site = Site(ELBOW, shape=(10.0,))
    assert course.one_way(gap, site, np.array([-1.0, -0.5]))
    assert course.one_way(gap, site, np.array([1.0, -0.5 / fast]))  # less damping as the level rises: grease that ages
    assert not course.one_way(gap, site, np.array([-1.0, 4.0 / fast]))


@pytest.mark.parametrize("course", [Step(), WarmUpDrift()])
def test_friction_changes_by_a_few_times_what_it_is(course: Step | WarmUpDrift, gap: Gap) -> None:
    site = Site(ELBOW, shape=(8.0,))
    extent = float(np.ptp(course.course(gap, site)))
    fast = float(np.quantile(np.abs(gap.at_rows("velocity")[gap.clear[:, ELBOW], ELBOW]), 0.9))
    stated = UR5_COULOMB[ELBOW] + UR5_VISCOUS[ELBOW] * fast
    for way in (np.array([1.0, 0.0]), np.array([0.0, 1.0 / fast])):
        assert course.admissible(gap, site, 3.9 * stated / extent * way)
        assert not course.admissible(gap, site, -4.1 * stated / extent * way)
    level = gap.robot.table.joint[ELBOW].friction[0].model_copy(update={"parameters": {"coulomb": 0.0, "viscous": 0.0}})
    frictionless = gap.robot.table.joint[ELBOW].model_copy(update={"friction": (level,)})
    bare = replace(gap, robot=gap.robot.with_joint(frictionless))
    assert course.admissible(bare, site, np.array([9.0 * stated, 0.0]))  # nothing is said of how much there is


@pytest.mark.parametrize("course", [Step(), WarmUpDrift()])
def test_a_change_over_time_shows_at_alike_speeds(course: Step | WarmUpDrift, gap: Gap) -> None:
    site = Site(ELBOW, shape=(12.5,))
    along = np.interp(gap.chain.time, gap.motion.time, course.course(gap, site))
    late = along > 0.5 * np.max(along)
    speed = np.abs(gap.at_rows("velocity")[:, ELBOW])
    change = np.array([0.3 * UR5_COULOMB[ELBOW], 0.0])
    clear = gap.clear[:, ELBOW]
    creeps = np.flatnonzero(late & clear & (speed < 0.15 * np.median(speed)))
    quick = np.flatnonzero(late & clear & (speed > np.median(speed)))
    for share, told in ((0.0, False), (0.15, False), (0.4, True)):
        # So much of its late motion the joint is quick, and it creeps else.
        kept = np.concatenate([creeps, quick[: round(creeps.size * share / (1.0 - share))]])
        moves = gap.clear.copy()
        moves[:, ELBOW] &= ~late | np.isin(np.arange(speed.size), kept)
        assert course.admissible(replace(gap, clear=moves), site, change) is told
    assert course.admissible(gap, site, change)


def test_a_few_grams_at_the_flange_are_the_last_links_own(gap: Gap) -> None:
    mass, centre = tip_mass(gap.body)
    held, site = Payload(), Site(LIFT)
    for share, moved, told, usual in (
        (0.015, 0.0, False, True),
        (0.05, 0.0, True, True),
        (0.09, 0.0, True, False),
        (0.0, 0.003, False, True),
        (0.0, 0.005, True, True),
        (0.0, 0.011, True, False),
    ):
        first = (1.0 + share) * mass * (centre + np.array([0.0, moved, 0.0])) - mass * centre
        strengths = np.array([share * mass, *first])
        assert held.noteworthy(gap, site, strengths) is told
        assert held.usual(gap, site, strengths) is usual


def test_a_load_that_is_stated_is_no_part_of_the_last_link_where_all_else_is_exact(gap: Gap) -> None:
    held = PayloadTable(mass=2.0, com=(0.0, 0.0, 0.1), parent="wrist_3_link")
    robot = replace(gap.robot, table=gap.robot.table.model_copy(update={"payload": held}))
    loaded = replace(gap, robot=robot, body=robot.body())
    (mass, centre), site = tip_mass(gap.body), Site(LIFT)
    more = 0.05 * mass * np.array([1.0, *centre])
    assert Payload().noteworthy(loaded, site, more)
    assert Payload().usual(loaded, site, 2.0 * more)
    assert not Payload().usual(gap, site, 2.0 * more)


def test_a_series_elastic_joint_gives_by_a_quarter_of_a_radian(gap: Gap) -> None:
    load = np.max(np.abs(Elasticity().load(gap, ELBOW)))
    assert Elasticity().admissible(gap, Site(ELBOW), np.array([0.25 / load]))
    assert not Elasticity().admissible(gap, Site(ELBOW), np.array([0.5 / load]))
