"""What a cause is: one change to the balance of the robot, linear in its strengths, with a few shape parameters.

Adding a cause is one file with one class, and one line in :mod:`~mjfriction.diagnose.causes.catalog`.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import ClassVar, Literal

import numpy as np

from mjfriction.identify.gap import Gap
from mjfriction.identify.regression import Columns
from mjfriction.parameter import Parameter
from mjfriction.record.log import Floats
from mjfriction.robot.robot import Robot

SHIFTS = 61  # of all that stated levels may be those of, that are asked
AROUND_STEPS = 9  # strengths that are tried around one of a grid

Shape = tuple[float, ...]
Picture = Literal["covariate", "turned", "spectrum", "turned_spectrum", "travel", "loop"]


@dataclass(frozen=True)
class Site:
    """A cause at a place: on one joint (its index), with values for its shape parameters.

    ``other`` is the joint that it comes from, where it comes from one; ``around`` the strength that a curved cause's
    columns are drawn around, 0 for the stated robot; ``order`` counts those of its kind on the joint, from 0; ``begin``
    is the moment (s, on the log's clock) from which a course of time is counted, ``end`` that at which it is over.
    """

    joint: int
    shape: Shape = ()
    other: int | None = None
    around: float = 0.0
    order: int = 0
    begin: float = 0.0
    end: float = math.inf

    def shaped(self, shape: Shape) -> Site:
        """Return the same place with another shape."""
        return replace(self, shape=shape)


@dataclass(frozen=True)
class Quantity:
    """A fitted quantity as a person reads it: its declaration, and value = ``shift`` + ``factor`` · strength."""

    parameter: Parameter
    factor: float = 1.0
    shift: float = 0.0


class Cause(ABC):
    """One cause.  Concrete causes are final; they hold no state."""

    name: ClassVar[str]
    shape_parameters: ClassVar[tuple[Parameter, ...]] = ()
    relative_shape: ClassVar[bool] = True  # whether shapes are positive, and searched in steps relative to themselves
    covariate: ClassVar[str] = "velocity"
    picture: ClassVar[Picture] = "covariate"  # what shows it best
    whole_arm: ClassVar[bool] = False  # whether every joint feels it; its site is then where it shows most
    curved: ClassVar[bool] = False  # whether the effort bends with the strengths: then fitted on the real balance
    tangent_step: ClassVar[float] = 1e-3  # of a strength, over which what it changes is followed by a line
    ranked_alone: ClassVar[bool] = False  # whether it is screened by what its own joint feels of it alone
    of_sensor: ClassVar[bool] = False  # whether it acts on whatever torques there are, those of other causes too
    of_body: ClassVar[bool] = False  # whether it changes the links' loads, with which effects of others grow
    least_of_friction: ClassVar[float] = 0.04  # of the joint's friction, that it must be at its most beside levels
    least_told: ClassVar[float] = 0.0  # the same for it to be told, where that is more: else it is refitted along
    of_unevenness: ClassVar[bool] = False  # whether machines that are only uneven along their strokes show it too
    times: ClassVar[int] = 1  # how many of its kind a joint may have
    first_order: ClassVar[int] = 0  # from which on they count: others of its name that begin elsewhere count apart
    before_sensor: ClassVar[bool] = True  # whether the change passes the effort sensor's scale, as all torques do
    contains: ClassVar[tuple[str, ...]] = ()  # causes that are this one with a strength at zero: no rivals of theirs
    fuller: ClassVar[type[Cause] | None] = None  # the same with one strength more, asked for once it is found
    richer: ClassVar[type[Cause] | None] = None  # the same with more strengths, in place of it and of another beside it
    kin: ClassVar[
        tuple[str, ...]
    ] = ()  # causes that are the other half of the same thing, asked for once this is found

    def sites(self, gap: Gap) -> list[Site]:
        """Return where the cause may sit, with a starting grid of shapes: by default every examined joint."""
        return [Site(joint) for joint in gap.examined]

    @abstractmethod
    def quantities(self, gap: Gap, site: Site) -> tuple[Quantity, ...]:
        """Return what each strength means, in order."""

    @abstractmethod
    def extend(self, robot: Robot, site: Site, strengths: Floats) -> Robot:
        """Return the robot with the cause built in."""

    @abstractmethod
    def evidence(self, gap: Gap, site: Site, strengths: Floats) -> str:
        """Say in one sentence where in the data the cause shows."""

    def admissible(self, gap: Gap, site: Site, strengths: Floats) -> bool:
        """Return whether fitted strengths are physical; by default all are."""
        return True

    def told_at(self, site: Site) -> int:
        """Return the joint that the cause is told of: by default its own."""
        return site.joint

    def taken_level(self, strengths: Floats) -> float:
        """Return how much of the joint's Coulomb level the cause moves into a law of its own: by default none."""
        return 0.0

    def brought_level(self, strengths: Floats) -> float:
        """Return how much friction near rest the cause adds to the joint's Coulomb level: by default none."""
        return 0.0

    def level_shifts(self, gap: Gap, site: Site, strengths: Floats) -> Floats:
        """Return what the cause moves Coulomb level and damping by at each of the moments, or loads, that stated levels
        may be those of, (moments, 2): by default at none.
        """
        return np.empty((0, 2))

    def chances(self, sites: Sequence[Site]) -> int:
        """Return how many of the places the motion tells apart: by default all."""
        return len(sites)

    def noteworthy(self, gap: Gap, site: Site, strengths: Floats) -> bool:
        """Return whether the cause, once fitted, is a finding; else it is a value refitted along."""
        return True

    def usual(self, gap: Gap, site: Site, strengths: Floats) -> bool:
        """Return whether the change is within what such stated values are off by on any robot that is not stated
        exactly, and so is no finding there: by default it is not.
        """
        return False

    def shape_bounds(self, gap: Gap, site: Site) -> list[tuple[float, float]]:
        """Return the range each shape parameter is searched in."""
        return []

    def bounds_beside_stated_levels(self, gap: Gap, site: Site) -> list[tuple[float, float]]:
        """Return the range of shape parameters that are searched only where friction levels are held as stated: free
        ones make up for any shape.  By default there are none.
        """
        return []

    def own_shape(self, gap: Gap, site: Site) -> bool:
        """Return whether a shape that was searched is one of the cause: a search that ends at the edge of its range may
        have found something else.  By default every shape is.
        """
        return True

    def apart(self, gap: Gap, site: Site, other: Site) -> bool:
        """Return whether the motion tells a place and shape from those of another cause of its kind on the joint: by
        default it does.
        """
        return True

    def shape_resolution(self, gap: Gap, site: Site) -> tuple[float, ...]:
        """Return how finely the rows can tell each shape parameter at best: by default as finely as the fit says."""
        return tuple(0.0 for _ in site.shape)

    def around_sites(self, gap: Gap, site: Site) -> list[Site]:
        """Return the places near one that are tried besides, where columns are drawn around a strength; by default none
        is.
        """
        return []

    def shape_steps(self, gap: Gap, site: Site) -> tuple[float, ...]:
        """Return how far each shape parameter is moved at first when it is searched: by default a tenth of itself."""
        return tuple(0.1 * value for value in site.shape)

    def screening(self, gap: Gap, sites: Sequence[Site], every: int) -> Columns:
        """Return the columns of many shapes on one joint at once, good enough to rank them.

        Of the rows only each ``every``-th is asked for: (rows/every, shapes, strengths).
        """
        blocks = [self.columns(gap, site) for site in sites]
        return {joint: np.stack([block[joint][::every] for block in blocks], axis=1) for joint in blocks[0]}

    @abstractmethod
    def columns(self, gap: Gap, site: Site) -> Columns:
        """Return the cause's regressor columns at every joint that feels it, through the measurement chain."""


class JointCause(Cause):
    """A cause that is a torque at its own joint and at no other."""

    @abstractmethod
    def samples(self, gap: Gap, site: Site) -> Floats:
        """Return the effort per unit strength along the motion, (n, strengths), at the joint, before the sensor."""

    def columns(self, gap: Gap, site: Site) -> Columns:
        """The torque as the joint's drive reports it."""
        return {site.joint: gap.reported(site.joint, self.samples(gap, site))}


def column(values: Floats) -> Floats:
    """Return (n,) as one column (n, 1)."""
    return np.asarray(values)[:, None]


def near_around(site: Site, finer: float) -> list[Site]:
    """Return places whose columns are drawn around strengths up to ``finer`` times smaller and larger."""
    strengths = np.geomspace(site.around / finer, site.around * finer, AROUND_STEPS)
    return [replace(site, around=float(strength)) for strength in strengths]
