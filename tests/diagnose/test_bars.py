"""What chance and size have to say of a cause: when it stays, and how sure it is."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pyarrow as pa
import pytest
from scipy.stats import f as fisher

from mjfriction.benchmark.drawing import draw_case
from mjfriction.diagnose.causes.backlash import Backlash
from mjfriction.diagnose.causes.cause import Site
from mjfriction.diagnose.causes.lugre_presliding import DampedLuGrePresliding
from mjfriction.diagnose.causes.offset import Offset
from mjfriction.diagnose.causes.presliding import Presliding
from mjfriction.diagnose.causes.waves import Cogging
from mjfriction.diagnose.diagnosis import diagnose_log
from mjfriction.diagnose.fit import trial as trial_module
from mjfriction.diagnose.fit.model import Chosen
from mjfriction.diagnose.fit.trial import BRIEFLY, FALSE_ALARM, LEAST_EFFECT, QUIETLY, Trial, least_effect
from mjfriction.diagnose.fit.wald import Wald
from mjfriction.diagnose.search.compete import KEPT, _stays
from mjfriction.diagnose.search.field import Chances
from mjfriction.diagnose.tell.alike import AT_THE_BAR, _clearly
from mjfriction.record.readers.table import log_from_table

CANDIDATES, SPARE = 1000, 40


def trial(chance: float) -> Trial:
    """Return a trial that is large in everything, so likely by chance."""
    wald = Wald(float(fisher.isf(chance, 1, SPARE)), 1, SPARE)
    return Trial(
        Chosen(Offset(), Site(0)), np.full(41, 2.0), np.full(41, 3.0), 0.0, 0.0, 0.5, 0.3, 0.005, 0.04, 0.04, (wald,)
    )


@pytest.mark.parametrize(("times", "chosen", "kept"), [(0.5, True, True), (2.0, False, True), (20.0, False, False)])
def test_what_was_chosen_stays_where_it_would_barely_not_be_chosen_anew(times: float, chosen: bool, kept: bool) -> None:
    own = trial(times * FALSE_ALARM / CANDIDATES)
    assert own.passes(CANDIDATES) is chosen
    assert _stays(own, Chances(CANDIDATES, {})) is kept
    assert KEPT < 20


def test_an_effect_that_is_just_beyond_a_chance_is_as_large_as_the_least_seen() -> None:
    assert trial(1e-5).least_seen(1e-5) == pytest.approx(0.3)
    assert trial(1e-9).least_seen(1e-5) < 0.3


def test_the_larger_a_cause_is_over_what_it_has_to_be_the_surer_it_is() -> None:
    sure = [_clearly(replace(trial(1e-9), of_friction=0.04 * times)) for times in (1.0, 1.5, 2.0, 3.0, 10.0)]
    assert sure[0] == pytest.approx(AT_THE_BAR)
    assert np.all(np.diff(sure) > 0.0)
    assert sure[3] > 0.9
    assert sure[4] == pytest.approx(1.0, abs=1e-3)
    assert _clearly(replace(trial(1e-9), least_told=0.0)) == 1.0


def test_play_which_shows_in_few_rows_may_make_less_effort_than_others() -> None:
    model = SimpleNamespace()  # of no matter for the causes of one joint
    usual, brief = (least_effect(model, Chosen(cause, Site(0))) for cause in (Offset(), Backlash()))  # type: ignore[arg-type]
    assert (usual, brief) == (LEAST_EFFECT, BRIEFLY * LEAST_EFFECT)


def test_where_all_is_quiet_less_is_enough_except_of_what_every_machine_has() -> None:
    model = SimpleNamespace()
    causes = Offset(), Backlash(), Presliding(), DampedLuGrePresliding()
    least = [least_effect(model, Chosen(cause, Site(0)), quiet=True) for cause in causes]  # type: ignore[arg-type]
    assert least == [QUIETLY * LEAST_EFFECT] * 2 + [LEAST_EFFECT] * 2


@pytest.mark.deep
def test_play_of_little_effort_that_takes_most_of_the_error_is_a_finding(monkeypatch: pytest.MonkeyPatch) -> None:
    case = draw_case(1010080).case()
    log, hidden = log_from_table(pa.table(case.log), "case"), {(one.cause, one.joint) for one in case.hidden}
    assert {(one.cause, one.joint) for one in diagnose_log(log, case.stated).findings} == hidden
    monkeypatch.setattr(trial_module, "BRIEFLY", 1.0)
    left = {(one.cause, one.joint) for one in diagnose_log(log, case.stated).findings}
    assert hidden - left == {("drive.backlash", "joint_2")}


def test_the_level_of_false_alarms_is_shared_out_whole_and_few_candidates_do_not_pay_for_many() -> None:
    chances = Chances(1792, {Offset: 6, Cogging: 1786})
    shares = [chances.own[type(cause)] / chances.among(cause) for cause in (Offset(), Cogging())]
    assert sum(shares) == pytest.approx(1.0)
    assert chances.among(Offset()) < 25.0
    assert chances.among(Cogging()) < 2.0 * 1792
