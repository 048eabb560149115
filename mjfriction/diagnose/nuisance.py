"""What is refitted with every candidate, because nothing stated is ever exact.

Each joint's Coulomb and viscous level is free, and its effort may read a little where there is none: no sensor's zero
is exact, and less than waves along the strokes of an uneven machine it is no finding. Each link's mass and inertia may
scale by a few percent and its centre of mass lie some millimetres off, stated as a prior, so that a payload or a wrong
torque constant is not swallowed by links of half the mass. Where friction is a few percent off throughout, so may be
what data sheets say of the drives: each rotor's inertia and each torque constant. Where that is not enough, links are
let go altogether, in all ten numbers of each. A steady tone at a joint, or a load that swings there, is free too: no
robot file holds it.
"""

from __future__ import annotations

import functools
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from mjfriction.diagnose.refitted import (
    OUT_OF_CHANCE,
    Drive,
    Level,
    Link,
    Oscillation,
    Part,
    Source,
    Zero,
    drives_of,
    levels_of,
    links_of,
    oscillations_of,
    zeros_of,
)
from mjfriction.identify.gap import Gap
from mjfriction.identify.link_inertias import LinkInertias, link_inertias
from mjfriction.identify.regression import Columns
from mjfriction.record.log import Floats

FARTHEST = 3.0  # deviations, that a link or a drive goes at most
LET_GO = 1.5  # by which a link that is let go may be off in each of its ten numbers, relative to what is stated
PER_LINK = 4  # a scale and three shifts
HELD = 1e12  # precision of what is not to move


