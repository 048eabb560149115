"""What one transmission brings in two ways is one finding: a drive that turns with two joints, and leans on the other.

The joint that such a drive leans on carries what the drive gives, so that its own drive reports that much less.
"""

from __future__ import annotations

from collections.abc import Iterable

from mjfriction.diagnose.causes.carried_drive import CarriedDrive
from mjfriction.diagnose.causes.cause import Site
from mjfriction.diagnose.causes.coupling import LeaningEffort
from mjfriction.diagnose.field import Chances
from mjfriction.diagnose.model import Chosen, Key, Model
from mjfriction.diagnose.trial import try_out

AS_GEARED = 0.3  # of the ratio that a drive turns with a joint by, by which the share that joint carries may differ


def leaning(model: Model, chances: Chances) -> Model:
    """Return the model with the share of an effort beside a joint's drive that turns with its neighbour too, where the
    neighbour carries about as much of it as the drive turns with the neighbour: −ratio.
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


def parts_of_drives(chosen: Iterable[Chosen]) -> dict[Key, Chosen]:
    """Return those of causes that are shares of the effort of a drive, by that drive's key."""
    causes = list(chosen)
    shares = {_pair(one): one for one in causes if isinstance(one.cause, LeaningEffort)}
    drives = {_pair(one): one for one in causes if isinstance(one.cause, CarriedDrive)}
    return {drives[pair].key: share for pair, share in shares.items() if pair in drives}


def _pair(choice: Chosen) -> tuple[int, int | None]:
    return choice.site.joint, choice.site.other
