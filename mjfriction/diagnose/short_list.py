"""Candidates screened on a part of the rows, and the trials of those that rank first."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from mjfriction.diagnose.field import Chances, Entrant, Field, present
from mjfriction.diagnose.model import Chosen, Model
from mjfriction.diagnose.shapes import apart, best_shape
from mjfriction.diagnose.tangent import straightened
from mjfriction.diagnose.trial import Trial, try_out
from mjfriction.identify.gap import Gap
from mjfriction.identify.regression import UNSEEN, Columns

SHORT_LIST = 8
NEAR_BEST = 0.9  # of the best candidate's merit, from which on two are compared on the real balance
SCREENED_ROWS = 1000  # enough to rank shapes by


def contenders(model: Model, field: Field) -> list[Trial]:
    """Screen every candidate not in the model yet, and return the trials of a short list, each at its best shape."""
    return all_tried(model, ranked(model, field)[:SHORT_LIST])


def fairly(model: Model, trials: list[Trial]) -> list[Trial]:
    """Return trials of which those near the best are tried on the real balance, where any of these is curved.

    A payload drawn in a straight line from none can lose against a shifted link that bends less.
    """
    best = max((trial.merit for trial in trials), default=0.0)
    close = [trial for trial in trials if trial.merit > NEAR_BEST * best]
    if len(close) < 2:
        return trials
    return [_bent(model, trial) if trial.merit > NEAR_BEST * best else trial for trial in trials]


def best_bent(model: Model, trials: list[Trial], chances: Chances) -> list[Trial]:
    """Return trials of which the one that does most is tried on the real balance, where it is not beyond chance.

    Of a play of half the stroke a straight line leaves so much that it might be chance.
    """
    best = max(trials, key=lambda trial: trial.merit, default=None)
    if best is None or best.merit <= 0.0 or best.beyond_chance(chances.among(best.chosen.cause)):
        return trials
    return [_bent(model, trial) if trial is best else trial for trial in trials]


def all_tried(model: Model, choices: list[Chosen]) -> list[Trial]:
    """Return the trials of candidates, each at its best shape; what nature does not allow has none."""
    trials = [_tried(model, choice) for choice in choices]
    return [trial for trial in trials if trial is not None]


def passing(trials: list[Trial], chances: Chances) -> list[Trial]:
    """Return those of the trials that are beyond chance, as often as it might strike, and large enough to matter."""
    return [trial for trial in trials if trial.passes(chances.among(trial.chosen.cause))]


def ranked(model: Model, field: Field) -> list[Chosen]:
    """Return candidates by what they gain on a part of the rows; those that gain nothing are left out."""
    every = max(1, model.gap.blocks.row.size // SCREENED_ROWS)
    best = []
    for entrant in field:
        order = present(model, entrant)
        if order >= entrant.times:
            continue
        columns = _screening(model.gap, entrant, every)
        strengths, gains = model.system.screen(columns, every)
        for i in np.argsort(-gains):
            if entrant.cause.admissible(model.gap, entrant.sites[i], strengths[i]):
                gain = float(gains[i]) - _price(model.gap, _shown(columns, int(i)) + len(entrant.sites[i].shape))
                best.append((gain, Chosen(entrant.cause, replace(entrant.sites[i], order=order))))
                break
    return [choice for gain, choice in sorted(best, key=lambda entry: -entry[0]) if gain > 0.0]


def _tried(model: Model, choice: Chosen) -> Trial | None:
    best = best_shape(model, choice)
    if not choice.cause.own_shape(model.gap, best.site) or not apart(model, best):
        return None
    # The shape that fits best may be one that nature does not allow; the grid's may be.
    trial = try_out(model, best) or try_out(model, choice)
    if trial is not None and choice.cause.of_sensor and model.chosen:
        return _bent(model, trial)
    return trial


def _bent(model: Model, trial: Trial) -> Trial:
    if not trial.chosen.cause.curved:
        return trial
    # What the curved causes chosen before have come to is left as it was: only the newcomer bends.
    fitted = straightened(model.with_also(trial.chosen), trial.chosen)
    return try_out(model, fitted.chosen[-1]) or trial


def _screening(gap: Gap, entrant: Entrant, every: int) -> Columns:
    key = f"screening {type(entrant.cause).__name__} {entrant.joint}"
    return gap.kept.recall(key, lambda: entrant.cause.screening(gap, entrant.sites, every))


def _shown(columns: Columns, site: int) -> int:
    # How many of a candidate's strengths the motion shows at all.
    size = sum(np.mean(np.square(values[:, site]), axis=0) for values in columns.values())
    return int(np.count_nonzero(size > UNSEEN**2 * np.max(size)))


def _price(gap: Gap, freedoms: int) -> float:
    # Every freedom, the searched shape included, costs what it gains on noise alone.
    return freedoms * float(np.log(gap.blocks.row.size))
