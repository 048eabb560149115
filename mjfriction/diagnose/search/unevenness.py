"""How uneven friction is at a robot's joints: a smaller effect is not a cause."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from mjfriction.diagnose.causes.waves import Cogging, PositionFriction
from mjfriction.diagnose.fit.model import Chosen, Model, build_model
from mjfriction.diagnose.fit.nuisance import Nuisance
from mjfriction.diagnose.fit.refitted import FEWEST_JOINTS
from mjfriction.diagnose.fit.trial import EVENEST, FALSE_ALARM, UNEVEN, try_out
from mjfriction.diagnose.search.field import make_field, size
from mjfriction.diagnose.search.short_list import ranked
from mjfriction.identify.gap import Gap

WAVES = (PositionFriction(), Cogging())
TOLD_BY = 2  # fewest joints that must show waves, or be able to, for the machine's unevenness to be known
USUAL = 0.25  # place in the grid of wavenumbers of the wave tried by default: finer ones are in the band only at times


def with_unevenness(gap: Gap, nuisance: Nuisance) -> Nuisance:
    """Return the nuisances with the size required of a cause (``uneven``), relative to a machine that is as uneven as
    real ones.

    With fewer than three joints, an uneven joint cannot be told from one that has waves as a cause, and the full size
    is required.
    """
    if len(gap.examined) < FEWEST_JOINTS:
        return nuisance
    share = unevenness(build_model(gap, nuisance, ())) / UNEVEN
    return replace(nuisance, uneven=float(np.clip(share, EVENEST, 1.0)))


def as_uneven(model: Model) -> Model:
    """Return the model with the machine's unevenness measured again, beside all causes found except waves.

    The residual of links that are wrong hides waves, and makes false ones.  The size required of a cause is only ever
    raised.
    """
    if not model.chosen or len(model.gap.examined) < FEWEST_JOINTS:
        return model
    level = model
    for choice in model.chosen:
        if isinstance(choice.cause, PositionFriction | Cogging):
            level = level.without(choice)
    waves = _waves(level)
    uneven = max(min(_at_least_at(TOLD_BY, waves) / UNEVEN, 1.0), model.nuisance.uneven)
    # Two of six joints may each have waves as a cause. The ripple of gears shows at most joints.
    wavy = _at_least_at(max(TOLD_BY, math.ceil(len(waves) / 2)), waves)
    return build_model(model.gap, replace(model.nuisance, uneven=uneven, wavy=wavy), model.chosen)


def unevenness(model: Model) -> float:
    """Return the size that waves along the stroke (of the friction level or of a torque) reach at two joints or more,
    relative to the joints' friction; waves at a single joint may be a cause.

    A joint counts if it shows waves, or would show those of an uneven machine.  If fewer than two joints count, nothing
    is known and the machine is taken to be as uneven as real ones.
    """
    return _at_least_at(TOLD_BY, _waves(model))


def _at_least_at(joints: int, waves: list[float]) -> float:
    # The size that waves reach at so many joints.
    return waves[-joints] if len(waves) >= TOLD_BY else UNEVEN


def _waves(model: Model) -> list[float]:
    # The size of the largest wave of each joint that counts, in ascending order.
    field = make_field(model.gap, WAVES)
    if not field:
        return []
    chance = FALSE_ALARM / size(field)
    best = {choice.key[:2]: choice for choice in ranked(model, field)}
    waves: dict[int, float] = {}
    for entrant in field:
        trial = try_out(
            model, best.get(entrant.key, Chosen(entrant.cause, entrant.sites[int(USUAL * len(entrant.sites))]))
        )
        if trial is not None and (trial.chance < chance or trial.least_seen(chance) < UNEVEN):
            waves[entrant.joint] = max(trial.of_friction, waves.get(entrant.joint, 0.0))
    return sorted(waves.values())
