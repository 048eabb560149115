"""Robots whose links are all wrong: a few causes cannot make up for that, so links are freed and causes compete anew.

Vendors' models are made for pictures and for planning. Their masses add up, but each link's mass may be off by a third,
and its centre of mass by a hand's breadth. Links refitted within the usual error of stated inertias, two dozen small
changes, do not reach that far, and single links or a payload would have to stand in for all of them.

A freed link has all ten of its inertial parameters refitted.
"""

from __future__ import annotations

import numpy as np

from mjfriction.diagnose.causes.links import LinkCentre, LinkMoments, LinkScale
from mjfriction.diagnose.causes.payload import Payload
from mjfriction.diagnose.fit.model import Chosen, Model, cause_block
from mjfriction.diagnose.fit.nuisance import Nuisance
from mjfriction.diagnose.search.compete import compete
from mjfriction.diagnose.search.field import Field, size
from mjfriction.diagnose.search.unevenness import with_unevenness
from mjfriction.diagnose.search.yielding import yielding
from mjfriction.identify.gap import Gap
from mjfriction.identify.normal import Normal
from mjfriction.identify.regression import System
from mjfriction.progress import Tell, silently
from mjfriction.record.log import Floats

OF_LINKS = LinkScale | LinkCentre | LinkMoments | Payload
STRAINED = 2.0  # prior standard deviations by which a refitted link must be off before freed links are tried
FEWEST_GAINING = 2  # joints that must gain by freed links
MANY = 2  # with this many named links and payloads, no single cause is credible, whatever joints gain
LEAST_GAINED = 0.1  # of the held-out mean square left at a joint: a smaller change is neither a gain nor a loss
BAR = 2.0  # standard errors over the blocks by which the gain must exceed its price
CORRECTED = 1e-9  # of a gram's diagonal, added to it so that what no motion shows does not count as a freedom


def compete_for_links(
    gap: Gap, nuisance: Nuisance, field: Field, tell: Tell = silently, *, begin: tuple[Chosen, ...] = ()
) -> tuple[Model, Field]:
    """Let causes compete as in :func:`~mjfriction.diagnose.search.compete.compete`, with all links freed where the log
    shows that.

    Freed links are tried only where links are off at all. In the place of every named link and payload, all ten numbers
    of each link must gain on held-out motion more than their extra freedoms gain on noise alone, less what it cost to
    pick the named ones out of the field. At least two joints must gain, unless many links were named. Finally, the
    causes that then compete anew beside freed links may not leave more at any joint.
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
    # The first search may have been broken off (``enough``): continue it from there.
    return compete(gap, nuisance, field, tell, begin=model.chosen)


def _named(model: Model) -> int:
    return sum(isinstance(choice.cause, OF_LINKS) for choice in model.chosen)


def _others(model: Model) -> tuple[Chosen, ...]:
    return tuple(choice for choice in model.chosen if not isinstance(choice.cause, OF_LINKS))


def _strained(model: Model) -> bool:
    # Whether any link was named, or is refitted about as far as stated links are ever off.
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
    # The held-out mean square left at each examined joint.
    left = model.heldout_residual()
    return np.array([model.gap.rms(left[:, joint], joint) ** 2 for joint in model.gap.examined])


def _freedoms(normal: Normal) -> float:
    # The effective degrees of freedom: the trace of the matrix that maps rows to their fit. A strength that a prior
    # holds near a value counts as less than one.
    gram, _ = normal.products.whole
    held = gram + np.diag(normal.precision) + CORRECTED * np.diag(np.diag(gram))
    held[np.diag_indices_from(held)] += np.where(np.diag(held) > 0.0, 0.0, 1.0)
    return float(np.trace(np.linalg.solve(held, gram)))
