"""The places along its stroke that a joint passes often enough to tell of friction there."""

from __future__ import annotations

import numpy as np

from mjfriction.diagnose.causes.cause import Site
from mjfriction.identify.gap import Gap
from mjfriction.record.log import Floats
from mjfriction.record.motion import Motion

PASSES = 4  # least number of passes over a place, in both directions: fewer may show a chance event there
PLACES = 256  # number of positions along the stroke at which passes are counted


def passed_often(gap: Gap, site: Site) -> bool:
    """Return whether a place often passed, in both directions, is within a site's width of its centre.

    Centre and width are the first two numbers of its shape.
    """
    joint, (centre, width) = site.joint, site.shape
    often = gap.kept.recall(f"places passed {joint}", lambda: {joint: _often(gap.motion, joint)})[joint]
    return bool(often.size and np.min(np.abs(often - centre)) <= width)


def _often(motion: Motion, joint: int) -> Floats:
    position, joined = motion.position[:, joint], np.diff(motion.piece) == 0
    places = np.linspace(np.min(position), np.max(position), PLACES)
    before, after = (np.searchsorted(places, own[joined]) for own in (position[:-1], position[1:]))
    ways = []
    for low, high in ((before, after), (after, before)):
        ahead = low < high
        count = np.zeros(PLACES + 1, dtype=np.int64)
        np.add.at(count, low[ahead], 1)
        np.add.at(count, high[ahead], -1)
        ways.append(np.cumsum(count)[:-1])
    return np.asarray(places[(ways[0] + ways[1] >= PASSES) & (ways[0] > 0) & (ways[1] > 0)])
