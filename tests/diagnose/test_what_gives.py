"""What gives: play that shows in blows alone, play between flanks that give, and knocks that no cause explains."""

from __future__ import annotations

from dataclasses import replace

import numba
import numpy as np
import pyarrow as pa
import pytest

import mjfriction.diagnose.diagnosis as whole
from mjfriction.diagnose.causes.cause import Site
from mjfriction.diagnose.causes.elasticity import Elasticity
from mjfriction.diagnose.diagnosis import diagnose_log
from mjfriction.diagnose.fit.model import Chosen, build_model
from mjfriction.diagnose.fit.nuisance import make_nuisance
from mjfriction.diagnose.tell import verdict, what_gives
from mjfriction.diagnose.tell.outcome import Diagnosis, Verdict
from mjfriction.diagnose.tell.seen_play import unseen
from mjfriction.identify.bursts import burst_share
from mjfriction.identify.measure import measure_gap
from mjfriction.plant.motions import forward_backward
from mjfriction.record.log import Floats, Log
from mjfriction.record.readers.table import log_from_table
from mjfriction.robot.files import read_robot

ROTOR, CARRIAGE = 6.0e-5 * 628.3185307**2, 60.0  # kg
COULOMB, VISCOUS = 25.0, 180.0
PLAY = 1e-3
# N/m, N·s/m, of the flanks: the carriage swings on them at 92, 36 or 18 Hz.
RIGID, STIFF, SOFT, DAMPING = 2e7, 3e6, 8e5, 1.5e3
RATE = 500.0
STEP = 2e-5  # s
FINE = round(1.0 / (RATE * STEP))


