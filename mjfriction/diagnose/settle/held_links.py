"""Links held as stated and one cause more, where all else is stated exactly: refitted links then hide a cause."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from mjfriction.diagnose.causes.links import LEAST_ALONE, LEAST_MOVED_ALONE, LinkScale, LoneLink, LoneWholeLink
from mjfriction.diagnose.causes.payload import Payload
from mjfriction.diagnose.fit.as_little import AS_GOOD
from mjfriction.diagnose.fit.exact import FEWEST_OTHERS, OUTLYING, typical, untouched
from mjfriction.diagnose.fit.model import Model, build_model, without_contained
from mjfriction.diagnose.fit.refitted import FEWEST_JOINTS
from mjfriction.diagnose.fit.tangent import straightened
from mjfriction.diagnose.search.compete import pruned
from mjfriction.diagnose.search.field import Field, chances_in
from mjfriction.diagnose.search.short_list import contenders, fairly, passing
from mjfriction.diagnose.settle.levels_kept import WITH_LEVELS

# Of the stated friction: largest typical change with which one cause may stand for all refitted links.
NEARLY_EXACT = 0.02
# Of the mean square that refitted links take off a joint's error: share that one cause must take instead.
NEARLY_ALL = 0.99


def held_links(model: Model, field: Field, surely_off: Mapping[int, float], maybe_off: Mapping[int, float]) -> Model:
    """Return the model with all links held as stated and one cause more, where the rest is stated exactly and that
    leaves as little error at every joint.

    Links may be a few percent off where friction levels are. But where levels are right to a percent, what one link or
    payload does alone was not done by two dozen small errors. ``surely_off`` is by how much friction is off at least
    (:func:`~mjfriction.diagnose.fit.exact.least_off`) and ``maybe_off`` by how much it may be
    (:func:`~mjfriction.diagnose.fit.exact.may_be_off`), by joint, before any level was held as stated: a level that the
    data do not determine is not a level known to be right. Links must be off by more than levels may be.
    """
    if not model.nuisance.links or len(surely_off) < FEWEST_JOINTS:
        return model
    if typical(_of_own(model, surely_off)) > NEARLY_EXACT:
        return model
    held = model.without_links()
    links = tuple(one for one in field if isinstance(one.cause, LinkScale))
    asked = tuple(one for one in field if one not in links)
    # Beside a tilt or another link's change, a link's four numbers can be nearly anything.
    whole = not any(choice.cause.of_body for choice in model.chosen)
    lone = (LoneLink(), LoneWholeLink()) if whole else (LoneLink(),)
    asked += tuple(replace(one, cause=cause) for one in links for cause in lone)
    able = passing(contenders(held, asked), chances_in(asked))
    if not able:
        return model
    best = max(fairly(held, able), key=lambda trial: trial.merit)
    rest = without_contained(held.chosen, best.chosen)
    alone = straightened(build_model(held.gap, held.nuisance, (*rest, best.chosen)))
    # Two causes with similar columns may get large opposite strengths: every cause must still be admissible.
    possible = alone.admissible() is alone and _stand_out(model, alone, maybe_off)
    if not possible or not _as_good(alone, model, held):
        return model
    # What stood in for a part of that one cause is needless beside it.
    bare = straightened(pruned(alone, chances_in(asked)))
    return bare if _as_good(bare, model, held) else alone


def _of_own(model: Model, surely_off: Mapping[int, float]) -> list[float]:
    # By how much friction is off at joints where no cause bends its curve or shifts its level, if there are enough of
    # them: what is left for a level beside such a cause depends on the cause's form.
    moved = {
        choice.site.joint
        for choice, fitted in model.fitted_causes
        if choice.cause.name in WITH_LEVELS or choice.cause.level_shifts(model.gap, choice.site, fitted).size
    }
    own = [off for joint, off in surely_off.items() if joint not in moved]
    return own if len(own) > FEWEST_OTHERS else list(surely_off.values())


def _stand_out(model: Model, alone: Model, maybe_off: Mapping[int, float]) -> bool:
    # Whether links are off by more than levels may be: where each is off by no more, none of them did it alone. A cause
    # that is neither a link nor a payload is held to the same standard by its own size.
    bare = [maybe_off[joint] for joint in untouched(alone) if joint in maybe_off] or list(maybe_off.values())
    usual, last = OUTLYING * typical(bare), alone.chosen[-1]
    if isinstance(last.cause, LoneLink | LoneWholeLink | Payload):
        scales, moved = np.abs(model.link_changes[:, 0]), np.linalg.norm(model.link_changes[:, 1:], axis=1)
        return bool(np.max(scales) > usual or np.max(moved) > LEAST_MOVED_ALONE * usual / LEAST_ALONE)
    times = max(1.0, usual / LEAST_ALONE)
    return last.cause.noteworthy(alone.gap, last.site, alone.strengths[alone.places[-1]] / times)


def _as_good(alone: Model, model: Model, bare: Model) -> bool:
    # Whether it is as good at every joint: it leaves as little, or takes off nearly as much of the error with links as
    # stated.
    gap = model.gap
    lefts = [one.heldout_residual() for one in (alone, model, bare)]
    for joint in gap.examined:
        left, least, whole = (gap.rms(one[:, joint], joint) ** 2 for one in lefts)
        if left > max(AS_GOOD**2 * least, least + (1.0 - NEARLY_ALL) * (whole - least)):
            return False
    return True
