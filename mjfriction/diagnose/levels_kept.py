"""Shapes that free friction levels make up for: the ratio by which two joints turn a drive that they share.

What such a drive takes of a joint's own velocity is damping like that joint's own.  With levels free any ratio fits;
the one beside which levels are as stated needs nothing else to be wrong.
"""

from __future__ import annotations

from mjfriction.diagnose.exact import AS_GOOD
from mjfriction.diagnose.model import Chosen, Model, build_model, cause_block
from mjfriction.diagnose.shapes import best_shape, reshaped
from mjfriction.diagnose.trial import try_out

ROUNDS = 2


def with_levels_as_stated(model: Model) -> Model:
    """Return the model with those shapes, that free levels make up for, beside which levels as stated do as well."""
    for choice in model.chosen:
        bounds = choice.cause.bounds_beside_stated_levels(model.gap, choice.site)
        if bounds:
            model = _reshaped(model, choice, bounds)
    return model


def _reshaped(model: Model, choice: Chosen, bounds: list[tuple[float, float]]) -> Model:
    gap, felt, kept, own = model.gap, cause_block(model.gap, choice)[0].keys(), model.nuisance, choice
    for joint in felt:
        kept = kept.without_level(joint)
    held = build_model(gap, kept, model.without(choice).chosen)
    for _ in range(ROUNDS):
        # A curve near rest has other bounds beside levels that are held.
        own = best_shape(held, own, bounds)
        if try_out(held, own) is None:
            return model
        there = reshaped(build_model(gap, kept, (*held.chosen, own)), felt)
        held = there.without(own)
    before, after = (one.heldout_residual() for one in (model, there))
    if any(gap.rms(after[:, joint], joint) > AS_GOOD * gap.rms(before[:, joint], joint) for joint in felt):
        return model
    return build_model(gap, model.nuisance, there.chosen)
