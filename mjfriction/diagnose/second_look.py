"""Robots that turn out to be stated exactly once their causes are known: drives are then held, and causes compete anew.

Where causes sit at half of the joints, friction looks off throughout before any is found, so that drives are refitted
along; a torque constant that is off by a few percent goes under in that.
"""

from __future__ import annotations

from mjfriction.diagnose.as_little import leaves_as_little
from mjfriction.diagnose.exact import stated_exactly, untouched_and_exact
from mjfriction.diagnose.field import Field
from mjfriction.diagnose.free_links import compete_for_links
from mjfriction.diagnose.model import Model
from mjfriction.diagnose.nuisance import Nuisance, make_nuisance
from mjfriction.diagnose.refitted import FEWEST_JOINTS
from mjfriction.diagnose.unevenness import with_unevenness
from mjfriction.identify.gap import Gap
from mjfriction.progress import Tell, silently


def compete_twice(gap: Gap, nuisance: Nuisance, field: Field, tell: Tell = silently) -> tuple[Model, Field]:
    """Let causes compete as :func:`~mjfriction.diagnose.free_links.compete_for_links` does, and once more with drives
    as stated where friction is, at the joints that no cause of the first look touches.

    The second look counts where the joints that it leaves untouched are as stated, and it leaves as little at each.
    """
    first, asked = compete_for_links(gap, nuisance, field, tell)
    let_go = first.nuisance.inertias is not None
    if not nuisance.drives or let_go or not first.chosen or len(untouched_and_exact(first)) < FEWEST_JOINTS:
        return first, asked
    held = with_unevenness(gap, make_nuisance(gap))
    second, asked_then = compete_for_links(gap, held, field, tell, begin=first.chosen)
    as_good = stated_exactly(second) and leaves_as_little(second, first)
    return (second, asked_then) if as_good else (first, asked)
