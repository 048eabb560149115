"""The parts that are refitted with every candidate: their columns and their prior precision."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from mjfriction.diagnose.causes.catalog import STATED_LEVELS
from mjfriction.diagnose.causes.cause import Cause, Site
from mjfriction.diagnose.causes.offset import Offset
from mjfriction.diagnose.causes.rotor_inertia import RotorInertia
from mjfriction.diagnose.causes.torque_constant import TorqueConstant
from mjfriction.identify.gap import Gap
from mjfriction.identify.link_inertias import LinkInertias
from mjfriction.identify.regression import Columns
from mjfriction.identify.swing import Swing
from mjfriction.identify.tone import Tone
from mjfriction.record.log import Floats
from mjfriction.robot.friction import stated_levels

FEWEST_JOINTS = 3  # joints that it takes to know how exactly a machine is stated, or how even it is
OUT_OF_CHANCE = 5.0  # deviations that chance does not reach, however many candidates a value is picked from
# Prior deviation of a zero, as a share of the joint's Coulomb level.  OUT_OF_CHANCE of these are the least size of an
# offset: what is larger is one.
ZERO = Offset.least_of_friction / OUT_OF_CHANCE
PER_LINK = 4  # strengths of a refitted link: a scale and three shifts
LINK_SCALE = 0.03  # prior deviation of the mass and inertia of a stated link, relative
LINK_SHIFT = 0.002  # m, prior deviation of its centre of mass along each axis
ROTOR, CONSTANT = 0.04, 0.015  # prior deviations of a drive's rotor inertia and torque constant, relative
LEVEL_SCALE = 10.0  # prior deviation of a level, in multiples of the joint's RMS effort: practically unconstrained


@dataclass(frozen=True)
class Level:
    """The Coulomb and viscous level of one joint: two columns.

    If the levels are kept near what is stated, ``free`` is the precision that they would have if they were free.
    """

    site: Site
    columns: Columns
    precision: Floats
    free: Floats | None = None

    @property
    def near(self) -> bool:
        """Whether the levels are kept near what is stated."""
        return self.free is not None

    def near_as(self, other: Level) -> Level:
        """Return the levels kept as near to what is stated as another's."""
        return replace(self, precision=other.precision, free=self.precision) if other.near else self

    def freed(self) -> Level:
        """Return the levels with the precision of free ones."""
        return self if self.free is None else replace(self, precision=self.free, free=None)


@dataclass(frozen=True)
class Zero:
    """What one joint's effort reads where there is none: one column; ``precision`` is for a machine as uneven as real
    ones are.
    """

    site: Site
    columns: Columns
    precision: Floats


@dataclass(frozen=True)
class Drive:
    """A data sheet value of a joint's drive, which may be off as ``cause`` describes: one column, per relative change
    of the stated value.

    ``stated`` is the strength of the cause that changes the value by the whole of itself.
    """

    cause: Cause
    site: Site
    stated: float
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
    """The effect of a steady tone or of a load that swings on its joint: some columns."""

    source: Source
    columns: Columns
    precision: Floats


Part = Level | Zero | Drive | Link | LinkInertias | Oscillation


def levels_of(gap: Gap) -> tuple[Level, ...]:
    """Return the levels of every joint along a gap, practically unconstrained."""
    levels = []
    for site in STATED_LEVELS.sites(gap):
        speed = float(np.sqrt(np.mean(np.square(gap.motion.velocity[:, site.joint]))))
        precision = np.square(np.array([1.0, speed])) * _next_to_free(gap, site.joint)
        levels.append(Level(site, STATED_LEVELS.columns(gap, site), precision))
    return tuple(levels)


def zeros_of(gap: Gap) -> tuple[Zero, ...]:
    """Return the zeros of the examined joints that have a Coulomb level; none with fewer than FEWEST_JOINTS joints.

    With so few joints, the residual shows how even they are, and thereby already what counts as an offset.
    """
    coulomb = {joint: stated_levels(gap.robot.table.joint[joint])[0] for joint in gap.examined}
    return tuple(
        Zero(Site(joint), Offset().columns(gap, Site(joint)), np.array([(ZERO * level) ** -2.0]))
        for joint, level in coulomb.items()
        if level > 0.0 and len(coulomb) >= FEWEST_JOINTS
    )


def drives_of(gap: Gap) -> tuple[Drive, ...]:
    """Return the rotor inertia, if one is stated, and the torque constant of every examined joint."""
    out = []
    for joint in gap.examined:
        rotor = gap.robot.table.joint[joint].actuator.reflected_inertia
        for cause, stated, off in ((RotorInertia(), rotor, ROTOR), (TorqueConstant(), 1.0, CONSTANT)):
            if stated > 0.0:
                columns = {joint: stated * cause.columns(gap, Site(joint))[joint]}
                out.append(Drive(cause, Site(joint), stated, columns, np.array([off**-2.0])))
    return tuple(out)


def links_of(gap: Gap) -> tuple[Link, ...]:
    """Return the links that any examined joint feels."""
    links = []
    for k, name in enumerate(gap.body.links):
        block = {joint: rows[:, k, :PER_LINK] for joint, rows in gap.link_rows.items()}
        if any(np.any(values) for values in block.values()):
            links.append(Link(name, block, np.array([LINK_SCALE**-2.0, *[LINK_SHIFT**-2.0] * 3])))
    return tuple(links)


def oscillations_of(gap: Gap, sources: Sequence[Source]) -> tuple[Oscillation, ...]:
    """Return the oscillation of each of ``sources`` along a gap, practically unconstrained."""
    oscillations = []
    for source in sources:
        columns = source.columns(gap)
        precision = np.full(columns.shape[1], _next_to_free(gap, source.joint))
        oscillations.append(Oscillation(source, {source.joint: columns}, precision))
    return tuple(oscillations)


def _next_to_free(gap: Gap, joint: int) -> float:
    # The prior precision of an effort (N·m or N) at a joint of which hardly anything is known.
    effort = float(np.sqrt(np.mean(np.square(gap.measured[:, joint]))))
    return 1.0 / (LEVEL_SCALE * effort) ** 2
