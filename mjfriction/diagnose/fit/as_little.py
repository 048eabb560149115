"""Test whether one model leaves as little error as another, so that the simpler one is to be preferred."""

from __future__ import annotations

from collections.abc import Iterable

from mjfriction.diagnose.fit.judged import judged
from mjfriction.diagnose.fit.model import Model

AS_GOOD = 1.02  # a model is as good as another if its held-out RMS at a joint is at most this many times the other's


def leaves_as_little(model: Model, than: Model, joints: Iterable[int] | None = None) -> bool:
    """Return whether a model leaves as little held-out error as another at each of some joints (by default all
    examined).
    """
    gap, own, other = judged(model, than), model.heldout_residual(), than.heldout_residual()
    asked = gap.examined if joints is None else joints
    return all(gap.rms(own[:, joint], joint) <= AS_GOOD * gap.rms(other[:, joint], joint) for joint in asked)
