"""What is refitted with every candidate, because nothing stated is ever exact.

Each joint's Coulomb and viscous level is free.  Each link's mass and inertia may scale by a few percent, stated as a
prior, so that a payload or a wrong torque constant is not swallowed by links of half the mass.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mjfriction.diagnose.causes.catalog import STATED_LEVELS
from mjfriction.diagnose.causes.cause import Site
from mjfriction.identify.gap import Gap
from mjfriction.identify.regression import Columns
from mjfriction.record.log import Floats

LINK_SCALE = 0.03  # one standard deviation of how far a stated link may be off
LEVEL_SCALE = 10.0  # of the joint's RMS effort: next to no restraint


@dataclass(frozen=True)
class Level:
    """The Coulomb and viscous level of one joint: two columns."""

    site: Site
    columns: Columns
    precision: Floats


@dataclass(frozen=True)
class LinkScale:
    """The scale of one link's mass and inertia, named after the joint that moves it: one column."""

    name: str
    columns: Columns
    precision: Floats


@dataclass(frozen=True)
class Nuisance:
    """The stated values that are refitted: levels first, then link scales, in the order of their columns."""

    levels: tuple[Level, ...]
    links: tuple[LinkScale, ...]

    @property
    def columns(self) -> list[Columns]:
        """All columns, in order."""
        return [*(level.columns for level in self.levels), *(link.columns for link in self.links)]

    @property
    def precisions(self) -> list[Floats]:
        """What is known beforehand of all strengths, in order."""
        return [*(level.precision for level in self.levels), *(link.precision for link in self.links)]

    @property
    def count(self) -> int:
        """How many columns."""
        return 2 * len(self.levels) + len(self.links)

    def without_level(self, joint: int) -> Nuisance:
        """Return the nuisances with one joint's levels held at what is stated."""
        return Nuisance(tuple(level for level in self.levels if level.site.joint != joint), self.links)


def make_nuisance(gap: Gap) -> Nuisance:
    """Build the nuisance columns of a gap."""
    levels = []
    for site in STATED_LEVELS.sites(gap):
        effort = float(np.sqrt(np.mean(np.square(gap.measured[:, site.joint]))))
        speed = float(np.sqrt(np.mean(np.square(gap.motion.velocity[:, site.joint]))))
        precision = np.square(np.array([1.0, speed]) / (LEVEL_SCALE * effort))
        levels.append(Level(site, STATED_LEVELS.columns(gap, site), precision))
    links = []
    for k, name in enumerate(gap.body.links):
        block = {joint: rows[:, k, :1] for joint, rows in gap.link_rows.items()}
        if any(np.any(values) for values in block.values()):
            links.append(LinkScale(name, block, np.array([1.0 / LINK_SCALE**2])))
    return Nuisance(tuple(levels), tuple(links))
