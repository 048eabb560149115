"""drive.backlash: a transmission that has play."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import final

import numpy as np

from mjfriction.diagnose.causes.cause import Quantity, Site, near_around
from mjfriction.diagnose.causes.moved_link import (
    ROUNDS,
    WIDEST,
    MovedLink,
    as_drawn,
    changed,
    felt_by_itself,
    own_slopes,
)
from mjfriction.identify.gap import Gap
from mjfriction.identify.regression import Columns
from mjfriction.parameter import Parameter
from mjfriction.record.log import Floats
from mjfriction.record.motion import smooth_derivatives
from mjfriction.robot.robot import Robot
from mjfriction.robot.transmission import coasting

BACKLASH = Parameter("backlash", "{length}", "play of the transmission, from stop to stop", lower=0.0)
PLAYS = tuple(6.4e-2 * 0.8**k for k in range(38))  # rad or m: from 64 mrad to 17 µm
FINER = 1.15  # half of a step of these


@final
class Backlash(MovedLink):
    """The transmission has play: the link lags its sensor by half of it, towards the load, and coasts across.

    By its own inertia it takes its time: the columns are drawn around a play that is searched until the strength agrees
    with it.  A play a fifth larger lands so much later that it explains nothing of the landing, so that many have to be
    tried.
    """

    name = "drive.backlash"
    curved = True

    def sites(self, gap: Gap) -> list[Site]:
        """Every joint, with many plays to coast across.

        Where the load never changes its sign play is but an offset of the sensor.  Where it was seen in the position
        itself, it is not asked for again.
        """
        loose = [site for site in super().sites(gap) if site.joint not in gap.motion.jump_free]
        return [replace(site, around=play) for site in loose for play in PLAYS]

    def screening(self, gap: Gap, sites: Sequence[Site], every: int) -> Columns:
        """What the joint itself feels, without the position's filter: many plays, each for little."""
        return felt_by_itself(gap, sites, self._behind, every)

    def _behind(self, gap: Gap, site: Site) -> Floats:
        # How far the link is behind per unit of play, (n,).
        load = gap.known.effort.load[:, site.joint]
        if site.around == 0.0:
            return 0.5 * np.sign(load)  # no play to coast across: whether any would be felt
        stiffness, damping, inertia = own_slopes(gap, site.joint)
        following = load
        for _ in range(ROUNDS):
            # What a link would need to follow the motor from where it is.
            behind = 0.5 * coasting(gap.motion, following, inertia, site.around)
            moved = stiffness * behind + damping * gap.motion.differentiated(behind)
            following = load - site.around * moved
        return behind

    def shift(self, gap: Gap, site: Site) -> list[Floats]:
        """Half the place of the link in its play, through the position's filter, and its derivatives."""
        return smooth_derivatives(gap.motion, self._behind(gap, site))

    def around_sites(self, gap: Gap, site: Site) -> list[Site]:
        """To the neighbours on the grid."""
        return near_around(site, FINER)

    def quantities(self, gap: Gap, site: Site) -> tuple[Quantity, ...]:
        """The play, stated plus change."""
        return (Quantity(BACKLASH, shift=gap.robot.table.joint[site.joint].transmission.backlash),)

    def admissible(self, gap: Gap, site: Site, strengths: Floats) -> bool:
        """There is no negative play, and none far from the one that the columns were drawn for."""
        play = gap.robot.table.joint[site.joint].transmission.backlash + strengths[0]
        return as_drawn(site, strengths) and bool(0.0 < play < WIDEST)

    def extend(self, robot: Robot, site: Site, strengths: Floats) -> Robot:
        """Move the play."""
        own = robot.table.joint[site.joint].transmission
        play = max(0.0, own.backlash + float(strengths[0]))
        return changed(robot, site, transmission=own.model_copy(update={"backlash": play, "coasting": True}))

    def evidence(self, gap: Gap, site: Site, strengths: Floats) -> str:
        """Give the play and how often it was crossed."""
        unit = "m" if gap.body.sliding[site.joint] else "rad"
        gap_found = f"the link lags its sensor by a gap of {strengths[0]:.3g} {unit} that the load"
        crossed = _crossings(gap, site.joint)
        return f"{gap_found} crossed {crossed} times" if crossed else f"{gap_found} never crossed"


def _crossings(gap: Gap, joint: int) -> int:
    # How often the load on a link changes its sign.
    return int(np.count_nonzero(np.diff(np.sign(gap.known.effort.load[:, joint]))))
