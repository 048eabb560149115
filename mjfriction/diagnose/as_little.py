"""When one model leaves as little as another, so that the simpler of the two is to be believed."""

from __future__ import annotations

from collections.abc import Iterable

from mjfriction.diagnose.model import Model

AS_GOOD = 1.02  # of what a model leaves at a joint on motion not fitted, that another may leave and be as good


def leaves_as_little(model: Model, than: Model, joints: Iterable[int] | None = None) -> bool:
    """Return whether a model leaves as little as another, on motion not fitted, at each of some joints, or of all."""
    gap, own, other = model.gap, model.heldout_residual(), than.heldout_residual()
    asked = gap.examined if joints is None else joints
    return all(gap.rms(own[:, joint], joint) <= AS_GOOD * gap.rms(other[:, joint], joint) for joint in asked)
