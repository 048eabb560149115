"""Robots whose links are wrong everywhere: no few causes make up for that, so links are let go and causes compete anew.

Vendors' models are made for pictures and for planning: their masses add up, but each link's may be a third off, and its
centre a hand's breadth.  Two dozen small errors within what stated inertias usually are off by do not reach that far,
and single links or a payload would have to stand for all.
"""

from __future__ import annotations

import numpy as np

from mjfriction.diagnose.causes.links import LinkCentre, LinkScale
from mjfriction.diagnose.causes.payload import Payload
from mjfriction.diagnose.compete import compete
from mjfriction.diagnose.field import Field, size
from mjfriction.diagnose.model import Chosen, Model, cause_block
from mjfriction.diagnose.nuisance import Nuisance
from mjfriction.diagnose.unevenness import with_unevenness
from mjfriction.diagnose.yielding import yielding
from mjfriction.identify.gap import Gap
from mjfriction.identify.normal import Normal
from mjfriction.identify.regression import System
from mjfriction.progress import Tell, silently
from mjfriction.record.log import Floats

OF_LINKS = LinkScale | LinkCentre | Payload
STRAINED = 2.0  # deviations, by which a link that is refitted along must be off for more to be asked
FEWEST_GAINING = 2  # that must gain by it
MANY = 2  # links and payloads named: no single cause any more, whatever joints gain
LEAST_GAINED = 0.1  # of what is left at a joint, on motion not fitted, that counts as gained, or lost
BAR = 2.0  # standard errors by which it must gain over the blocks
CORRECTED = 1e-9  # of a gram's diagonal, that keeps what no motion shows from being a freedom


def compete_for_links(
    gap: Gap, nuisance: Nuisance, field: Field, tell: Tell = silently, *, begin: tuple[Chosen, ...] = ()
) -> tuple[Model, Field]:
    """Let causes compete as :func:`~mjfriction.diagnose.compete.compete` does, with all links let go where that is what
    the log shows.

    That is asked where links are off at all.  In the place of every link and payload that was named, all ten numbers of
    each link must gain on motion not fitted, more than what their further freedoms are worth on noise alone, less what
    it cost to pick the others out of the field; at two joints at least, but where many were named; and at none may what
    then competes anew beside them leave more.
    """
    model, asked = compete(
        gap,
        nuisance,
        field,
        tell,
        begin=begin or yielding(gap, nuisance, field),
        enough=lambda so_far: _named(so_far) >= MANY and _pays(so_far, field),
    )
    if not _strained(model) or not _pays(model, field):
        return model, asked
    rest = tuple(entrant for entrant in field if not isinstance(entrant.cause, OF_LINKS))
    beside = with_unevenness(gap, model.nuisance.with_links_let_go(gap))
    let_go = compete(gap, beside, rest, tell, begin=_others(model))
    if not np.any(_left(let_go[0]) > (1.0 + LEAST_GAINED) * _left(model)):
        return let_go
    if _named(model) < MANY:
        return model, asked
    # That search may have been broken off: it goes on from there.
    return compete(gap, nuisance, field, tell, begin=model.chosen)


def _named(model: Model) -> int:
    return sum(isinstance(choice.cause, OF_LINKS) for choice in model.chosen)


def _others(model: Model) -> tuple[Chosen, ...]:
    return tuple(choice for choice in model.chosen if not isinstance(choice.cause, OF_LINKS))


def _strained(model: Model) -> bool:
    # Whether any link was named, or is about as far off as stated ones ever are.
    place = model.nuisance.of_links
    far = np.abs(model.strengths[place]) * np.sqrt(model.nuisance.precision[place]) > STRAINED
    return _named(model) > 0 or bool(np.any(far))


def _pays(model: Model, field: Field) -> bool:
    gap = model.gap
    nuisance = model.nuisance.with_links_let_go(gap)
    if nuisance.inertias is None:
        return False
    others = [cause_block(gap, choice) for choice in _others(model)]
    columns, precisions = zip((nuisance.columns, nuisance.precision), *others, strict=True)
    let_go = System(model.system.rows, list(columns), list(precisions)).normal
    before, after = model.heldout_errors, let_go.heldout_errors(gap.blocks.folds)
    gained = (before - after).sum(axis=0)
    price = (_freedoms(let_go) - _freedoms(model.system.normal)) * float(np.log(gained.size))
    picking = 2.0 * _named(model) * float(np.log(size(field)))
    error = float(np.std(gained, ddof=1)) * np.sqrt(gained.size)
    joints = np.count_nonzero(after.sum(axis=1) < (1.0 - LEAST_GAINED) * before.sum(axis=1))
    enough = joints >= FEWEST_GAINING or _named(model) >= MANY
    return enough and float(np.sum(gained)) > price - picking + BAR * error


def _left(model: Model) -> Floats:
    # The mean square that is left at each joint that is examined, on motion not fitted.
    left = model.heldout_residual()
    return np.array([model.gap.rms(left[:, joint], joint) ** 2 for joint in model.gap.examined])


def _freedoms(normal: Normal) -> float:
    # What is held near a value is less than a freedom: the trace of what turns rows into their fit.
    gram, _ = normal.products.whole
    held = gram + np.diag(normal.precision) + CORRECTED * np.diag(np.diag(gram))
    held[np.diag_indices_from(held)] += np.where(np.diag(held) > 0.0, 0.0, 1.0)
    return float(np.trace(np.linalg.solve(held, gram)))
