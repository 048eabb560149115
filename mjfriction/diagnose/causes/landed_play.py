"""drive.backlash that shows in landings: blows of the link, each after a free flight over the same distance."""

from __future__ import annotations

from typing import final

import numpy as np

from mjfriction.diagnose.causes.cause import Site
from mjfriction.diagnose.causes.play import Play
from mjfriction.identify.gap import Gap
from mjfriction.identify.landings import FEWEST, Landings, find_landings, struck
from mjfriction.record.log import Floats
from mjfriction.record.motion import smooth_derivatives
from mjfriction.robot.robot import Robot

FLOWN = (0.5, 2.0)  # range of the play estimated from effort, relative to the play estimated from landings


@final
class LandedPlay(Play):
    """The link coasts across its play and lands where the log has a blow.

    The effort shows how far the link was off in flight, and the landings how far it flew: both must agree.
    """

    def sites(self, gap: Gap) -> list[Site]:
        """Every joint with enough blows of its own, except where play was already seen in the position itself."""
        rows = {j: gap.derivatives[2][:, j] for j in gap.examined if j not in gap.motion.jump_free}
        return [Site(j) for j, inertia in rows.items() if struck(gap.blown, gap.motion, inertia, j).size >= FEWEST]

    def _landings(self, gap: Gap, joint: int) -> Landings | None:
        load, inertia = gap.known.effort.load[:, joint], gap.derivatives[2][:, joint]
        return find_landings(gap.motion, load, inertia, gap.blown, joint)

    def shift(self, gap: Gap, site: Site) -> list[Floats]:
        """Half the link's relative position in its play, and its two derivatives; zero where its flights differ."""
        landings = self._landings(gap, site.joint)
        course = np.zeros_like(gap.motion.time) if landings is None else 0.5 * landings.course
        return smooth_derivatives(gap.motion, course)

    def admissible(self, gap: Gap, site: Site, strengths: Floats) -> bool:
        """The play is about the distance that the link flew."""
        landings = self._landings(gap, site.joint)
        if landings is None:
            return False
        far = self.play(gap, site, strengths) / landings.play
        return FLOWN[0] < far < FLOWN[1] and super().admissible(gap, site, strengths)

    def extend(self, robot: Robot, site: Site, strengths: Floats) -> Robot:
        """Change the play, and let the link coast across it."""
        return self.played(robot, site, strengths, coasting=True)

    def evidence(self, gap: Gap, site: Site, strengths: Floats) -> str:
        """Give the play, and how many landings show it."""
        landings = self._landings(gap, site.joint)
        often = f"{landings.count} times" if landings is not None else "time and again"
        return f"{self.gap_found(gap, site, strengths)}, and lands with a blow after flights as long, {often}"