@dataclass(frozen=True)
class Nuisance:
    """What is refitted: levels first, then zeros, drives, links, and oscillations, in the order of their columns.

    Links are within what stated ones are ever off by (``links``), or let go (``inertias``), not both.
    ``uneven`` is how uneven the machine is, 1 for one that is as uneven as real ones are: a cause has to be larger than
    that.  ``wavy`` is how large waves along their strokes are at two joints at least, relative to the joints' friction,
    beside all causes that are known: a wave has to be larger than that.
    """

    levels: tuple[Level, ...]
    drives: tuple[Drive, ...]
    links: tuple[Link, ...]
    inertias: LinkInertias | None = None
    oscillations: tuple[Oscillation, ...] = ()
    uneven: float = 1.0
    wavy: float = 0.0
    zeros: tuple[Zero, ...] = ()

    @property
    def parts(self) -> list[Part]:
        """All that is refitted, in order."""
        links = self.links if self.inertias is None else (self.inertias,)
        return [*self.levels, *self.zeros, *self.drives, *links, *self.oscillations]

    @functools.cached_property
    def columns(self) -> Columns:
        """All columns, in order."""
        joints = dict.fromkeys(joint for part in self.parts for joint in part.columns)
        return {joint: np.hstack([_of_joint(part, joint) for part in self.parts]) for joint in joints}

    @property
    def precision(self) -> Floats:
        """What is known beforehand of all strengths, in order, (count,)."""
        known = np.concatenate([part.precision for part in self.parts]) if self.parts else np.empty(0)
        known[self.of_zeros] /= self.uneven**2
        return known

    @property
    def reach(self) -> Floats:
        """How far the strengths of zeros, drives and links go at most, in order."""
        farthest = np.full(self.count, FARTHEST)
        farthest[self.of_zeros] = OUT_OF_CHANCE
        return (farthest / np.sqrt(self.precision))[self.of_bounded]

    @property
    def count(self) -> int:
        """How many columns."""
        return sum(part.precision.size for part in self.parts)

    def of_level(self, joint: int) -> slice:
        """Return where the two strengths of a joint's levels stand.

        Raises :class:`ValueError` where they are held.
        """
        i = [level.site.joint for level in self.levels].index(joint)
        return slice(2 * i, 2 * i + 2)

    @property
    def of_zeros(self) -> slice:
        """Where the zeros' strengths stand, one for each."""
        first = 2 * len(self.levels)
        return slice(first, first + len(self.zeros))

    @property
    def of_drives(self) -> slice:
        """Where the drives' strengths stand, one for each."""
        first = self.of_zeros.stop
        return slice(first, first + len(self.drives))

    @property
    def of_links(self) -> slice:
        """Where the links' strengths stand, four for each."""
        first = self.of_drives.stop
        return slice(first, first + PER_LINK * len(self.links))

    def link_changes(self, strengths: Floats) -> Floats:
        """Return how far each refitted link is from what is stated: its scale, relative, and centre, m, (links, 4)."""
        return strengths[self.of_links].reshape(-1, PER_LINK)

    @property
    def of_inertias(self) -> slice:
        """Where the strengths of links that were let go stand, ten for each."""
        first = self.of_links.stop
        return slice(first, first + (self.inertias.precision.size if self.inertias else 0))

    @property
    def of_stated(self) -> slice:
        """Where those strengths stand of which it is known how far they usually are off: drives' and links'."""
        return slice(self.of_drives.start, self.of_inertias.stop)

    @property
    def of_bounded(self) -> slice:
        """Where those strengths stand that stated values are not ever far off by: zeros', drives' and links'."""
        return slice(self.of_zeros.start, self.of_links.stop)

    @property
    def of_oscillations(self) -> slice:
        """Where the strengths of oscillations stand: last."""
        return slice(self.of_inertias.stop, self.count)

    @property
    def sources(self) -> tuple[Source, ...]:
        """What oscillates."""
        return tuple(one.source for one in self.oscillations)

    def without_level(self, joint: int) -> Nuisance:
        """Return the nuisances with one joint's levels held at what is stated."""
        return replace(self, levels=tuple(level for level in self.levels if level.site.joint != joint))

    def with_level_near(self, joint: int, stated: tuple[float, float], spread: float) -> Nuisance:
        """Return the nuisances with one joint's levels near what is ``stated``, off by a ``spread`` (relative) as a
        rule; one that is stated as nothing is held.
        """
        known = np.array([(spread * value) ** -2.0 if value > 0.0 else HELD for value in stated])
        near = (
            replace(one, precision=known, free=one.freed().precision) if one.site.joint == joint else one
            for one in self.levels
        )
        return replace(self, levels=tuple(near))

    def with_level_free(self, joint: int) -> Nuisance:
        """Return the nuisances with one joint's levels free."""
        return replace(self, levels=tuple(one.freed() if one.site.joint == joint else one for one in self.levels))

    def level_near(self, joint: int) -> bool:
        """Return whether a joint's levels are kept near what is stated."""
        return any(level.near for level in self.levels if level.site.joint == joint)

    def without_links(self) -> Nuisance:
        """Return the nuisances with every link as stated."""
        return replace(self, links=(), inertias=None)

    def with_links_let_go(self, gap: Gap) -> Nuisance:
        """Return the nuisances of a gap with all links let go that are felt."""
        return replace(self, links=(), inertias=link_inertias(gap, LET_GO))

    def without_zeros(self) -> Nuisance:
        """Return the nuisances with no effort where there is none."""
        return replace(self, zeros=())

    def without_drives(self) -> Nuisance:
        """Return the nuisances with every drive as stated."""
        return replace(self, drives=())

    def along(self, gap: Gap, sources: Sequence[Source]) -> Nuisance:
        """Return the like nuisances of a gap in which each of ``sources`` oscillates."""
        like = replace(make_nuisance(gap, sources, drives=bool(self.drives)), uneven=self.uneven)
        return like if self.inertias is None else like.with_links_let_go(gap)


def make_nuisance(gap: Gap, sources: Sequence[Source] = (), *, drives: bool = False) -> Nuisance:
    """Build the nuisance columns of a gap in which each of ``sources`` oscillates; with ``drives``, these may be a
    little off too.
    """
    return Nuisance(
        levels_of(gap),
        drives_of(gap) if drives else (),
        links_of(gap),
        oscillations=oscillations_of(gap, sources),
        zeros=zeros_of(gap),
    )


def _of_joint(part: Part, joint: int) -> Floats:
    rows = next(iter(part.columns.values())).shape[0]
    return part.columns.get(joint, np.zeros((rows, part.precision.size)))
