"""drive.backlash whose crossing follows the load: at once where the load changes sign, or over a range of load."""

from __future__ import annotations

from typing import final

import numpy as np

from mjfriction.diagnose.causes.cause import Site
from mjfriction.diagnose.causes.play import Play
from mjfriction.identify.gap import Gap
from mjfriction.parameter import Parameter
from mjfriction.record.load_turns import load_turns
from mjfriction.record.log import Floats
from mjfriction.record.motion import smooth_derivatives
from mjfriction.robot.robot import Robot
from mjfriction.robot.transmission import crossing, slow_load

CROSSING_LOAD = Parameter("crossing_load", "{force}", "load within which the play is crossed, to 76 %", lower=0.0)
SHARES = (0.005, 0.01, 0.02, 0.05)  # crossing loads to try, as fractions of the largest load on the joint


@final
class CrossedPlay(Play):
    """The link lags its sensor by half of the play times tanh(load / crossing load).

    The teeth of a strain-wave gear are soft near zero load, and in many gears grease and preload take up the play
    gradually.
    """

    shape_parameters = (CROSSING_LOAD,)

    def sites(self, gap: Gap) -> list[Site]:
        """Every joint on which the load changes sign, with crossing loads to try."""
        return [
            Site(site.joint, (share * self._most(gap, site.joint),))
            for site in super().sites(gap)
            if np.ptp(np.sign(self._load(gap, site.joint))) > 0.0
            for share in SHARES
        ]

    def shape_bounds(self, gap: Gap, site: Site) -> list[tuple[float, float]]:
        """From play that is crossed almost at once to play that is like a compliant transmission."""
        most = self._most(gap, site.joint)
        return [(0.5 * SHARES[0] * most, 2.0 * SHARES[-1] * most)]

    def _load(self, gap: Gap, joint: int) -> Floats:
        key = f"slow load {joint}"
        return gap.kept.recall(key, lambda: {joint: slow_load(gap.motion, gap.known.effort.load[:, joint])})[joint]

    def _most(self, gap: Gap, joint: int) -> float:
        return float(np.max(np.abs(self._load(gap, joint))))

    def shift(self, gap: Gap, site: Site) -> list[Floats]:
        """Half the link's relative position in its play, and its two derivatives."""
        (within,) = site.shape or (0.0,)
        return smooth_derivatives(gap.motion, 0.5 * crossing(self._load(gap, site.joint), within))

    def extend(self, robot: Robot, site: Site, strengths: Floats) -> Robot:
        """Change the play, and state its crossing load."""
        return self.played(robot, site, strengths, coasting=False, crossing_load=site.shape[0])

    def evidence(self, gap: Gap, site: Site, strengths: Floats) -> str:
        """Give the play, how often the load crossed it, and the crossing load."""
        crossed = load_turns(gap.motion, self._load(gap, site.joint)).count
        within = f"{site.shape[0]:.3g} {'N' if gap.body.sliding[site.joint] else 'N·m'}"
        return f"{self.gap_found(gap, site, strengths)} that the load crossed {crossed} times, within {within} of none"
