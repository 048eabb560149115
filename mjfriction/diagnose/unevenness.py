"""How uneven friction is at a robot's joints: what is less than that is no cause."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from mjfriction.diagnose.causes.waves import PositionFriction
from mjfriction.diagnose.exact import FEWEST_JOINTS
from mjfriction.diagnose.field import make_field, size
from mjfriction.diagnose.model import Model, build_model
from mjfriction.diagnose.nuisance import Nuisance
from mjfriction.diagnose.short_list import ranked
from mjfriction.diagnose.trial import FALSE_ALARM, try_out
from mjfriction.identify.gap import Gap

UNEVEN = 0.015  # of a joint's friction, that waves along its stroke are at on a machine as uneven as real ones
EVENEST = 0.25  # of what is asked on such a machine, that is asked on the most even one


def with_unevenness(gap: Gap, nuisance: Nuisance) -> Nuisance:
    """Return the nuisances with how much of a joint's friction a cause has to be, relative to what is asked on a
    machine that is as uneven as real ones are.

    On fewer than three joints one that is uneven cannot be told from one that has waves, and as much is asked as there.
    """
    if len(gap.examined) < FEWEST_JOINTS:
        return nuisance
    share = unevenness(build_model(gap, nuisance, ())) / UNEVEN
    return replace(nuisance, uneven=float(np.clip(share, EVENEST, 1.0)))


def unevenness(model: Model) -> float:
    """Return how large waves of the friction level along their strokes are at two joints at least, relative to the
    joints' friction; one alone may be a cause.  What may be chance is none.
    """
    field = make_field(model.gap, (PositionFriction(),))
    trials = [try_out(model, choice) for choice in ranked(model, field)]
    waves = [trial.of_friction for trial in trials if trial and trial.chance < FALSE_ALARM / size(field)]
    return sorted([0.0, 0.0, *waves])[-2]
