"""Causes in a richer form, with more strengths, where the gain pays for these."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mjfriction.diagnose.causes.cause import Site
from mjfriction.diagnose.causes.lugre_presliding import LuGreBristle
from mjfriction.diagnose.causes.stribeck import Stribeck
from mjfriction.diagnose.fit.model import Chosen, Model
from mjfriction.diagnose.fit.shapes import best_shape
from mjfriction.diagnose.fit.trial import try_out
from mjfriction.diagnose.search.field import Field
from mjfriction.diagnose.search.refusal import proved

PAYS = 10.0  # merit above which a richer form is worth the parameters that it adds to a report


@dataclass(frozen=True)
class Richer:
    """A ``model`` with a cause in its richer form, and its held-out gain less what the additional freedoms cost."""

    model: Model
    gain: float


def in_richer_form(model: Model, choice: Chosen, plain: Chosen) -> Richer | None:
    """Return the model with the richer form of ``plain`` in place of ``choice``, a straight cause of the model.

    None where that is not physical or the motion does not prove it.
    """
    assert plain.cause.richer is not None, "asked of causes that have one"
    without = model.without(choice)
    richer, site = plain.cause.richer(), plain.site
    bounds = richer.shape_bounds(model.gap, site)
    if bounds and not site.shape:
        site = site.shaped(tuple(np.sqrt(np.prod(bounds, axis=1)).tolist()))  # in the middle, as ratios
    whole = best_shape(without, Chosen(richer, site))
    if try_out(without, whole) is None:
        return None
    found = without.with_also(whole)
    return Richer(found, paid_gain(model, found.chosen)) if proved(found, whole) else None


def paid_gain(model: Model, chosen: tuple[Chosen, ...]) -> float:
    """Return the held-out gain over a model of other causes in place of its own, with the same row weights, less what
    their additional freedoms, searched shapes included, gain on noise alone.
    """
    blocks, normal = model.gap.blocks, model.with_others(chosen)
    more = normal.precision.size - model.system.normal.precision.size
    more += _searched(model, chosen) - _searched(model, model.chosen)
    gain = float(np.sum(model.heldout_errors) - np.sum(normal.heldout_errors(blocks.folds)))
    return gain - more * float(np.log(blocks.count))


def _searched(model: Model, chosen: tuple[Chosen, ...]) -> int:
    return sum(len(choice.cause.shape_bounds(model.gap, choice.site)) for choice in chosen)


def enriched(model: Model, field: Field) -> Model:
    """Return the model with those of its causes in their richer form that gain by it.

    Forms that compete in the field on their own are left to do so.
    """
    competing = {type(entrant.cause) for entrant in field}
    for choice in model.chosen:
        if choice.cause.richer is None or choice.cause.richer in competing or choice.tangent:
            continue
        richer = in_richer_form(model, choice, choice)
        if richer is not None and richer.gain > PAYS:
            model = richer.model
    return model


def curves_apart(model: Model) -> Model:
    """Return the model with a bristle that takes the stated Stribeck curve along replaced by one of the level alone,
    beside a change of that curve, where the gain pays for the change: the curve that is stated is then not there.
    """
    for choice in model.chosen:
        joint = choice.site.joint
        at_joint = [one for one in model.chosen if one.site.joint == joint]
        if not isinstance(choice.cause, LuGreBristle) or any(one.cause.name == Stribeck.name for one in at_joint):
            continue
        curve = Chosen(Stribeck(), Site(joint, choice.cause.curve(model.gap, choice.site)[1:]))
        changed = model.without(choice).with_also(curve)
        alone = best_shape(changed, Chosen(choice.cause.alone(), choice.site))
        if try_out(changed, alone) is None:
            continue
        apart = changed.with_also(alone)
        if apart.admissible() is apart and paid_gain(model, apart.chosen) > PAYS:
            model = apart
    return model
