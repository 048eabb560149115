"""Candidates are screened time and again along one motion."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import NoReturn

import numpy as np
import pytest

from mjfriction.diagnose.causes.asymmetry import Asymmetry
from mjfriction.diagnose.causes.backlash import Backlash
from mjfriction.diagnose.causes.catalog import STRUCTURAL
from mjfriction.diagnose.causes.cause import Cause, Site
from mjfriction.diagnose.causes.delay import JointDelay
from mjfriction.diagnose.causes.elasticity import HardeningElasticity, SwingingElasticity
from mjfriction.diagnose.causes.encoder_offset import EncoderOffset
from mjfriction.diagnose.causes.offset import Offset
from mjfriction.diagnose.fit.exact import usual_nuisance
from mjfriction.diagnose.fit.model import Chosen, Model, build_model
from mjfriction.diagnose.fit.trial import Trial
from mjfriction.diagnose.search import compete, short_list
from mjfriction.diagnose.search.field import make_field
from mjfriction.diagnose.search.short_list import contenders, ranked
from mjfriction.identify import kept
from mjfriction.identify.gap import Gap
from mjfriction.identify.measure import measure_gap
from mjfriction.record.readers import read_log
from mjfriction.robot.files import read_robot
from tests.hidden.machine import Machine, write_case

FEWER = 16_000_000  # numbers; all candidates of six joints are screened by more


@pytest.mark.parametrize("room", [None, FEWER])
def test_all_that_they_are_screened_by_is_made_once(
    room: int | None, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    log, robot = write_case(tmp_path, Machine(), seed=3, seconds=40.0, rate=250.0)
    gap = measure_gap(read_log(log), read_robot(robot), highest=60.0)
    model, field = build_model(gap, usual_nuisance(gap), ()), make_field(gap, STRUCTURAL)
    if room is not None:
        monkeypatch.setattr(kept, "MOST_NUMBERS", room)
    first = ranked(model, field)
    assert first

    def again(*_: object) -> NoReturn:
        raise AssertionError("screened again")

    for cause in {type(entrant.cause) for entrant in field}:
        monkeypatch.setattr(cause, "screening", again)
    if room is None:
        assert ranked(model, field) == first
    else:
        with pytest.raises(AssertionError, match="screened again"):
            ranked(model, field)


def test_a_spring_that_hardens_is_not_screened_where_a_straight_one_gains_nothing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    log, robot = write_case(tmp_path, Machine(), seed=3, seconds=20.0, rate=250.0)
    gap = measure_gap(read_log(log), read_robot(robot), highest=60.0)
    model, springs = build_model(gap, usual_nuisance(gap), ()), (SwingingElasticity(), HardeningElasticity())
    asked = []

    def screened(_: object, gap: Gap, sites: Sequence[Site], every: int) -> NoReturn:
        asked.append(sites[0].joint)
        raise AssertionError("screened")

    monkeypatch.setattr(HardeningElasticity, "screening", screened)
    assert ranked(model, make_field(gap, springs)) == []
    # Alone it is, whatever a straight one would gain.
    with pytest.raises(AssertionError, match="screened"):
        ranked(model, make_field(gap, springs[1:]))
    # So it is where the straight one gains: here the error is all that such a spring makes at one joint.
    lift = next(entrant for entrant in make_field(gap, springs[:1]) if entrant.joint == 1)
    site = lift.sites[4]
    made = site.around * lift.cause.columns(gap, site)[1]
    wrong = replace(gap, residual=gap.residual + np.pad(made, ((0, 0), (1, 4))))
    model = build_model(wrong, usual_nuisance(wrong), ())
    asked.clear()
    with pytest.raises(AssertionError, match="screened"):
        ranked(model, make_field(wrong, springs))
    assert asked == [1]
    # And where it gains but is not physical as it fits: in the place of a spring that hardens, its strength may be that
    # of a stiffer one than it was drawn for.
    monkeypatch.setattr(SwingingElasticity, "admissible", lambda *_: False)
    asked.clear()
    with pytest.raises(AssertionError, match="screened"):
        ranked(model, make_field(wrong, springs))
    assert asked == [1]


def test_what_is_simpler_competes_first() -> None:
    kinds = [type(cause) for cause in STRUCTURAL]
    simpler = {kind: kind.simpler for kind in kinds if kind.simpler is not None}
    assert simpler
    assert all(kinds.index(other) < kinds.index(kind) for kind, other in simpler.items())


def test_what_is_ranked_by_its_own_joint_alone_is_tried_however_it_ranks(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Its rivals are ranked by what the joints before theirs feel too."""
    machine = Machine(sensed={2: lambda at: np.full_like(at.q, -0.02)})
    log, robot = write_case(tmp_path, machine, seed=3, seconds=20.0, rate=250.0)
    gap = measure_gap(read_log(log), read_robot(robot), highest=60.0)
    model, field = build_model(gap, usual_nuisance(gap), ()), make_field(gap, (Backlash(), EncoderOffset()))
    tried: list[tuple[type[Cause], int]] = []
    monkeypatch.setattr(short_list, "SHORT_LIST", 0)
    monkeypatch.setattr(
        short_list, "all_tried", lambda _, choices: tried.extend((type(own.cause), own.site.joint) for own in choices)
    )
    contenders(model, field)
    assert tried == []
    contenders(model, field, 2)
    assert tried == [(Backlash, 2)]


