"""What a settled model leaves of the gap, what of it is unexplained, and which of its causes are no findings."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass, replace

from mjfriction.diagnose.fit.judged import judged
from mjfriction.diagnose.fit.model import Key
from mjfriction.diagnose.search.stroke_curve import stroke_curves
from mjfriction.diagnose.settle.stated import Settled
from mjfriction.diagnose.tell.untold import Untold, find_untold
from mjfriction.diagnose.tell.verdict import unexplained
from mjfriction.identify.structure import Structure, find_structure
from mjfriction.record.log import Floats


@dataclass(frozen=True)
class LeftOver:
    """What a settled model leaves.

    ``heldout`` (rows, joints) is its held-out residual, ``structure`` the structured shares of it, ``remaining`` what
    of it is unexplained; ``untold`` are the causes that are no findings.
    """

    heldout: Floats
    structure: tuple[Structure, ...]
    remaining: tuple[Structure, ...]
    untold: Untold


def left_over(settled: Settled, *, untold: Collection[Key] = ()) -> LeftOver:
    """Return what a settled model leaves; the causes that are ``untold`` already stay so."""
    model = settled.model
    heldout, clean = model.heldout_residual(oscillations=True), model.heldout_residual()
    structure = tuple(find_structure(judged(model), heldout))
    curves = stroke_curves(model, clean)
    remaining = tuple(unexplained(model, structure, heldout, curves))
    found = find_untold(settled, remaining, curves, clean)
    return LeftOver(heldout, structure, remaining, replace(found, keys=found.keys | set(untold)))
