"""A second search, for what gives at joints where a first one left blows, bursts, or much beside play or compliance.

Rows with blows are usually left out, because what a log shows of a blow depends on filters and moments.  But play that
a link crosses in no time shows in nothing else.  And play between flanks that give has so many forms that it competes
only here.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from mjfriction.diagnose.causes.moved_link import MovedLink
from mjfriction.diagnose.causes.springy_play import SpringyPlay
from mjfriction.diagnose.fit.model import Chosen, Model
from mjfriction.diagnose.fit.small_errors import stands_out
from mjfriction.diagnose.search.field import Field, make_field
from mjfriction.diagnose.tell.seen_play import SeenPlay
from mjfriction.diagnose.tell.with_play import with_play
from mjfriction.identify.bursts import BURST_SHARE, burst_share
from mjfriction.identify.gap import Gap
from mjfriction.identify.landings import FEWEST, struck
from mjfriction.identify.measure import measure_gap, thinned
from mjfriction.identify.row_noise import least_noise
from mjfriction.identify.structure import Structure
from mjfriction.record.log import Floats

BLOWS = "blows"
LOUD = 1.3  # times the error elsewhere that the error with a joint's blows must reach to be heard
ABOVE_NOISE = 3.0  # times the least noise of its rows: error of a joint from which on it is searched again
HALVED = 0.5  # share of the mean square that may be left once it is known what gives


@dataclass(frozen=True)
class Doubted:
    """The ``joints`` at which something may give that a first search did not find; ``loud`` are those with blows that
    hold most of the error.

    ``seen`` has the gap to search; where there are such blows, their rows count on it.
    """

    seen: SeenPlay
    joints: tuple[int, ...]
    loud: tuple[int, ...]


def doubt(seen: SeenPlay, model: Model, highest: float) -> Doubted | None:
    """Return the joints that a model leaves much of, where play or compliance was found that stands out of it, or where
    what is left is in bursts or in blows; None if there are none.

    Blows count at joints without play that have as many of their own as landings need.  ``highest`` is the upper limit
    of the position filter's cutoff (Hz).
    """
    gap, left, played = model.gap, model.residual(), with_play(model)
    blown = [joint for joint in gap.examined if joint not in played and _count(gap, joint) >= FEWEST]
    loud: tuple[int, ...] = ()
    if blown:
        whole = measure_gap(seen.whole.log, seen.whole.robot, highest=highest, heeding=True)
        heeding = thinned(whole)
        loud = tuple(joint for joint in blown if _is_loud(gap, heeding, joint, left[:, joint]))
        # A joint of which blows left no row clear is examined with them.
        stated = np.where(np.isnan(seen.stated), heeding.residual, seen.stated)
        seen = replace(seen, whole=whole, gap=heeding, stated=stated) if loud else seen
    giving = {choice.site.joint for choice in model.chosen if _gives_much(model, choice, left)}
    noise = ABOVE_NOISE * least_noise(gap)
    much = [joint for joint in gap.examined if gap.rms(left[:, joint], joint) > noise[joint]]
    doubted = [joint for joint in much if joint in giving or burst_share(gap, joint, left) >= BURST_SHARE]
    joints = tuple(dict.fromkeys((*loud, *doubted)))
    return Doubted(seen, joints, loud) if joints else None


def asked_of(doubted: Doubted, field: Field, before: Model) -> Field:
    """Return the candidates of the second search: what may give at its joints, play between flanks that give, and the
    causes found ``before``, which are all of ``field``.

    What little is left of each blow once its play is known fits many a cause, such as a curve near rest.
    """
    found = {(type(choice.cause), choice.site.joint) for choice in before.chosen}
    field = (*field, *make_field(doubted.seen.gap, (SpringyPlay(),)))
    gives = {own.kind for own in field if isinstance(own.cause, MovedLink) and own.joint in doubted.joints}
    return tuple(entrant for entrant in field if entrant.kind in found | gives)


def gives_more(doubted: Doubted, again: Model, before: Model) -> bool:
    """Return whether a model of the second search halves what is left at its joints, by play or compliance."""
    giving = {choice.site.joint for choice in again.noteworthy if isinstance(choice.cause, MovedLink)}
    now, then = _mean_squares(doubted, again), _mean_squares(doubted, before)
    return bool(giving & now.keys()) and all(now[joint] < HALVED * then[joint] for joint in now)


def left_in_blows(doubted: Doubted, model: Model) -> list[Structure]:
    """Return what blows make of the error that a model without them leaves, by joint."""
    gap, left, whole = model.gap, model.heldout_residual(), _mean_squares(doubted, model)
    return [
        Structure(gap.robot.joints[joint], BLOWS, 1.0 - gap.rms(left[:, joint], joint) ** 2 / whole[joint])
        for joint in doubted.loud
    ]


def _mean_squares(doubted: Doubted, model: Model) -> dict[int, float]:
    left = model.heldout_residual()
    return {joint: doubted.seen.gap.rms(left[:, joint], joint) ** 2 for joint in doubted.joints}


def _gives_much(model: Model, choice: Chosen, left: Floats) -> bool:
    # Joints that give a little, as all do, leave much beside that on any machine.
    joint = choice.site.joint
    gives = isinstance(choice.cause, MovedLink)
    return gives and stands_out(model.gap, joint, model.without(choice).residual(), left)


def _count(gap: Gap, joint: int) -> int:
    return struck(gap.blown, gap.motion, gap.derivatives[2][:, joint], joint).size


def _is_loud(gap: Gap, heeding: Gap, joint: int, left: Floats) -> bool:
    error = heeding.rms(left, joint)
    return error > max(LOUD * gap.rms(left, joint), ABOVE_NOISE * float(least_noise(gap)[joint]))
