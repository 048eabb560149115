"""How uneven friction is at a robot's joints: what is less than that is no cause."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from mjfriction.diagnose.causes.waves import Cogging, PositionFriction
from mjfriction.diagnose.field import make_field, size
from mjfriction.diagnose.model import Chosen, Model, build_model
from mjfriction.diagnose.nuisance import Nuisance
from mjfriction.diagnose.refitted import FEWEST_JOINTS
from mjfriction.diagnose.short_list import ranked
from mjfriction.diagnose.trial import EVENEST, FALSE_ALARM, UNEVEN, try_out
from mjfriction.identify.gap import Gap

WAVES = (PositionFriction(), Cogging())
TOLD_BY = 2  # joints, that must be able to show so much for the machine to be known
USUAL = 0.25  # of the wavenumbers that a motion shows: finer waves pass by within the band for a part of it only


def with_unevenness(gap: Gap, nuisance: Nuisance) -> Nuisance:
    """Return the nuisances with how much of a joint's friction a cause has to be, relative to what is asked on a
    machine that is as uneven as real ones are.

    On fewer than three joints one that is uneven cannot be told from one that has waves, and as much is asked as there.
    """
    if len(gap.examined) < FEWEST_JOINTS:
        return nuisance
    share = unevenness(build_model(gap, nuisance, ())) / UNEVEN
    return replace(nuisance, uneven=float(np.clip(share, EVENEST, 1.0)))


def as_uneven(model: Model) -> Model:
    """Return a model with how much a cause has to be on a machine as uneven as it is seen to be beside all that was
    found: what links that are wrong leave hides waves, and makes some.
    """
    if not model.chosen or len(model.gap.examined) < FEWEST_JOINTS:
        return model
    level = model
    for choice in model.chosen:
        if isinstance(choice.cause, PositionFriction | Cogging):
            level = level.without(choice)
    wavy = unevenness(level)
    uneven = max(min(wavy / UNEVEN, 1.0), model.nuisance.uneven)
    return replace(model, nuisance=replace(model.nuisance, uneven=uneven, wavy=wavy))


def unevenness(model: Model) -> float:
    """Return how large waves along their strokes are, of the friction level or of a torque, at two joints at least,
    relative to the joints' friction; one alone may be a cause.

    Joints count that show waves, or would show those of an uneven machine.  Where fewer than two do, nothing is known,
    and the machine is as uneven as real ones are.
    """
    field = make_field(model.gap, WAVES)
    if not field:
        return UNEVEN
    chance = FALSE_ALARM / size(field)
    best = {choice.key[:2]: choice for choice in ranked(model, field)}
    waves: dict[int, float] = {}
    for entrant in field:
        trial = try_out(
            model, best.get(entrant.key, Chosen(entrant.cause, entrant.sites[int(USUAL * len(entrant.sites))]))
        )
        if trial is not None and (trial.chance < chance or trial.least_seen(chance) < UNEVEN):
            waves[entrant.joint] = max(trial.of_friction, waves.get(entrant.joint, 0.0))
    return sorted(waves.values())[-2] if len(waves) >= TOLD_BY else UNEVEN
