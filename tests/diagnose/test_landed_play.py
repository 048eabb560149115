"""Landings: where a link is in its play, from when it was let go and when it landed, against the machine in MuJoCo."""

from __future__ import annotations

import numpy as np
import pyarrow as pa
import pytest

from mjfriction.control.servo import Control
from mjfriction.diagnose.causes.backlash import Backlash
from mjfriction.diagnose.causes.landed_play import LandedPlay
from mjfriction.diagnose.diagnosis import diagnose_log
from mjfriction.identify.gap import Gap
from mjfriction.identify.landings import Landings, find_landings
from mjfriction.identify.measure import measure_gap
from mjfriction.plant.machine import Run, log_columns, run_machine
from mjfriction.plant.motions import pick_and_place
from mjfriction.plant.sensors import Recorder
from mjfriction.record.log import Floats, Log
from mjfriction.record.readers.table import log_from_table
from mjfriction.robot.files import read_robot
from mjfriction.robot.schema import Transmission

PAN, PLAY = 0, 0.03
HOME = np.array([0.0, -1.2, 1.4, -0.4, 1.2, 0.0])


def moved(play: float) -> tuple[Log, Run]:
    robot = read_robot("ur5")
    own = robot.table.joint[PAN]
    machine = robot.with_joint(own.model_copy(update={"transmission": Transmission(backlash=play)}))
    places = HOME + np.random.default_rng(4).uniform(-0.8, 0.8, (16, 6))
    course = pick_and_place(robot.joints, places, np.full(6, 1.2), np.full(6, 3.0), rounds=1, dwell=0.2)
    recorder = Recorder(500.0)
    run = run_machine(machine, course, recorder.rate, Control())
    return log_from_table(pa.table(log_columns(machine, course, recorder, run, 0)), "log"), run


def landings_of(gap: Gap, blown: Floats | None = None) -> Landings | None:
    inertia = gap.derivatives[2][:, PAN]
    return find_landings(gap.motion, gap.effort.load[:, PAN], inertia, gap.blown if blown is None else blown, PAN)


@pytest.fixture(scope="module")
def loose() -> tuple[Gap, Run]:
    log, run = moved(PLAY)
    return measure_gap(log, read_robot("ur5"), highest=60.0), run


@pytest.fixture(scope="module")
def tight() -> Gap:
    return measure_gap(moved(0.0)[0], read_robot("ur5"), highest=60.0)


@pytest.mark.deep
def test_the_link_is_where_its_landings_say(loose: tuple[Gap, Run]) -> None:
    gap, run = loose
    landings = landings_of(gap)
    assert landings is not None
    assert landings.play == pytest.approx(PLAY, rel=0.02)
    place = (run.played.position - run.played.link_position)[:, PAN] / (0.5 * PLAY)
    at = np.interp(gap.motion.time, run.time, place)
    off = np.abs(landings.course - at)
    assert np.quantile(off, 0.75) < 0.03
    # The side that the load is on says much less: it is the flights that are timed.
    side = np.abs(np.sign(gap.effort.load[:, PAN]) - at)
    assert np.quantile(side, 0.75) > 1.0


def test_a_joint_without_play_has_no_landings(tight: Gap) -> None:
    assert landings_of(tight) is None


def knocked(gap: Gap, at: Floats) -> Floats:
    # Blows against the side of the load, as a landing's are, at some moments (s).
    rows = np.searchsorted(gap.motion.time, at)
    blown = np.zeros_like(gap.motion.position)
    blown[rows, PAN] = -20.0 * np.sign(gap.effort.load[rows, PAN])
    return blown


def test_knocks_are_no_landings(tight: Gap) -> None:
    time = gap_time(tight)
    assert landings_of(tight, knocked(tight, np.sort(np.random.default_rng(2).uniform(*time, 30)))) is None


def test_blows_that_come_as_late_after_every_turn_of_the_load_are_no_landings(tight: Gap) -> None:
    # As far as a link would have flown until then differs each time.
    slow = tight.motion.low_passed(tight.effort.load[:, PAN], 4.0)
    turns = tight.motion.time[np.flatnonzero(np.diff(np.sign(slow)) != 0.0)]
    turns = turns[np.append(True, np.diff(turns) > 0.4)]
    assert turns.size > 10
    assert landings_of(tight, knocked(tight, turns[:-1] + 0.3)) is None


def gap_time(gap: Gap) -> tuple[float, float]:
    return float(gap.motion.time[0]) + 1.0, float(gap.motion.time[-1]) - 1.0


@pytest.mark.deep
def test_play_is_found_by_its_landings(loose: tuple[Gap, Run], monkeypatch: pytest.MonkeyPatch) -> None:
    log, robot = loose[0].log, read_robot("ur5")
    # Here play is found by the course of the load too, which a link that is shaken from elsewhere does not follow.
    monkeypatch.setattr(Backlash, "sites", lambda self, gap: [])
    diagnosis = diagnose_log(log, robot)
    (finding,) = diagnosis.findings
    assert (finding.cause, finding.joint) == ("drive.backlash", "shoulder_pan_joint")
    assert finding.parameters[0].value == pytest.approx(PLAY, rel=0.05)
    assert "lands with a blow" in finding.evidence
    monkeypatch.setattr(LandedPlay, "sites", lambda self, gap: [])
    assert all(one.gain.reduction < 0.9 * finding.gain.reduction for one in diagnose_log(log, robot).findings)
