"""drive.backlash between flanks that give: the link flies across its play and swings on the flanks."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import final

import numpy as np

from mjfriction.diagnose.causes.backlash import PROMISES
from mjfriction.diagnose.causes.cause import Site
from mjfriction.diagnose.causes.elasticity import COMPLIANCE, DAMPING_RATIO, most_given
from mjfriction.diagnose.causes.moved_link import as_drawn, felt_by_itself, lagging, own_slopes
from mjfriction.diagnose.causes.play import Play
from mjfriction.identify.gap import Gap
from mjfriction.identify.regression import Columns
from mjfriction.record.log import Floats
from mjfriction.record.motion import smooth_derivatives
from mjfriction.robot.robot import Robot
from mjfriction.robot.transmission import LEAST_INERTIA, damper_of, flying, natural_frequency

FEWER_PLAYS = tuple(0.041 * 0.512**k for k in range(10))  # rad or m: from 41 mrad (mm) to 0.1
FLANKS = tuple(5.0 * 1.12**k for k in range(19))  # Hz; resonances of a link on flanks that give, up to 38
SCREENED_AT = 0.1  # damping ratio
FINER_PLAY, FINER_FLANKS, FINER_DAMPING = 1.4, 1.3, 2.0  # largest ratios of a step of the search


@final
class SpringyPlay(Play):
    """Between its flanks the link coasts; beyond them it swings on their compliance.

    Where it swings within the motion's band, it neither lands nor follows its motor: it rebounds.
    """

    curved = True
    ranked_alone = True
    promises = PROMISES
    shape_parameters = (DAMPING_RATIO, COMPLIANCE)
    around_rounds = 16
    contains = ("drive.elasticity",)

    def sites(self, gap: Gap) -> list[Site]:
        """Every joint that would feel a shift and states neither compliance nor play, with some plays and flanks."""
        return [own for site in super().sites(gap) for own in self._of_joint(gap, site)]

    def _of_joint(self, gap: Gap, site: Site) -> list[Site]:
        if gap.robot.table.joint[site.joint].transmission.gives:
            return []
        inertia = max(float(np.median(own_slopes(gap, site.joint)[2])), LEAST_INERTIA)
        soft = [1.0 / (inertia * (2.0 * np.pi * frequency) ** 2) for frequency in FLANKS]
        return [
            replace(site, around=play, shape=(SCREENED_AT, compliance))
            for compliance in soft
            if self._gives(gap, site.joint, compliance)
            for play in FEWER_PLAYS
        ]

    @staticmethod
    def _gives(gap: Gap, joint: int, compliance: float) -> bool:
        # Whether flanks give no farther than a transmission does.
        return compliance * float(np.max(np.abs(gap.known.effort.load[:, joint]))) < most_given(gap, joint)

    def screening(self, gap: Gap, sites: Sequence[Site], every: int) -> Columns:
        """The torque at the joint itself, without the position filter."""
        return felt_by_itself(gap, sites, self._behind, every)

    def _behind(self, gap: Gap, sites: Sequence[Site]) -> Floats:
        # How far the link lags per unit of play, at many sites of one joint, (n, sites).
        joint, load = sites[0].joint, gap.known.effort.load[:, [sites[0].joint]]
        if not sites[0].around:
            return 0.5 * np.sign(load)  # without a play to fly across: only tests whether any would be felt
        plays, compliances = np.array([site.around for site in sites]), np.array([site.shape[1] for site in sites])
        link = lagging(gap, joint, load[:, 0])
        damper = damper_of(link.inertia, compliances, np.array([site.shape[0] for site in sites]))
        return np.asarray(flying(gap.motion, link, 0.5 * plays, 1.0 / compliances, damper) / plays)

    def shift(self, gap: Gap, site: Site) -> list[Floats]:
        """The link's lag over its play, through the position filter, and its two derivatives."""
        return smooth_derivatives(gap.motion, self._behind(gap, [site])[:, 0])

    def columns_of(self, gap: Gap, sites: Sequence[Site]) -> list[Columns]:
        """Links that fly and swing on many flanks are integrated in hardly more time than one."""
        return self.columns_behind(gap, sites, self._behind(gap, sites))

    def around_sites(self, gap: Gap, site: Site) -> list[Site]:
        """Plays that are a little narrower or wider, and flanks a little softer or stiffer, more or less damped."""
        damping, compliance = site.shape
        out = [replace(site, around=float(site.around * step)) for step in _steps(FINER_PLAY)]
        out += [site.shaped((damping, float(compliance * step))) for step in _steps(FINER_FLANKS)]
        return out + [site.shaped((float(damping * step), compliance)) for step in _steps(FINER_DAMPING)]

    def admissible(self, gap: Gap, site: Site, strengths: Floats) -> bool:
        """The play is near the one that the columns were computed for, and the flanks give no farther than any."""
        gives = self._gives(gap, site.joint, site.shape[1])
        return gives and as_drawn(site, strengths) and super().admissible(gap, site, strengths)

    def extend(self, robot: Robot, site: Site, strengths: Floats) -> Robot:
        """State the play, and let the link swing on its flanks."""
        return self.played(robot, site, strengths, coasting=True, damping_ratio=site.shape[0], compliance=site.shape[1])

    def evidence(self, gap: Gap, site: Site, strengths: Floats) -> str:
        """Give the play, and the resonance on its flanks."""
        inertia = np.maximum(own_slopes(gap, site.joint)[2], LEAST_INERTIA)
        usual = float(np.median(natural_frequency(inertia, site.shape[1]))) / (2.0 * np.pi)
        return f"{self.gap_found(gap, site, strengths)}, and swings on flanks that give, at about {usual:.3g} Hz"


def _steps(largest: float) -> Floats:
    return np.power(largest, [-1.0, -0.25, 0.25, 1.0])
