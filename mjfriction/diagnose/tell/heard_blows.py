"""Blows that hold most of what is left: rows with them count after all, in a second search.

Usually they are left out, because what a log shows of a blow depends on filters and moments.  But play that a link
crosses in no time shows in nothing else.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

from mjfriction.diagnose.causes.moved_link import MovedLink
from mjfriction.diagnose.causes.play import Play
from mjfriction.diagnose.fit.model import Model
from mjfriction.diagnose.search.field import Field
from mjfriction.diagnose.tell.seen_play import SeenPlay
from mjfriction.identify.gap import Gap
from mjfriction.identify.landings import FEWEST, struck
from mjfriction.identify.measure import measure_gap, thinned
from mjfriction.identify.structure import Structure
from mjfriction.record.log import Floats

BLOWS = "blows"
LOUD = 1.3  # times the error elsewhere that the error with a joint's blows must reach to be heard
ABOVE_NOISE = 3.0  # and times the sensor's noise
HALVED = 0.5  # share of the mean square that may be left once play or compliance explains the blows


@dataclass(frozen=True)
class HeardBlows:
    """The gap on which rows with blows count (``seen``), and the ``joints`` whose blows no play explains yet."""

    seen: SeenPlay
    joints: tuple[int, ...]


def with_play(model: Model) -> set[int]:
    """Return the joints at which play is stated or was found."""
    stated = {i for i, joint in enumerate(model.gap.robot.table.joint) if joint.transmission.backlash > 0.0}
    return stated | {choice.site.joint for choice in model.chosen if isinstance(choice.cause, Play)}


def hear_blows(seen: SeenPlay, model: Model, highest: float) -> HeardBlows | None:
    """Return the blows that hold most of what a model leaves at joints without play; None if there are none.

    A joint needs as many blows of its own as landings need.  ``highest`` is the upper limit of the position filter's
    cutoff (Hz).
    """
    gap = model.gap
    asked = [joint for joint in gap.examined if joint not in with_play(model) and _count(gap, joint) >= FEWEST]
    if not asked:
        return None
    whole = measure_gap(seen.whole.log, seen.whole.robot, highest=highest, heeding=True)
    heeding = thinned(whole)
    left = model.residual()
    loud = tuple(joint for joint in asked if _is_loud(gap, heeding, joint, left[:, joint]))
    return HeardBlows(replace(seen, whole=whole, gap=heeding), loud) if loud else None


def asked_of(heard: HeardBlows, field: Field, before: Model) -> Field:
    """Return the part of a field that is asked beside blows: what may give at their joints, and the causes found
    ``before``.

    What little is left of each blow once its play is known fits many a cause, such as a curve near rest.
    """
    found = {(type(choice.cause), choice.site.joint) for choice in before.chosen}
    gives = {
        entrant.kind for entrant in field if isinstance(entrant.cause, MovedLink) and entrant.joint in heard.joints
    }
    return tuple(entrant for entrant in field if entrant.kind in found | gives)


def accounts_for(heard: HeardBlows, again: Model, before: Model) -> bool:
    """Return whether a model that was found with the blows explains them all by play or compliance."""
    giving = {choice.site.joint for choice in again.noteworthy if isinstance(choice.cause, MovedLink)}
    return all(
        joint in giving and _mean_square(heard, again, joint) < HALVED * _mean_square(heard, before, joint)
        for joint in heard.joints
    )


def left_in_blows(heard: HeardBlows, model: Model) -> list[Structure]:
    """Return what blows make of the error that a model without them leaves, by joint."""
    names, left = model.gap.robot.joints, model.heldout_residual()
    quiet = {joint: model.gap.rms(left[:, joint], joint) ** 2 for joint in heard.joints}
    return [
        Structure(names[joint], BLOWS, 1.0 - quiet[joint] / _mean_square(heard, model, joint)) for joint in heard.joints
    ]


def _mean_square(heard: HeardBlows, model: Model, joint: int) -> float:
    return heard.seen.gap.rms(model.heldout_residual()[:, joint], joint) ** 2


def _count(gap: Gap, joint: int) -> int:
    return struck(gap.blown, gap.motion, gap.derivatives[2][:, joint], joint).size


def _is_loud(gap: Gap, heeding: Gap, joint: int, left: Floats) -> bool:
    error = heeding.rms(left, joint)
    return error > max(LOUD * gap.rms(left, joint), ABOVE_NOISE * float(gap.noise_floor[joint]))
