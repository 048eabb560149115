"""The candidates of a diagnosis: every cause at every joint it may sit on."""

from __future__ import annotations

from dataclasses import dataclass

from mjfriction.diagnose.causes.cause import Cause, Site
from mjfriction.diagnose.causes.stribeck import UnfinishedStribeck
from mjfriction.diagnose.model import Model
from mjfriction.identify.gap import Gap


@dataclass(frozen=True)
class Entrant:
    """A cause on a joint, with every shape of its starting grid; ``times`` is how many of it the joint may have."""

    cause: Cause
    joint: int
    sites: tuple[Site, ...]
    times: int

    @property
    def key(self) -> tuple[str, int]:
        """The cause's name and its joint."""
        return self.cause.name, self.joint

    @property
    def kind(self) -> tuple[type[Cause], int]:
        """What is refused when it is refused: this way to draw the cause, at this joint."""
        return type(self.cause), self.joint


Field = tuple[Entrant, ...]


def make_field(gap: Gap, causes: tuple[Cause, ...]) -> Field:
    """Return every cause at every joint it may sit on."""
    entrants = []
    for cause in causes:
        sites = cause.sites(gap)
        for joint in dict.fromkeys(site.joint for site in sites):
            own = tuple(site for site in sites if site.joint == joint)
            entrants.append(Entrant(cause, joint, own, cause.times))
    return tuple(entrants)


def in_place_of_levels(gap: Gap, joint: int) -> Field:
    """Return what may stand in the place of a joint's refitted levels alone."""
    return tuple(entrant for entrant in make_field(gap, (UnfinishedStribeck(),)) if entrant.joint == joint)


def size(field: Field) -> int:
    """Return how many candidates a field holds, every shape counted that is told from others: how often chance may
    strike.
    """
    return sum(entrant.cause.chances(entrant.sites) for entrant in field)


def present(model: Model, entrant: Entrant) -> int:
    """Return how many of an entrant's kind a model has at its joint."""
    return sum((choice.cause.name, choice.site.joint) == entrant.key for choice in model.chosen)
