"""What a cause is: one change to the robot's torque balance, linear in its strengths, with a few shape parameters.

Adding a cause is one file with one class, and one line in :mod:`~mjfriction.diagnose.causes.catalog`.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import ClassVar, Literal

import numpy as np
from numpy.typing import NDArray

from mjfriction.identify.gap import Gap
from mjfriction.identify.regression import Columns
from mjfriction.parameter import Parameter
from mjfriction.record.log import Floats
from mjfriction.robot.robot import Robot

SHIFTS = 61  # moments (or loads) sampled along a cause's course, any of which the stated levels may belong to
UNCONSTRAINED = 100.0  # prior deviation of a cause's effort, in multiples of the joint's RMS effort
AROUND_STEPS = 9  # number of strengths tried around one of a grid

Shape = tuple[float, ...]
Picture = Literal["covariate", "turned", "spectrum", "turned_spectrum", "travel", "loop"]


@dataclass(frozen=True)
class Site:
    """A place where a cause is tried: one joint (its index), with values for the cause's shape parameters.

    ``other`` is the joint that the effect comes from, where it comes from another one.  ``around`` is the strength
    around which a curved cause's columns are computed, 0 for the stated robot.  ``order`` numbers the causes of one
    kind on the joint, from 0.  ``begin`` is the time (s, on the log's clock) at which a course of time starts, and
    ``end`` the time at which it is over.
    """

    joint: int
    shape: Shape = ()
    other: int | None = None
    around: float = 0.0
    order: int = 0
    begin: float = 0.0
    end: float = math.inf

    def shaped(self, shape: Shape) -> Site:
        """Return the same site with another shape."""
        return replace(self, shape=shape)


@dataclass(frozen=True)
class Quantity:
    """A fitted quantity as it is reported: its declaration, and value = ``shift`` + ``factor`` · strength.

    ``before_sensor`` says whether its effect passes the effort sensor's scale, as all torques do.
    """

    parameter: Parameter
    factor: float = 1.0
    shift: float = 0.0
    before_sensor: bool = True


class Cause(ABC):
    """One cause.  Instances hold no state, and most concrete causes are final."""

    name: ClassVar[str]
    shape_parameters: ClassVar[tuple[Parameter, ...]] = ()
    relative_shape: ClassVar[bool] = True  # whether shape parameters are positive and searched in relative steps
    covariate: ClassVar[str] = "velocity"
    picture: ClassVar[Picture] = "covariate"  # the kind of figure that shows it best
    # Whether the whole arm feels it.  Its site is then the joint where it shows most or, for links, the moved link's.
    whole_arm: ClassVar[bool] = False
    curved: ClassVar[bool] = False  # whether the effort is nonlinear in the strengths: refitted on the full balance
    tangent_step: ClassVar[float] = 1e-3  # relative step of a strength, for the difference quotient of its tangent
    around_rounds: ClassVar[int] = 1  # how often sites around the best so far are tried, where any of them is better
    ranked_alone: ClassVar[bool] = False  # whether it is screened on the effort of its own joint only
    of_sensor: ClassVar[bool] = False  # whether it acts on all torques, including those of other causes
    of_body: ClassVar[bool] = False  # whether it changes the links' loads, on which other causes' effects depend
    everywhere: ClassVar[bool] = False  # whether every machine has a little of it, however little else is wrong
    brief: ClassVar[bool] = False  # whether its effort comes in few rows, as that of a play's landings
    brief_in_passes: ClassVar[bool] = False  # the same of a motion whose speed is constant but for its ends
    # The least size of its peak effort, beyond what refitted levels can absorb, relative to the joint's friction.
    least_of_friction: ClassVar[float] = 0.04
    least_told: ClassVar[float] = 0.0  # the same for it to be reported, if higher: below it is only refitted along
    # How many times the mean square that is left at a joint it must remove there to be reported.
    least_cleared: ClassVar[float] = 0.0
    of_unevenness: ClassVar[bool] = False  # whether machines that are merely uneven along their strokes show it too
    times: ClassVar[int] = 1  # how many of its kind a joint may have
    first_order: ClassVar[int] = 0  # first value of their order: causes of one name with different ones count apart
    # Names of causes that equal this one with some strengths at zero.  This one is then no rival of theirs, unless the
    # motion leaves its further strengths uncertain.
    contains: ClassVar[tuple[str, ...]] = ()
    fuller: ClassVar[tuple[type[Cause], ...]] = ()  # the same cause with one more strength, tried once this is found
    # The same cause with fewer shapes, before this one in the catalog.  Where that gains nothing, this one is not
    # screened.
    simpler: ClassVar[type[Cause] | None] = None
    # The same cause with more strengths: it may replace this one, alone or together with another cause beside it.
    richer: ClassVar[type[Cause] | None] = None
    kin: ClassVar[tuple[str, ...]] = ()  # names of causes that are the other half of this one, tried once it is found

    def sites(self, gap: Gap) -> list[Site]:
        """Return the sites to try, with a starting grid of shapes: by default every examined joint."""
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

    def spreads(self) -> float | Floats:
        """Return the prior deviation of each strength's effort, in multiples of the joint's RMS effort: by default so
        large that it practically does not constrain.
        """
        return UNCONSTRAINED

    def admissible(self, gap: Gap, site: Site, strengths: Floats) -> bool:
        """Return whether fitted strengths are physical; by default all are."""
        return True

    def promising(self, gap: Gap, site: Site, strengths: Floats) -> bool:
        """Return whether strengths that are not admissible, but gain much in a screening, may be at a shape that the
        screening left out; by default they may not.
        """
        return False

    def known_where(self, gap: Gap, site: Site) -> dict[int, NDArray[np.bool_]]:
        """Return, by joint, the rows (rows,) in which it is known what the cause brings; by default this is known
        wherever the joint's own friction is.
        """
        return {}

    def told_at(self, site: Site) -> int:
        """Return the joint at which the cause is reported: by default its own."""
        return site.joint

    def taken_level(self, strengths: Floats) -> float:
        """Return how much of the joint's Coulomb level the cause moves into a law of its own: by default none."""
        return 0.0

    def brought_level(self, strengths: Floats) -> float:
        """Return how much friction near rest the cause adds to the joint's Coulomb level: by default none."""
        return 0.0

    def level_shifts(self, gap: Gap, site: Site, strengths: Floats) -> Floats:
        """Return how far the cause shifts Coulomb level and damping at each moment, or load, to which the stated levels
        may belong, (moments, 2): by default at none.
        """
        return np.empty((0, 2))

    def chances(self, sites: Sequence[Site]) -> int:
        """Return how many of the sites the motion can tell apart, to count candidates: by default all."""
        return len(sites)

    def noteworthy(self, gap: Gap, site: Site, strengths: Floats) -> bool:
        """Return whether the cause, once fitted, is a finding; otherwise it is only refitted along."""
        return True

    def usual(self, gap: Gap, site: Site, strengths: Floats) -> bool:
        """Return whether the change is within the usual error of such stated values on a robot that is not stated
        exactly, so that it is no finding there: by default it is not.
        """
        return False

    def least_change(self, gap: Gap, site: Site) -> float:
        """Return how large the first strength must be to be a finding on any robot, however exactly that is stated: by
        default any is.
        """
        return 0.0

    def shape_bounds(self, gap: Gap, site: Site) -> list[tuple[float, float]]:
        """Return the range each shape parameter is searched in."""
        return []

    def bounds_beside_stated_levels(self, gap: Gap, site: Site) -> list[tuple[float, float]]:
        """Return the ranges of shape parameters that are searched only while friction levels are held as stated.

        Free levels would make up for any such shape.  By default there are none.
        """
        return []

    def own_shape(self, gap: Gap, site: Site) -> bool:
        """Return whether a shape found by the search still belongs to this cause.

        A search that ends at the edge of its range may have found something else.  By default every shape belongs.
        """
        return True

    def usual_bounds(self, gap: Gap, site: Site) -> list[tuple[float, float]]:
        """Return the range of each shape parameter that such causes usually have, which is searched where the best of
        all shapes does not belong to the cause: by default there is none.
        """
        return []

    def apart(self, gap: Gap, site: Site, other: Site) -> bool:
        """Return whether the motion can tell a site from that of another cause of the same name on the joint: by
        default it can.
        """
        return True

    def shape_resolution(self, gap: Gap, site: Site) -> tuple[float, ...]:
        """Return the least half-width to which the rows can determine each shape parameter: by default 0, no limit."""
        return tuple(0.0 for _ in site.shape)

    def around_sites(self, gap: Gap, site: Site) -> list[Site]:
        """Return neighbouring sites to try as well, where columns are computed around a strength: by default none."""
        return []

    def shape_steps(self, gap: Gap, site: Site) -> tuple[float, ...]:
        """Return the first step of each shape parameter when it is searched: by default a tenth of its value."""
        return tuple(0.1 * value for value in site.shape)

    def screening(self, gap: Gap, sites: Sequence[Site], every: int) -> Columns:
        """Return the columns of many shapes on one joint at once, accurate enough to rank them.

        Only every ``every``-th row is returned: (rows/every, shapes, strengths).
        """
        blocks = [self.columns(gap, site) for site in sites]
        return {joint: np.stack([block[joint][::every] for block in blocks], axis=1) for joint in blocks[0]}

    @abstractmethod
    def columns(self, gap: Gap, site: Site) -> Columns:
        """Return the cause's regressor columns at every joint that feels it, through the measurement chain."""

    def columns_of(self, gap: Gap, sites: Sequence[Site]) -> list[Columns]:
        """Return the columns of many sites of one joint; causes that have them quicker all at once override this."""
        return [self.columns(gap, site) for site in sites]


class JointCause(Cause):
    """A cause that acts as a torque at its own joint only."""

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
    """Return sites whose columns are computed around strengths up to ``finer`` times smaller and larger."""
    strengths = np.geomspace(site.around / finer, site.around * finer, AROUND_STEPS)
    return [replace(site, around=float(strength)) for strength in strengths]
