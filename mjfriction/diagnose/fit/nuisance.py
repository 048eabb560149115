"""The nuisances: stated values that are refitted with every candidate, because none of them is ever exact.

Each joint's Coulomb and viscous level is free. Its effort may read slightly off where there is none: no sensor's zero
is exact, and an error smaller than the waves along the strokes of an uneven machine is no finding. Each link's mass and
inertia may scale by a few percent, and its centre of mass may lie some millimetres off. This is a prior, so that links
of half the mass do not absorb a payload or a wrong torque constant. Where friction is off by a few percent throughout,
the data sheet values of the drives may be too: each rotor's inertia and each torque constant. Where that is not enough,
links are let go altogether, in all ten numbers of each. A steady tone at a joint, or a load that swings there, is free
too, since no robot file holds it.
"""

from __future__ import annotations

import functools
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from mjfriction.diagnose.fit.refitted import (
    OUT_OF_CHANCE,
    PER_LINK,
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

FARTHEST = 3.0  # prior deviations that a link or a drive may move at most
LET_GO = 1.5  # prior deviation of each of the ten numbers of a link that is let go, relative to what is stated
HELD = 1e12  # prior precision of a strength that must not move


@dataclass(frozen=True)
class Nuisance:
    """What is refitted: levels first, then zeros, drives, links, and oscillations, in the order of their columns.

    Links are either kept within the range that stated ones are off by (``links``) or let go (``inertias``), not both.
    ``uneven`` is how uneven the machine is, 1 for one that is as uneven as real ones are: a cause has to stand out from
    that.  ``wavy`` is how large the waves along the stroke are that at least two joints show beside all known causes,
    relative to the joints' friction: a wave that is a cause has to stand out from these.
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
        """All refitted parts, in order."""
        links = self.links if self.inertias is None else (self.inertias,)
        return [*self.levels, *self.zeros, *self.drives, *links, *self.oscillations]

    @functools.cached_property
    def columns(self) -> Columns:
        """All columns, in order."""
        joints = dict.fromkeys(joint for part in self.parts for joint in part.columns)
        return {joint: np.hstack([_of_joint(part, joint) for part in self.parts]) for joint in joints}

    @property
    def precision(self) -> Floats:
        """The prior precision of all strengths, in order, (count,)."""
        known = np.concatenate([part.precision for part in self.parts]) if self.parts else np.empty(0)
        known[self.of_zeros] /= self.uneven**2
        return known

    @property
    def reach(self) -> Floats:
        """How far from zero the strengths of zeros, drives and links may go, in order."""
        farthest = np.full(self.count, FARTHEST)
        farthest[self.of_zeros] = OUT_OF_CHANCE
        return (farthest / np.sqrt(self.precision))[self.of_bounded]

    @property
    def count(self) -> int:
        """The number of columns."""
        return sum(part.precision.size for part in self.parts)

    def of_level(self, joint: int) -> slice:
        """Return the slice of the two strengths of a joint's levels.

        Raises :class:`ValueError` if they are held as stated.
        """
        i = [level.site.joint for level in self.levels].index(joint)
        return slice(2 * i, 2 * i + 2)

    @property
    def of_zeros(self) -> slice:
        """The slice of the zeros' strengths, one for each."""
        first = 2 * len(self.levels)
        return slice(first, first + len(self.zeros))

    @property
    def of_drives(self) -> slice:
        """The slice of the drives' strengths, one for each."""
        first = self.of_zeros.stop
        return slice(first, first + len(self.drives))

    @property
    def of_links(self) -> slice:
        """The slice of the links' strengths, four for each."""
        first = self.of_drives.stop
        return slice(first, first + PER_LINK * len(self.links))

    def link_changes(self, strengths: Floats) -> Floats:
        """Return the change of each refitted link: of its scale, relative, and of its centre, m, (links, 4)."""
        return strengths[self.of_links].reshape(-1, PER_LINK)

    @property
    def of_inertias(self) -> slice:
        """The slice of the strengths of links that were let go, ten for each."""
        first = self.of_links.stop
        return slice(first, first + (self.inertias.precision.size if self.inertias else 0))

    @property
    def of_stated(self) -> slice:
        """The slice of the strengths whose usual error is known: the drives' and the links'."""
        return slice(self.of_drives.start, self.of_inertias.stop)

    @property
    def of_bounded(self) -> slice:
        """The slice of the strengths that are kept within a reach: the zeros', the drives' and the links'."""
        return slice(self.of_zeros.start, self.of_links.stop)

    @property
    def of_oscillations(self) -> slice:
        """The slice of the oscillations' strengths, which are last."""
        return slice(self.of_inertias.stop, self.count)

    @property
    def sources(self) -> tuple[Source, ...]:
        """The source of each oscillation."""
        return tuple(one.source for one in self.oscillations)

    def without_level(self, joint: int) -> Nuisance:
        """Return the nuisances with one joint's levels held as stated."""
        return replace(self, levels=tuple(level for level in self.levels if level.site.joint != joint))

    def with_level_near(self, joint: int, stated: tuple[float, float], spread: float) -> Nuisance:
        """Return the nuisances with one joint's levels near what is ``stated``, with ``spread`` as their relative prior
        deviation; a level that is stated as zero is held.
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

    def with_links_nearer(self, share: float) -> Nuisance:
        """Return the nuisances with links kept near what is stated by a ``share`` of their usual deviations."""
        return replace(self, links=tuple(replace(link, precision=link.precision / share**2) for link in self.links))

    def with_links_let_go(self, gap: Gap) -> Nuisance:
        """Return the nuisances with all links let go that the motion of a gap shows."""
        return replace(self, links=(), inertias=link_inertias(gap, LET_GO))

    def without_zeros(self) -> Nuisance:
        """Return the nuisances with no zero refitted: efforts read zero where there is none."""
        return replace(self, zeros=())

    def without_drives(self) -> Nuisance:
        """Return the nuisances with every drive as stated."""
        return replace(self, drives=())

    def along(self, gap: Gap, sources: Sequence[Source]) -> Nuisance:
        """Return the same nuisances for another gap of the log, with an oscillation from each of ``sources``."""
        like = make_nuisance(gap, sources, drives=bool(self.drives))
        own = {level.site.joint: level for level in self.levels}
        zeros, drives = {zero.site for zero in self.zeros}, {(type(one.cause), one.site) for one in self.drives}
        near = {link.name: link.precision for link in self.links}
        found = replace(
            like,
            levels=tuple(level.near_as(own[level.site.joint]) for level in like.levels if level.site.joint in own),
            zeros=tuple(zero for zero in like.zeros if zero.site in zeros),
            drives=tuple(one for one in like.drives if (type(one.cause), one.site) in drives),
            links=tuple(replace(one, precision=near[one.name]) for one in like.links if one.name in near),
            uneven=self.uneven,
            wavy=self.wavy,
        )
        return found if self.inertias is None else found.with_links_let_go(gap)


def make_nuisance(gap: Gap, sources: Sequence[Source] = (), *, drives: bool = False) -> Nuisance:
    """Build the nuisances of a gap, with an oscillation from each of ``sources``; with ``drives``, the stated values of
    the drives are refitted too.
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
