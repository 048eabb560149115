"""drive.backlash: the link coasts across its play."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import final

import numpy as np

from mjfriction.diagnose.causes.cause import Site
from mjfriction.diagnose.causes.moved_link import NEAR, as_drawn, felt_by_itself, lagging
from mjfriction.diagnose.causes.play import Play
from mjfriction.identify.gap import Gap
from mjfriction.identify.regression import Columns
from mjfriction.record.load_turns import load_turns
from mjfriction.record.log import Floats
from mjfriction.record.motion import smooth_derivatives
from mjfriction.robot.robot import Robot
from mjfriction.robot.transmission import coasting

PLAYS = tuple(0.1 * 0.9**k for k in range(82))  # rad or m: from 0.1 to 20 µrad (µm)
# Ratios of plays that are tried around one of these, up to half a step, and then around the best: a link that drops
# slowly across its play lands tenths of a second later for each percent of it.
FINER = (1.003, 1.01, 1.02, 1.03, 1.04, 1.055)
PROMISES = (0.1, NEAR[1])  # a tenth of a play shows in columns that land too early or too late


@final
class Backlash(Play):
    """The link crosses its play by its own inertia when the load changes sign.

    The time that this takes depends on the play, so the columns are computed around a play that is searched until the
    fitted strength agrees with it.  A link with a fifth more play lands so much later that its columns explain nothing
    of the landing; therefore many plays have to be tried.
    """

    curved = True
    ranked_alone = True
    around_rounds = 4
    promises = PROMISES

    def sites(self, gap: Gap) -> list[Site]:
        """Every joint that would feel a shift, with many plays to coast across.

        Where the load never changes sign, play acts merely as an offset of the sensor.
        """
        return [replace(site, around=play) for site in super().sites(gap) for play in PLAYS]

    def screening(self, gap: Gap, sites: Sequence[Site], every: int) -> Columns:
        """The torque at the joint itself, without the position filter, which makes many plays cheap to try."""
        return felt_by_itself(gap, sites, self._behind, every)

    def _behind(self, gap: Gap, sites: Sequence[Site]) -> Floats:
        # How far the link lags per unit of play, at many sites of one joint, (n, sites).
        joint, plays = sites[0].joint, np.array([site.around for site in sites])
        load = gap.known.effort.load[:, [joint]]
        if not np.all(plays):
            return 0.5 * np.sign(load)  # without a play to coast across: only tests whether any would be felt
        link = lagging(gap, joint, load[:, 0])
        place = [coasting(gap.motion, link, play) for play in plays.tolist()]
        return 0.5 * np.column_stack(place)

    def shift(self, gap: Gap, site: Site) -> list[Floats]:
        """Half the link's relative position in its play, through the position filter, and its two derivatives."""
        return smooth_derivatives(gap.motion, self._behind(gap, [site])[:, 0])

    def around_sites(self, gap: Gap, site: Site) -> list[Site]:
        """Plays that are hardly smaller or larger, and up to about halfway to the neighbours on the grid."""
        ratios = [ratio**way for ratio in FINER for way in (-1.0, 1.0)]
        return [replace(site, around=site.around * ratio) for ratio in ratios]

    def admissible(self, gap: Gap, site: Site, strengths: Floats) -> bool:
        """The play is near the one that the columns were computed for, and admissible as any play."""
        return as_drawn(site, strengths) and super().admissible(gap, site, strengths)

    def extend(self, robot: Robot, site: Site, strengths: Floats) -> Robot:
        """Change the play, and let the link coast across it."""
        return self.played(robot, site, strengths, coasting=True)

    def evidence(self, gap: Gap, site: Site, strengths: Floats) -> str:
        """Give the play and how often it was crossed."""
        crossed = load_turns(gap.motion, gap.known.effort.load[:, site.joint]).count
        often = f"crossed {crossed} times" if crossed else "never crossed"
        return f"{self.gap_found(gap, site, strengths)} that the load {often}"
