"""Several effects of one transmission make one finding: a drive that turns with two joints, reacts on the neighbour,
and has a rotor of its own.

The joint that such a drive reacts on carries part of the drive's effort, so that joint's own drive reports that much
less.  And if the drive was not stated at all, its rotor is none of the stated ones: each of the two joints then turns
that much more inertia by itself too.
"""

from __future__ import annotations

from collections.abc import Iterable

from mjfriction.diagnose.causes.carried_drive import CarriedDrive
from mjfriction.diagnose.causes.cause import Site
from mjfriction.diagnose.causes.coupling import INERTIA, LeaningEffort, SharedDrive
from mjfriction.diagnose.causes.rotor_inertia import RotorInertia
from mjfriction.diagnose.fit.model import Chosen, Key, Model
from mjfriction.diagnose.fit.trial import try_out
from mjfriction.diagnose.search.field import Chances

# Relative tolerance for an effect to belong to a drive.  A joint's share of its effort must match the ratio by which
# the drive turns with that joint; a change of a joint's rotor must match what the drive's own rotor makes there.
AS_GEARED = 0.3


def leaning(model: Model, chances: Chances) -> Model:
    """Return the model with a share of the effort of each drive that turns with its neighbour too, added at that
    neighbour.

    It is added only where it passes its trial, and where the share that the neighbour carries is about as large as the
    drive turns with the neighbour: −ratio.
    """
    for choice in model.chosen:
        share = Chosen(LeaningEffort(), Site(choice.site.joint, other=choice.site.other))
        if not isinstance(choice.cause, CarriedDrive) or share.key in [one.key for one in model.chosen]:
            continue
        trial = try_out(model, share)
        if trial is not None and trial.passes(chances.among(share.cause)):
            more, geared = model.with_also(share), -choice.cause.ratio(choice.site)
            if abs(float(more.strengths[more.places[-1]][0]) / geared - 1.0) < AS_GEARED:
                model = more
    return model


def parts_of_drives(model: Model, named: Iterable[Chosen]) -> dict[Key, tuple[Chosen, ...]]:
    """Return which of a model's ``named`` causes belong to a drive that turns with two joints, by the drive's key:
    shares of its effort, and changes of a joint's rotor of about what the drive's own rotor makes there.
    """
    causes = list(named)
    drives = [one for one in causes if isinstance(one.cause, SharedDrive)]
    parts = {drive.key: tuple(one for one in causes if _belongs(model, one, drive)) for drive in drives}
    return {key: own for key, own in parts.items() if own}


def _belongs(model: Model, one: Chosen, drive: Chosen) -> bool:
    if isinstance(one.cause, LeaningEffort):
        return isinstance(drive.cause, CarriedDrive) and _pair(one) == _pair(drive)
    if not isinstance(one.cause, RotorInertia) or one.site.joint not in _pair(drive):
        return False
    own = _turned(model, drive, one.site.joint)
    return abs(float(model.strengths_of(one)[0]) - own) < AS_GEARED * own


def _turned(model: Model, drive: Chosen, joint: int) -> float:
    # The inertia of the drive's own rotor as a joint feels it.
    assert isinstance(drive.cause, SharedDrive), "no other turns with two joints"
    own = dict(zip((each.name for each in drive.cause.takes), model.strengths_of(drive).tolist(), strict=True))
    ratio = drive.cause.ratio(drive.site) if joint == drive.site.joint else 1.0
    return ratio**2 * float(own.get(INERTIA.name, 0.0))


def _pair(choice: Chosen) -> tuple[int, int | None]:
    return choice.site.joint, choice.site.other
