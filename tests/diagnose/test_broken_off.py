"""A search that came to more causes than can be true is not made again and again."""

from __future__ import annotations

from pathlib import Path

import pytest

from mjfriction.diagnose.causes.catalog import STRUCTURAL
from mjfriction.diagnose.causes.cause import Site
from mjfriction.diagnose.causes.presliding import SlippingElements
from mjfriction.diagnose.causes.spring import Spring
from mjfriction.diagnose.fit.exact import usual_nuisance
from mjfriction.diagnose.fit.model import Chosen, Model
from mjfriction.diagnose.search import compete as compete_module
from mjfriction.diagnose.search.compete import compete
from mjfriction.diagnose.search.field import make_field
from mjfriction.identify.measure import measure_gap
from mjfriction.identify.tone import Tone
from mjfriction.record.readers import read_log
from mjfriction.robot.files import read_robot
from tests.hidden.machine import Machine, write_case

ELBOW, WRIST = 2, 4


def two_springs() -> dict[int, object]:
    return {ELBOW: lambda at: 8.0 * at.q, WRIST: lambda at: 2.0 * at.q}


@pytest.mark.deep
@pytest.mark.parametrize(("most", "searches"), [(1, 2), (12, 4)])
def test_it_is_made_anew_once_beside_what_is_heard(
    most: int, searches: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    log, robot = write_case(tmp_path, Machine(hidden=two_springs()), seed=4, seconds=20.0)
    gap = measure_gap(read_log(log), read_robot(robot), highest=60.0)
    tones = iter([[Tone(ELBOW, 7.0)], [Tone(WRIST, 9.0)]])
    refused: list[Chosen] = []

    def refuse_one(model: Model) -> list[Chosen]:
        if refused:
            return []
        refused.append(model.chosen[0])
        return refused

    forward, made = compete_module._forward, []
    monkeypatch.setattr(compete_module, "MOST_CAUSES", most)
    monkeypatch.setattr(compete_module, "new_oscillations", lambda _: next(tones, []))
    monkeypatch.setattr(compete_module, "refused", refuse_one)
    monkeypatch.setattr(compete_module, "exchanged", lambda *_: None)
    monkeypatch.setattr(compete_module, "_forward", lambda *given: made.append(given) or forward(*given))
    model, _ = compete(gap, usual_nuisance(gap), make_field(gap, STRUCTURAL))
    assert len(made) == searches
    assert most > 1 or model.chosen == (), "what is refused is dropped, and none looked for in its place"


def test_a_form_that_does_not_compete_is_dropped_and_not_refused_for_ever(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A field that does not name it cannot be narrowed by it: the same search would find it, and refuse it, again."""
    log, robot = write_case(tmp_path, Machine(hidden={ELBOW: two_springs()[ELBOW]}), seed=4, seconds=15.0)
    gap = measure_gap(read_log(log), read_robot(robot), highest=60.0)
    field = make_field(gap, (Spring(),))
    slipping = Chosen(SlippingElements(), Site(WRIST, (1e-3, 3e-3)))
    made = 0

    def refuse_it(_: Model) -> list[Chosen]:
        nonlocal made
        made += 1
        assert made < 3, "the same search is made again and again"
        return [slipping]

    monkeypatch.setattr(compete_module, "refused", refuse_it)
    model, left = compete(gap, usual_nuisance(gap), field)
    assert left == field
    assert [choice.cause.name for choice in model.chosen] == ["body.spring"]


def test_a_search_that_goes_round_ends(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    log, robot = write_case(tmp_path, Machine(hidden={ELBOW: two_springs()[ELBOW]}), seed=4, seconds=15.0)
    gap = measure_gap(read_log(log), read_robot(robot), highest=60.0)
    field, made = make_field(gap, (Spring(),)), 0
    tones = [Tone(joint, 7.0 + joint) for joint in range(6)]

    def one_more(_: Model) -> list[Tone]:
        nonlocal made
        made += 1
        return tones[made - 1 : made]

    monkeypatch.setattr(compete_module, "new_oscillations", one_more)
    compete(gap, usual_nuisance(gap), field)
    assert made == len(tones) + 1, "a search within the limit listens until nothing is heard"
    # Each of these searches takes two steps: the spring is found, and nothing after it.
    made = 0
    monkeypatch.setattr(compete_module, "MOST_STEPS", 6)
    model, _ = compete(gap, usual_nuisance(gap), field)
    assert 0 < made < len(tones)
    assert [choice.cause.name for choice in model.chosen] == ["body.spring"]
