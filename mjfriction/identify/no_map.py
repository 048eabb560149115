"""Why a joint has no friction map: what its log lacks, and what to record instead."""

from __future__ import annotations

import numpy as np

from mjfriction.identify.friction_map import FEWEST_SPEEDS
from mjfriction.identify.phases import Phase, goes
from mjfriction.record.motion import Motion

ALONE = 0.5  # share of the time in which a joint moves that it must move alone for passes to have been intended
LEAST_PASSES = 2  # passes of one joint that are not a coincidence
PLAN = "mjfriction plan --protocol forward_backward writes such a motion"


def why_no_map(motion: Motion, phases: list[Phase], joint: int) -> str:
    """Return what a joint's motion lacks for a friction map; empty where none was intended."""
    own = [phase for phase in phases if phase.joint == joint]
    ways = {phase.velocity > 0.0 for phase in own}
    if len(own) >= LEAST_PASSES and len(ways) == 1:
        return "its passes go one way only: record the same speeds in the other direction"
    if len(own) >= LEAST_PASSES:
        return f"its passes agree in speed and place both ways at fewer than {FEWEST_SPEEDS} speeds; {PLAN}"
    if not own and _goes_alone(motion, joint):
        return f"it moves alone, but nowhere at a constant speed; {PLAN}"
    return ""


def _goes_alone(motion: Motion, joint: int) -> bool:
    going = goes(motion)
    others = np.delete(going, joint, axis=1)
    # On a robot with one joint every motion is alone, which proves nothing.
    return others.shape[1] > 0 and bool(np.mean(~np.any(others[going[:, joint]], axis=1)) > ALONE)
