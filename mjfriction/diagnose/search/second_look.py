"""A second competition with drives held as stated, for robots that prove to be stated exactly once causes are known.

When half of the joints have a cause, friction looks off everywhere before any cause is found, so drives are refitted
along.  The refitted drives then absorb a torque constant that is off by a few percent.
"""

from __future__ import annotations

from mjfriction.diagnose.fit.as_little import leaves_as_little
from mjfriction.diagnose.fit.exact import stated_exactly, untouched_and_exact
from mjfriction.diagnose.fit.model import Model
from mjfriction.diagnose.fit.nuisance import Nuisance, make_nuisance
from mjfriction.diagnose.fit.refitted import FEWEST_JOINTS
from mjfriction.diagnose.search.field import Field
from mjfriction.diagnose.search.free_links import compete_for_links
from mjfriction.diagnose.search.unevenness import with_unevenness
from mjfriction.identify.gap import Gap
from mjfriction.progress import Tell, silently


def compete_twice(gap: Gap, nuisance: Nuisance, field: Field, tell: Tell = silently) -> tuple[Model, Field]:
    """Let causes compete as in :func:`~mjfriction.diagnose.search.free_links.compete_for_links`, and again with drives
    as stated if friction is as stated at enough of the joints that no cause touches.

    The second result is used if friction is as stated at the joints it leaves without a cause, and if its held-out
    residual is as small as the first one's at every joint.
    """
    first, asked = compete_for_links(gap, nuisance, field, tell)
    let_go = first.nuisance.inertias is not None
    if not nuisance.drives or let_go or not first.chosen or len(untouched_and_exact(first)) < FEWEST_JOINTS:
        return first, asked
    held = with_unevenness(gap, make_nuisance(gap))
    second, asked_then = compete_for_links(gap, held, field, tell, begin=first.chosen)
    as_good = stated_exactly(second) and leaves_as_little(second, first)
    return (second, asked_then) if as_good else (first, asked)
