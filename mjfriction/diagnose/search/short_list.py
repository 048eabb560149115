"""Screening of candidates on a part of the rows, and trials of those that rank first."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from mjfriction.diagnose.causes.cause import Cause, Site
from mjfriction.diagnose.fit.model import Chosen, Model
from mjfriction.diagnose.fit.shapes import own_shape
from mjfriction.diagnose.fit.tangent import straightened
from mjfriction.diagnose.fit.trial import Trial, try_out
from mjfriction.diagnose.search.field import Chances, Entrant, Field, present
from mjfriction.identify.gap import Gap
from mjfriction.identify.regression import UNSEEN, Columns

Candidate = tuple[type[Cause], Site]

SHORT_LIST = 8
NEAR_BEST = 0.9  # fraction of the best candidate's merit above which curved candidates are refitted before comparing
# Fraction of the best merit of a short list from which on what acts on other causes' torques is refitted beside these.
WORTH_BENDING = 0.25
PROMISED = 3.0  # times the price of its degrees of freedom that a candidate must gain to be tried for what it promises
SCREENED_ROWS = 1000  # rows that candidates are screened on, at least: enough to rank shapes


@dataclass(frozen=True)
class Tried:
    """Trials of candidates beside one model, None for those that are not physical: with columns as they are, and those
    of sensors refitted on the nonlinear balance (``bent``).
    """

    straight: dict[Candidate, Trial | None]
    bent: dict[Candidate, Trial]


def contenders(model: Model, field: Field, joint: int | None = None) -> list[Trial]:
    """Screen every candidate not in the model yet, and return the trials of a short list, each at its best shape.

    Of the candidates at ``joint``, those that are ranked by what this joint alone feels are tried too, however they
    rank: the joints before it may feel more.
    """
    choices = ranked(model, field)
    alone = [choice for choice in choices[SHORT_LIST:] if choice.cause.ranked_alone and choice.site.joint == joint]
    return all_tried(model, choices[:SHORT_LIST] + alone)


def fairly(model: Model, trials: list[Trial]) -> list[Trial]:
    """Return the trials, with curved candidates near the best refitted on the nonlinear balance if several are near.

    A payload that is linearised at zero can lose against a shifted link, which is less nonlinear.
    """
    best = max((trial.merit for trial in trials), default=0.0)
    close = [trial for trial in trials if trial.merit > NEAR_BEST * best]
    if len(close) < 2:
        return trials
    return [_bent(model, trial) if trial.merit > NEAR_BEST * best else trial for trial in trials]


def best_bent(model: Model, trials: list[Trial], chances: Chances) -> list[Trial]:
    """Return the trials, with the best one refitted on the nonlinear balance if it is not beyond chance.

    The linearised fit of a play of half the stroke leaves so much that the effect might be chance.
    """
    best = max(trials, key=lambda trial: trial.merit, default=None)
    if best is None or best.merit <= 0.0 or best.beyond_chance(chances.among(best.chosen.cause)):
        return trials
    return [_bent(model, trial) if trial is best else trial for trial in trials]


def all_tried(model: Model, choices: list[Chosen], before: Tried | None = None) -> list[Trial]:
    """Return the trials of candidates, each at its best shape; candidates that are not physical are left out.

    Those that act on the torques of causes in the model are refitted beside these, if they come anywhere near the best.
    ``before`` holds what was tried beside the same model before, and takes up what is tried now.
    """
    before = Tried({}, {}) if before is None else before
    tried = dict[Candidate, Trial]()
    for choice in choices:
        candidate = type(choice.cause), choice.site
        if candidate not in before.straight:
            before.straight[candidate] = _tried(model, choice)
        trial = before.straight[candidate]
        if trial is not None:
            tried[candidate] = trial
    least = WORTH_BENDING * max((trial.merit for trial in tried.values()), default=0.0)
    for candidate, trial in tried.items():
        if trial.chosen.cause.of_sensor and model.chosen and trial.merit > max(least, 0.0):
            if candidate not in before.bent:
                before.bent[candidate] = _bent(model, trial)
            tried[candidate] = before.bent[candidate]
    return list(tried.values())


def passing(trials: list[Trial], chances: Chances) -> list[Trial]:
    """Return the trials that are beyond chance, given how many candidates there are, and large enough to matter."""
    return [trial for trial in trials if trial.passes(chances.among(trial.chosen.cause))]


def ranked(model: Model, field: Field) -> list[Chosen]:
    """Return candidates at their best shape, ranked by their gain on a part of the rows less the price of their degrees
    of freedom; those that gain nothing are left out.
    """
    every = max(1, model.gap.blocks.row.size // SCREENED_ROWS)
    best = []
    useless = {entrant.kind for entrant in field}  # until they are seen to gain
    for entrant in field:
        order = present(model, entrant)
        if order >= entrant.times or (entrant.cause.simpler, entrant.joint) in useless:
            continue
        columns = _screening(model.gap, entrant, every)
        strengths, gains = model.system.screen(columns, every)
        for i in np.argsort(-gains):
            price = _price(model.gap, _shown(columns, int(i)) + len(entrant.sites[i].shape))
            gain = float(gains[i]) - price
            if gain > 0.0:
                useless.discard(entrant.kind)
            promising = gains[i] > PROMISED * price and entrant.cause.promising(
                model.gap, entrant.sites[i], strengths[i]
            )
            if promising or entrant.cause.admissible(model.gap, entrant.sites[i], strengths[i]):
                best.append((gain, Chosen(entrant.cause, replace(entrant.sites[i], order=order))))
                break
    return [choice for gain, choice in sorted(best, key=lambda entry: -entry[0]) if gain > 0.0]


def _tried(model: Model, choice: Chosen) -> Trial | None:
    best = own_shape(model, choice)
    if best is None:
        return None
    # The shape that fits best may not be physical, while that of the grid may be.
    return try_out(model, best) or try_out(model, choice)


def _bent(model: Model, trial: Trial) -> Trial:
    if not trial.chosen.cause.curved:
        return trial
    # Curved causes that were chosen before keep their tangents: only the newcomer is linearised again.
    fitted = straightened(model.with_also(trial.chosen), trial.chosen)
    return try_out(model, fitted.chosen[-1]) or trial


def _screening(gap: Gap, entrant: Entrant, every: int) -> Columns:
    key = f"screening {type(entrant.cause).__name__} {entrant.joint}"
    return gap.kept.recall(key, lambda: entrant.cause.screening(gap, entrant.sites, every))


def _shown(columns: Columns, site: int) -> int:
    # The number of a candidate's strengths that the motion excites at all.
    size = sum(np.mean(np.square(values[:, site]), axis=0) for values in columns.values())
    return int(np.count_nonzero(size > UNSEEN**2 * np.max(size)))


def _price(gap: Gap, freedoms: int) -> float:
    # Every degree of freedom, searched shapes included, costs what it gains on noise alone.
    return freedoms * float(np.log(gap.blocks.row.size))