@numba.njit(cache=True)
def _two_masses(
    aim: Floats, speed: Floats, push: Floats, play: float, stiffness: float, damping: float
) -> tuple[Floats, Floats]:
    """Return the sensor's position and the drive's force of a motor and a carriage with play between them.

    Motor: m₁·dv/dt = u − F_c·tanh(v/v₀) − F_v·v − f; carriage: m₂·dw/dt = f + push, with f = k·e + d·ė beyond either
    flank and 0 between them. u follows an aim by a stiff servo.
    """
    position, force = np.empty(aim.size // FINE), np.empty(aim.size // FINE)
    x, v, y, w = aim[0], 0.0, aim[0], 0.0
    for i in range(FINE * position.size):
        u = 4e5 * (aim[i] - x) + 8e3 * (speed[i] - v)
        apart, between = x - y, 0.0
        if abs(apart) > 0.5 * play:
            beyond = apart - np.sign(apart) * 0.5 * play
            between = stiffness * beyond + damping * (v - w)
            between = max(between, 0.0) if apart > 0.0 else min(between, 0.0)
        v += STEP * (u - COULOMB * np.tanh(v / 2e-4) - VISCOUS * v - between) / ROTOR
        w += STEP * (between + push[i]) / CARRIAGE
        x, y = x + STEP * v, y + STEP * w
        if i % FINE == 0:
            position[i // FINE], force[i // FINE] = x, u
    return position, force


def moves(play: float, stiffness: float, knocks: int = 0, push: float = 0.0, lasting: float = 0.0) -> Log:
    """Return a log of short moves, with knocks against the carriage while it moves: each swells to a push, N, and is
    over after a while, s.
    """
    speeds, rng = [0.1, 0.25, 0.4] * 4, np.random.default_rng(5)
    course = forward_backward("axis", -0.2, 0.25, speeds, 2.0, dwell=0.4)
    fine = np.arange(0.0, course.time[-1], STEP)
    aim = np.interp(fine, course.time, course.position[:, 0])
    aim = np.convolve(np.pad(aim, (1000, 1000), mode="edge"), np.full(2001, 1.0 / 2001), mode="valid")  # 40 ms
    speed, pushed, count = np.gradient(aim, STEP), np.zeros_like(aim), round(lasting / STEP)
    moving = np.flatnonzero(np.abs(speed) > 0.09)
    for at in rng.choice(moving[: -count - 1], knocks, replace=False):
        pushed[at : at + count] = push * rng.choice([-1.0, 1.0]) * np.hanning(count)
    position, force = _two_masses(aim, speed, pushed, play, stiffness, DAMPING)
    columns = {
        "time": np.arange(position.size) / RATE,
        "position.axis": position + 2e-7 * rng.standard_normal(position.size),
        "effort.axis": force + 2.5 * rng.standard_normal(position.size),
    }
    return log_from_table(pa.table(columns), "moves")


def found(diagnosis: Diagnosis) -> list[tuple[str, str | None]]:
    return [(finding.cause, finding.joint) for finding in diagnosis.findings]


@pytest.mark.deep
def test_play_that_a_first_search_leaves_is_found_by_a_second(monkeypatch: pytest.MonkeyPatch) -> None:
    """The flanks give, by up to a third of the play.  The second search is told as a step forward."""
    log, robot = moves(3e-4, STIFF), read_robot("linear_axis")
    told: dict[str, float] = {}
    diagnosis = diagnose_log(log, robot, tell=lambda step, done=0.0: told.update({step: float(done or 0.0)}))
    assert found(diagnosis) == [("drive.backlash", "axis")]
    assert "searching for what gives" in told
    assert np.all(np.diff(list(told.values())) > 0.0)
    assert diagnosis.findings[0].parameters[0].value == pytest.approx(3e-4, rel=0.2)
    monkeypatch.setattr(whole, "doubt", lambda *_: None)
    once = diagnose_log(log, robot)
    assert (found(once), once.verdict) == ([], Verdict.UNEXPLAINED)


def test_play_that_shows_in_landings_of_few_rows_is_found() -> None:
    (finding,) = diagnose_log(moves(1e-3, STIFF), read_robot("linear_axis")).findings
    assert finding.cause == "drive.backlash"
    assert finding.parameters[0].value == pytest.approx(1e-3, rel=0.2)


def test_a_joint_that_blows_hid_is_compared_with_what_is_stated_of_it() -> None:
    """As where every row of a joint holds a blow: nothing was examined there before."""
    seen = unseen(measure_gap(moves(1e-3, STIFF), read_robot("linear_axis"), highest=60.0))
    model = build_model(seen.gap, make_nuisance(seen.gap), ())
    doubted = whole.doubt(replace(seen, stated=np.full_like(seen.stated, np.nan)), model, 60.0)
    assert doubted is not None
    np.testing.assert_array_equal(doubted.seen.stated, doubted.seen.gap.residual)


def test_a_joint_that_gives_next_to_nothing_is_not_searched_again(monkeypatch: pytest.MonkeyPatch) -> None:
    """What is left of it, a slow sway, is not what gives."""
    log = moves(0.0, RIGID)
    sway = 20.0 * np.sin(2.0 * np.pi * 0.31 * log.time)
    swayed = replace(log, columns={**log.columns, "effort.axis": log.columns["effort.axis"] + sway})
    seen = unseen(measure_gap(swayed, read_robot("linear_axis"), highest=60.0))
    model = build_model(seen.gap, make_nuisance(seen.gap), (Chosen(Elasticity(), Site(0)),))
    assert whole.doubt(seen, model, 60.0) is None
    monkeypatch.setattr(what_gives, "stands_out", lambda *_: True)
    doubted = whole.doubt(seen, model, 60.0)
    assert doubted is not None
    assert doubted.joints == (0,)


@pytest.mark.deep
def test_play_between_flanks_that_give_is_found_with_what_they_give(monkeypatch: pytest.MonkeyPatch) -> None:
    log, robot = moves(2e-4, SOFT), read_robot("linear_axis")
    (finding,) = diagnose_log(log, robot).findings
    play, damping, compliance = finding.parameters
    assert (finding.cause, damping.name) == ("drive.backlash", "damping_ratio")
    assert play.value == pytest.approx(2e-4, rel=0.1)
    assert compliance.value == pytest.approx(1.0 / SOFT, rel=0.1)
    monkeypatch.setattr(whole, "doubt", lambda *_: None)
    assert "drive.backlash" not in [cause for cause, _ in found(diagnose_log(log, robot))]


def test_knocks_are_left_as_an_error_and_a_quiet_machine_has_none() -> None:
    robot = read_robot("linear_axis")
    knocked = diagnose_log(moves(0.0, RIGID, 12, 1500.0, 0.01), robot)
    quiet = diagnose_log(moves(0.0, RIGID), robot)
    assert (knocked.verdict, quiet.verdict) == (Verdict.UNEXPLAINED, Verdict.CONSISTENT)
    assert not found(knocked)
    assert "in blows, as something makes that lands or knocks" in knocked.summary


def test_bursts_are_left_as_an_error(monkeypatch: pytest.MonkeyPatch) -> None:
    """Softer pushes are no blows, and over in a few rows: what is left follows nothing that is known."""
    log, robot = moves(0.0, RIGID, 12, 60.0, 0.08), read_robot("linear_axis")
    diagnosis = diagnose_log(log, robot)
    assert not found(diagnosis)
    assert diagnosis.verdict is Verdict.UNEXPLAINED
    assert "are in bursts, each soon over" in diagnosis.summary
    monkeypatch.setattr(verdict, "burst_share", lambda *_: 0.0)
    assert diagnose_log(log, robot).verdict is Verdict.CONSISTENT


def test_bursts_are_what_no_noise_has() -> None:
    gap, rng = measure_gap(moves(0.0, RIGID), read_robot("linear_axis")), np.random.default_rng(0)
    noise, clear = gap.noise_floor * rng.standard_normal(gap.residual.shape), gap.clear[:, 0]
    assert burst_share(gap, 0, 1.5 * noise) == 0.0
    amid = np.flatnonzero(np.convolve(clear, np.ones(5), mode="same") == 5.0)[::60]
    burst = noise.copy()
    burst[amid] = 20.0 * gap.noise_floor
    made = 20.0**2 * amid.size
    assert burst_share(gap, 0, burst) == pytest.approx(made / (made + np.count_nonzero(clear)), rel=0.1)
    burst[amid[4:]] = 0.0
    assert burst_share(gap, 0, burst) == 0.0  # accidents
    edges = np.flatnonzero(clear[1:] & ~clear[:-1]) + 1
    burst = noise.copy()
    burst[edges] = 20.0 * gap.noise_floor
    assert burst_share(gap, 0, burst) == 0.0  # what reversals leave
