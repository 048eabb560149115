"""A curve over speed that refitted levels hide: they take up most of it, and are not off by enough to be a finding.

One of them is then too low and the other too high, and what they leave of the curve is too little for it to be found.
"""

from __future__ import annotations

from mjfriction.diagnose.fit.model import Model
from mjfriction.diagnose.search.field import Field, chances_in
from mjfriction.diagnose.search.short_list import contenders, passing
from mjfriction.diagnose.settle.levels_kept import CURVES
from mjfriction.diagnose.settle.one_factor import near_stated

SUSPECT = 0.08  # relative change of friction from which on levels may hide a curve
HALVED = 0.5  # share of the mean square left by free levels that the curve may leave


def with_hidden_curve(model: Model, joint: int, change: dict[int, float], asked: Field) -> Model:
    """Return the model with a curve in place of the change of a joint's levels, if there is one; else the model itself.

    The curves of ``asked`` are tried beside levels that are kept as near to what is stated as those of the other
    joints.  The best of them must halve what free levels leave.  ``change`` is how far each
    joint's friction is off, relative to what is stated.
    """
    near = near_stated(model, joint, change)
    curves = tuple(own for own in asked if own.joint == joint and own.cause.name in CURVES)
    best = max(passing(contenders(near, curves), chances_in(asked)), key=lambda trial: trial.merit, default=None)
    if best is None:
        return model
    curved, gap = near.with_also(best.chosen), model.gap
    left, now = (gap.rms(own.heldout_residual()[:, joint], joint) ** 2 for own in (model, curved))
    return curved if now < HALVED * left else model
