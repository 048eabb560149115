"""A search that came to more causes than can be true is not made again and again."""

from __future__ import annotations

from pathlib import Path

import pytest

from mjfriction.diagnose import compete as compete_module
from mjfriction.diagnose.causes.catalog import STRUCTURAL
from mjfriction.diagnose.compete import compete
from mjfriction.diagnose.exact import usual_nuisance
from mjfriction.diagnose.field import make_field
from mjfriction.diagnose.model import Chosen, Model
from mjfriction.identify.gap import measure_gap
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
