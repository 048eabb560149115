"""drive.backlash that is crossed as the load says: at once, or over a range of load."""

from __future__ import annotations

from typing import final

import numpy as np

from mjfriction.diagnose.causes.backlash import BACKLASH, Backlash
from mjfriction.diagnose.causes.cause import Quantity, Site
from mjfriction.diagnose.causes.moved_link import WIDEST, MovedLink, changed
from mjfriction.identify.gap import Gap
from mjfriction.parameter import Parameter
from mjfriction.record.log import Floats
from mjfriction.record.motion import smooth_derivatives
from mjfriction.robot.robot import Robot
from mjfriction.robot.transmission import crossing, slow_load

CROSSING_LOAD = Parameter("crossing_load", "{force}", "load within which the play is crossed, to 76 %", lower=0.0)
SHARES = (0.005, 0.01, 0.02, 0.05)  # of the largest load on the joint, within which play may be crossed


@final
class CrossedPlay(MovedLink):
    """The link lags its sensor by half of the play, towards the load: half of tanh(load / crossing load).

    The teeth of a strain-wave gear are soft near no load, and many gears lose their play to grease and preload little
    by little.
    """

    name = Backlash.name
    shape_parameters = (CROSSING_LOAD,)

    def sites(self, gap: Gap) -> list[Site]:
        """Every joint on which the load changes its sign, but for those whose play was seen in the position."""
        return [
            Site(site.joint, (share * self._most(gap, site.joint),))
            for site in super().sites(gap)
            if site.joint not in gap.motion.jump_free and np.ptp(np.sign(self._load(gap, site.joint))) > 0.0
            for share in SHARES
        ]

    def shape_bounds(self, gap: Gap, site: Site) -> list[tuple[float, float]]:
        """From crossed at once to a transmission that gives."""
        most = self._most(gap, site.joint)
        return [(0.5 * SHARES[0] * most, 2.0 * SHARES[-1] * most)]

    def _load(self, gap: Gap, joint: int) -> Floats:
        return slow_load(gap.motion, gap.known.effort.load[:, joint])

    def _most(self, gap: Gap, joint: int) -> float:
        return float(np.max(np.abs(self._load(gap, joint))))

    def shift(self, gap: Gap, site: Site) -> list[Floats]:
        """Half of where the link is in its play, and its derivatives."""
        (within,) = site.shape or (0.0,)
        return smooth_derivatives(gap.motion, 0.5 * crossing(self._load(gap, site.joint), within))

    def quantities(self, gap: Gap, site: Site) -> tuple[Quantity, ...]:
        """The play, stated plus change."""
        return (Quantity(BACKLASH, shift=gap.robot.table.joint[site.joint].transmission.backlash),)

    def admissible(self, gap: Gap, site: Site, strengths: Floats) -> bool:
        """There is no negative play."""
        return bool(0.0 < gap.robot.table.joint[site.joint].transmission.backlash + strengths[0] < WIDEST)

    def extend(self, robot: Robot, site: Site, strengths: Floats) -> Robot:
        """Move the play."""
        own = robot.table.joint[site.joint].transmission
        play = {"backlash": max(0.0, own.backlash + float(strengths[0])), "crossing_load": site.shape[0]}
        return changed(robot, site, transmission=own.model_copy(update={**play, "coasting": False}))

    def evidence(self, gap: Gap, site: Site, strengths: Floats) -> str:
        """Give the play, and how often it was crossed."""
        length, force = ("m", "N") if gap.body.sliding[site.joint] else ("rad", "N·m")
        crossed = np.count_nonzero(np.diff(np.sign(self._load(gap, site.joint))))
        return (
            f"the link lags its sensor by a gap of {strengths[0]:.3g} {length} that the load crossed {crossed} times, "
            f"within {site.shape[0]:.3g} {force} of none"
        )
