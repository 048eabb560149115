"""Base of the causes that all joints feel in one consistent way."""

from __future__ import annotations

from abc import abstractmethod
from dataclasses import replace

import numpy as np

from mjfriction.diagnose.causes.cause import Cause, Site
from mjfriction.identify.gap import Gap
from mjfriction.identify.regression import Columns
from mjfriction.record.log import Floats


class WholeArm(Cause):
    """A change that every joint feels; its site is the joint where it shows most."""

    whole_arm = True
    of_body = True
    covariate = "position"
    curved = True

    @abstractmethod
    def torques(self, gap: Gap) -> Floats:
        """Return effort per unit strength at every joint, (n, joints, strengths)."""

    def columns(self, gap: Gap, site: Site) -> Columns:
        """The effort at every examined joint, through the measurement chain."""

        def made() -> Columns:
            torques = self.torques(gap)
            return {joint: gap.reported(joint, torques[:, joint]) for joint in gap.examined}

        return gap.kept.recall(self.name, made)

    def felt_most(self, gap: Gap, site: Site) -> list[Site]:
        """Return the site at the joint whose effort the cause changes most, relative to its noise, if any feels it."""
        columns = self.columns(gap, site)
        felt = {
            joint: float(np.mean(np.square(values))) / max(float(gap.noise_floor[joint]), 1e-12) ** 2
            for joint, values in columns.items()
        }
        most = max(felt, key=lambda joint: felt[joint])
        return [replace(site, joint=most)] if felt[most] > 0.0 else []