def test_what_was_tried_beside_a_model_is_tried_anew_beside_another_alone(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    # An offset that is refused makes all others compete again beside the same model.
    machine = Machine(hidden={1: lambda at: np.full_like(at.q, 9.0), 2: lambda at: np.full_like(at.q, 5.0)})
    log, robot = write_case(tmp_path, machine, seed=3, seconds=20.0, rate=100.0)
    gap = measure_gap(read_log(log), read_robot(robot))
    field = make_field(gap, (Offset(), Asymmetry()))
    own, proved, tried = short_list._tried, compete.proved, list[tuple[Model, type[Cause], Site]]()

    def noted(model: Model, choice: Chosen) -> Trial | None:
        tried.append((model, type(choice.cause), choice.site))
        return own(model, choice)

    monkeypatch.setattr(short_list, "_tried", noted)
    monkeypatch.setattr(compete, "proved", lambda model, choice: choice.site.joint != 1 and proved(model, choice))
    (found,) = compete.compete(gap, usual_nuisance(gap), field)[0].chosen
    assert (found.cause.name, found.site.joint) == ("drive.offset", 2)
    beside = Counter((id(model), kind, site) for model, kind, site in tried)
    assert set(beside.values()) == {1}
    assert max(Counter((kind, site) for _, kind, site in beside).values()) > 1


def test_a_delay_is_refitted_beside_others_where_it_comes_near_the_best(monkeypatch: pytest.MonkeyPatch) -> None:
    merits = {0: 100.0, 1: 60.0, 2: 20.0, 3: -5.0}
    delays = [Chosen(JointDelay(), Site(joint)) for joint in merits]
    refitted = []

    def refit(_: Model, trial: SimpleNamespace) -> SimpleNamespace:
        refitted.append(trial.chosen.site.joint)
        return SimpleNamespace(chosen=trial.chosen, merit=trial.merit + 50.0)

    monkeypatch.setattr(short_list, "_tried", lambda _, own: SimpleNamespace(chosen=own, merit=merits[own.site.joint]))
    monkeypatch.setattr(short_list, "_bent", refit)
    beside, before = SimpleNamespace(chosen=(Chosen(Offset(), Site(0)),)), short_list.Tried({}, {})
    for _ in range(2):  # once beside the same model
        trials = short_list.all_tried(beside, delays, before)  # type: ignore[arg-type]
        assert [trial.merit for trial in trials] == [150.0, 110.0, 20.0, -5.0]
    assert refitted == [0, 1]
    # Nothing else is in the model whose torques it could act on.
    assert [trial.merit for trial in short_list.all_tried(SimpleNamespace(chosen=()), delays)] == [*merits.values()]  # type: ignore[arg-type]
    # Where the best is far ahead, no other is worth it.
    merits[0] = 1000.0
    short_list.all_tried(beside, delays)  # type: ignore[arg-type]
    assert refitted == [0, 1, 0]
