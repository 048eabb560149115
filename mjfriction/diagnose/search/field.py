"""The candidates of a diagnosis: every cause at every joint where it may occur."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from mjfriction.diagnose.causes.cause import Cause, Site
from mjfriction.diagnose.causes.saturating_viscous import AbruptlySaturating
from mjfriction.diagnose.causes.steepening_viscous import RootViscous
from mjfriction.diagnose.causes.stribeck import LorentzianStribeck, UnfinishedStribeck
from mjfriction.diagnose.fit.model import Model
from mjfriction.identify.gap import Gap
from mjfriction.robot.friction import stated_levels


@dataclass(frozen=True)
class Entrant:
    """A cause at a joint, with every shape of its starting grid; the joint may have up to ``times`` of its kind."""

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
        """The unit of refusal: this implementation of the cause, at this joint."""
        return type(self.cause), self.joint


Field = tuple[Entrant, ...]


def make_field(gap: Gap, causes: tuple[Cause, ...]) -> Field:
    """Return every cause at every joint where it may occur."""
    entrants = []
    for cause in causes:
        sites = cause.sites(gap)
        for joint in dict.fromkeys(site.joint for site in sites):
            own = tuple(site for site in sites if site.joint == joint)
            entrants.append(Entrant(cause, joint, own, cause.times))
    return tuple(entrants)


def in_place_of_levels(gap: Gap, joint: int, *, bent: bool = False) -> Field:
    """Return the candidates that may only take the place of a joint's refitted levels or, if ``bent``, of these and a
    curve that bends beside them.

    Alone, a level is as good as damping that levels off at once. So is one at a joint without stated friction, where
    nothing says which of it is level.
    """
    curves: tuple[Cause, ...] = (UnfinishedStribeck(),)
    if bent and stated_levels(gap.robot.table.joint[joint])[0] > 0.0:
        curves += (LorentzianStribeck(), AbruptlySaturating(), RootViscous())
    return tuple(entrant for entrant in make_field(gap, curves) if entrant.joint == joint)


def size(field: Field) -> int:
    """Return how many candidates a field holds, counting every shape that the motion tells apart: the number of chances
    for a false alarm.
    """
    return sum(entrant.cause.chances(entrant.sites) for entrant in field)


@dataclass(frozen=True)
class Chances:
    """The number of chances for a false alarm in a field: ``whole`` in all, and ``own`` by kind of cause.

    The stated false-alarm level is divided: one half equally among all candidates, the other half equally among the
    kinds of causes. Of two thousand candidates most are shapes of waves; six torque constants need not stand out as if
    they had been picked from all of these.
    """

    whole: int
    own: Mapping[type[Cause], int]

    def among(self, cause: Cause) -> float:
        """Return the effective number of candidates that a cause is picked from: one over its share of the level."""
        if type(cause) not in self.own:
            return float(self.whole)
        return 2.0 / (1.0 / self.whole + 1.0 / (len(self.own) * self.own[type(cause)]))


def chances_in(field: Field) -> Chances:
    """Return the number of chances for a false alarm in a field."""
    own: dict[type[Cause], int] = {}
    for entrant in field:
        own[type(entrant.cause)] = own.get(type(entrant.cause), 0) + entrant.cause.chances(entrant.sites)
    return Chances(size(field), own)


def present(model: Model, entrant: Entrant) -> int:
    """Return how many causes of an entrant's kind a model has at its joint."""
    return sum(
        (choice.cause.name, choice.site.joint) == entrant.key and choice.cause.first_order == entrant.cause.first_order
        for choice in model.chosen
    )
