"""drive.backlash that shows in landings: blows of the link, each after a flight of the same length."""

from __future__ import annotations

from typing import final

import numpy as np

from mjfriction.diagnose.causes.backlash import BACKLASH, Backlash
from mjfriction.diagnose.causes.cause import Quantity, Site
from mjfriction.diagnose.causes.moved_link import WIDEST, MovedLink, changed
from mjfriction.identify.gap import Gap
from mjfriction.identify.landings import FEWEST, Landings, find_landings, struck
from mjfriction.record.log import Floats
from mjfriction.record.motion import smooth_derivatives
from mjfriction.robot.robot import Robot

FLOWN = (0.5, 2.0)  # of what the landings say, between which the play that effort tells must lie


@final
class LandedPlay(MovedLink):
    """The link coasts across its play and lands when the log has a blow.

    Effort tells how far the link was off in flight, and the landings how far it flew: both must agree.
    """

    name = Backlash.name

    def sites(self, gap: Gap) -> list[Site]:
        """Every joint with blows of its own, but for those whose play was seen in the position."""
        inertia = gap.derivatives[2]
        joints = [j for j in gap.examined if j not in gap.motion.jump_free]
        return [Site(j) for j in joints if struck(gap.blown, gap.motion, inertia[:, j], j).size >= FEWEST]

    def _landings(self, gap: Gap, joint: int) -> Landings | None:
        load, inertia = gap.known.effort.load[:, joint], gap.derivatives[2][:, joint]
        return find_landings(gap.motion, load, inertia, gap.blown, joint)

    def shift(self, gap: Gap, site: Site) -> list[Floats]:
        """Half of where the link is in its play, and its derivatives; nothing where its flights differ."""
        landings = self._landings(gap, site.joint)
        course = np.zeros_like(gap.motion.time) if landings is None else 0.5 * landings.course
        return smooth_derivatives(gap.motion, course)

    def quantities(self, gap: Gap, site: Site) -> tuple[Quantity, ...]:
        """The play, stated plus change."""
        return (Quantity(BACKLASH, shift=gap.robot.table.joint[site.joint].transmission.backlash),)

    def admissible(self, gap: Gap, site: Site, strengths: Floats) -> bool:
        """The play is about as far as the link flew."""
        landings = self._landings(gap, site.joint)
        if landings is None:
            return False
        play = gap.robot.table.joint[site.joint].transmission.backlash + float(strengths[0])
        return play < WIDEST and FLOWN[0] < play / landings.play < FLOWN[1]

    def extend(self, robot: Robot, site: Site, strengths: Floats) -> Robot:
        """Move the play."""
        own = robot.table.joint[site.joint].transmission
        play = max(0.0, own.backlash + float(strengths[0]))
        return changed(robot, site, transmission=own.model_copy(update={"backlash": play, "coasting": True}))

    def evidence(self, gap: Gap, site: Site, strengths: Floats) -> str:
        """Give the play, and how many landings show it."""
        landings = self._landings(gap, site.joint)
        unit = "m" if gap.body.sliding[site.joint] else "rad"
        found = f"the link lags its sensor by a gap of {strengths[0]:.3g} {unit}"
        if landings is None:
            return found
        return f"{found}, and lands with a blow after flights as long, {landings.count} times"
