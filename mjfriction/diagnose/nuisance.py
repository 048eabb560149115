"""What is refitted with every candidate, because nothing stated is ever exact.

Each joint's Coulomb and viscous level is free.  Each link's mass and inertia may scale by a few percent and its centre
of mass lie some millimetres off, stated as a prior, so that a payload or a wrong torque constant is not swallowed by
links of half the mass.  A steady tone at a joint, or a load that swings there, is free too: no robot file holds it.
"""

from __future__ import annotations

import functools
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from mjfriction.diagnose.causes.catalog import STATED_LEVELS
from mjfriction.diagnose.causes.cause import Site
from mjfriction.identify.gap import Gap
from mjfriction.identify.regression import Columns
from mjfriction.identify.swing import Swing
from mjfriction.identify.tone import Tone
from mjfriction.record.log import Floats

LINK_SCALE = 0.03  # one standard deviation of how far a stated link may be off
LINK_SHIFT = 0.002  # m, and its centre of mass, along each axis
FARTHEST = 3.0  # of these deviations, that a link goes at most
PER_LINK = 4  # a scale and three shifts
LEVEL_SCALE = 10.0  # of the joint's RMS effort: next to no restraint


@dataclass(frozen=True)
class Level:
    """The Coulomb and viscous level of one joint: two columns."""

    site: Site
    columns: Columns
    precision: Floats


@dataclass(frozen=True)
class Link:
    """A link, named after the joint that moves it: the scale of its mass and inertia, and the shift of its centre of
    mass along x, y and z (m): four columns.
    """

    name: str
    columns: Columns
    precision: Floats


Source = Tone | Swing


@dataclass(frozen=True)
class Oscillation:
    """What a steady tone or a load that swings does to its joint: some columns."""

    source: Source
    columns: Columns
    precision: Floats


Part = Level | Link | Oscillation


@dataclass(frozen=True)
class Nuisance:
    """What is refitted: stated levels first, then links, then oscillations, in the order of their columns."""

    levels: tuple[Level, ...]
    links: tuple[Link, ...]
    oscillations: tuple[Oscillation, ...] = ()

    @functools.cached_property
    def columns(self) -> Columns:
        """All columns, in order."""
        parts: list[Part] = [*self.levels, *self.links, *self.oscillations]
        joints = dict.fromkeys(joint for part in parts for joint in part.columns)
        return {joint: np.hstack([_of_joint(part, joint) for part in parts]) for joint in joints}

    @property
    def precision(self) -> Floats:
        """What is known beforehand of all strengths, in order, (count,)."""
        parts: list[Part] = [*self.levels, *self.links, *self.oscillations]
        return np.concatenate([part.precision for part in parts]) if parts else np.empty(0)

    @property
    def link_reach(self) -> Floats:
        """How far the links' strengths go at most, in order."""
        return FARTHEST / np.sqrt(self.precision[self.of_links])

    @property
    def count(self) -> int:
        """How many columns."""
        return self.precision.size

    def of_level(self, joint: int) -> slice:
        """Return where the two strengths of a joint's levels stand.

        Raises :class:`ValueError` where they are held.
        """
        i = [level.site.joint for level in self.levels].index(joint)
        return slice(2 * i, 2 * i + 2)

    @property
    def of_links(self) -> slice:
        """Where the links' strengths stand, four for each."""
        first = 2 * len(self.levels)
        return slice(first, first + PER_LINK * len(self.links))

    @property
    def of_oscillations(self) -> slice:
        """Where the strengths of oscillations stand: last."""
        return slice(self.of_links.stop, self.count)

    @property
    def sources(self) -> tuple[Source, ...]:
        """What oscillates."""
        return tuple(one.source for one in self.oscillations)

    def without_level(self, joint: int) -> Nuisance:
        """Return the nuisances with one joint's levels held at what is stated."""
        return replace(self, levels=tuple(level for level in self.levels if level.site.joint != joint))

    def without_links(self) -> Nuisance:
        """Return the nuisances with every link as stated."""
        return replace(self, links=())


def make_nuisance(gap: Gap, sources: Sequence[Source] = ()) -> Nuisance:
    """Build the nuisance columns of a gap in which each of ``sources`` oscillates."""
    levels = []
    for site in STATED_LEVELS.sites(gap):
        effort = float(np.sqrt(np.mean(np.square(gap.measured[:, site.joint]))))
        speed = float(np.sqrt(np.mean(np.square(gap.motion.velocity[:, site.joint]))))
        precision = np.square(np.array([1.0, speed]) / (LEVEL_SCALE * effort))
        levels.append(Level(site, STATED_LEVELS.columns(gap, site), precision))
    links = []
    for k, name in enumerate(gap.body.links):
        block = {joint: rows[:, k] for joint, rows in gap.link_rows.items()}
        if any(np.any(values) for values in block.values()):
            links.append(Link(name, block, np.array([LINK_SCALE**-2.0, *[LINK_SHIFT**-2.0] * 3])))
    oscillations = []
    for source in sources:
        effort = float(np.sqrt(np.mean(np.square(gap.measured[:, source.joint]))))
        columns = source.columns(gap)
        precision = np.full(columns.shape[1], (LEVEL_SCALE * effort) ** -2.0)
        oscillations.append(Oscillation(source, {source.joint: columns}, precision))
    return Nuisance(tuple(levels), tuple(links), tuple(oscillations))


def _of_joint(part: Part, joint: int) -> Floats:
    rows = next(iter(part.columns.values())).shape[0]
    return part.columns.get(joint, np.zeros((rows, part.precision.size)))
