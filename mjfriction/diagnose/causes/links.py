"""body.link_inertia: a link's mass and inertia are a factor off, its centre of mass lies elsewhere, or only its moments
of inertia about that centre are a factor off.
"""

from __future__ import annotations

from typing import ClassVar, final

import numpy as np

from mjfriction.diagnose.causes.cause import Cause, Quantity, Site
from mjfriction.identify.gap import Gap
from mjfriction.identify.regression import Columns
from mjfriction.parameter import Parameter
from mjfriction.record.log import Floats
from mjfriction.robot.links import (
    link_scale,
    link_shift,
    moments_of_a_body,
    scaled_link,
    shifted_link,
    with_moments,
)
from mjfriction.robot.robot import Robot

LEAST_NOTED = 0.08  # relative change of a link's mass above which it is a finding: stated masses are no better
LEAST_ALONE = 0.02  # the same where everything else is stated exactly
LEAST_MOVED = 0.01  # m, shift of a centre of mass above which it is a finding: most models omit cables and covers
LEAST_MOVED_ALONE = 0.004  # the same where everything else is stated exactly
LEAST_MOMENTS = 0.25  # relative change of a link's moments of inertia above which it is a finding
MOST_MOMENTS = 50.0  # times the stated moments, past which the motion does not show the link's
FARTHEST = 0.3  # m, largest shift of a centre of mass
FELT = 1e-6  # fraction of the RMS effort up to which a link counts as not felt


class _Link(Cause):
    """A change of one link.  Its site is the joint that moves the link, although all joints before it feel it too."""

    name = "body.link_inertia"
    covariate = "effort"
    whole_arm = True
    of_body = True
    part: ClassVar[slice]  # the cause's own columns among the five of each link in a gap's link rows

    def sites(self, gap: Gap) -> list[Site]:
        """Every link of the robot's own joints that any examined joint feels."""
        least = FELT * float(np.sqrt(np.mean(np.square(np.nan_to_num(gap.measured)))))
        sites = [Site(gap.robot.joints.index(name)) for name in gap.body.links if name in gap.robot.joints]
        return [s for s in sites if any(np.max(np.abs(c)) > least for c in self.columns(gap, s).values())]

    def columns(self, gap: Gap, site: Site) -> Columns:
        """The efforts at every examined joint, through the measurement chain."""
        link = gap.body.links.index(gap.robot.joints[site.joint])
        return {joint: rows[:, link, self.part] for joint, rows in gap.link_rows.items()}


class _ScaledLink(_Link):
    """Mass and inertia of one link are off by a factor."""

    part = slice(0, 1)
    least: ClassVar[float]  # relative change of the link's mass above which it is a finding

    def quantities(self, gap: Gap, site: Site) -> tuple[Quantity, ...]:
        """The factor, stated times change."""
        name = gap.robot.joints[site.joint]
        stated = link_scale(gap.robot, name)
        meaning = "mass and inertia of the link that the joint moves, relative to the model file"
        return (Quantity(Parameter(f"link_scale.{name}", "1", meaning, lower=0.0), factor=stated, shift=stated),)

    def admissible(self, gap: Gap, site: Site, strengths: Floats) -> bool:
        """A link has at least some of its stated mass, and not many times as much."""
        return bool(-0.95 < strengths[0] < 9.0)

    def noteworthy(self, gap: Gap, site: Site, strengths: Floats) -> bool:
        """More than the few percent by which stated masses are off."""
        return bool(abs(strengths[0]) > self.least)

    def extend(self, robot: Robot, site: Site, strengths: Floats) -> Robot:
        """Scale the link."""
        return scaled_link(robot, robot.joints[site.joint], 1.0 + float(strengths[0]))

    def evidence(self, gap: Gap, site: Site, strengths: Floats) -> str:
        """Give the factor."""
        factor, name = 1.0 + strengths[0], gap.robot.joints[site.joint]
        return f"all joints that carry the link of {name} need what {factor:.3g} times its stated mass and inertia need"


@final
class LinkScale(_ScaledLink):
    """One link, where others may be a few percent off too."""

    least = LEAST_NOTED


@final
class LoneLink(_ScaledLink):
    """One link, where everything else is stated exactly."""

    least = LEAST_ALONE


class _MovedLink(_Link):
    """The centre of mass of one link lies elsewhere."""

    curved = True
    part = slice(1, 4)
    least_moved: ClassVar[float] = LEAST_MOVED  # m, shift above which it is a finding

    def quantities(self, gap: Gap, site: Site) -> tuple[Quantity, ...]:
        """The shift, stated plus change."""
        name = gap.robot.joints[site.joint]
        stated = link_shift(gap.robot, name)
        axes = [Parameter(f"link_shift_{x}.{name}", "m", f"shift of the centre of mass along {x}") for x in "xyz"]
        return tuple(Quantity(axis, shift=shift) for axis, shift in zip(axes, stated, strict=True))

    def admissible(self, gap: Gap, site: Site, strengths: Floats) -> bool:
        """A shift within the size of a link."""
        return bool(np.linalg.norm(strengths) < FARTHEST)

    def noteworthy(self, gap: Gap, site: Site, strengths: Floats) -> bool:
        """More than the few millimetres by which stated centres are off."""
        return bool(np.linalg.norm(strengths) > self.least_moved)

    def extend(self, robot: Robot, site: Site, strengths: Floats) -> Robot:
        """Move the centre."""
        return shifted_link(robot, robot.joints[site.joint], strengths.tolist())

    def evidence(self, gap: Gap, site: Site, strengths: Floats) -> str:
        """Give the shift."""
        where = ", ".join(f"{1e3 * value:+.3g}" for value in strengths)
        return f"the link of {gap.robot.joints[site.joint]} has its centre of mass ({where}) mm from where it is stated"


@final
class LinkCentre(_MovedLink):
    """Only the centre of mass is off."""


@final
class LoneWholeLink(_MovedLink):
    """Mass and inertia of one link are off by a factor and its centre of mass is shifted, where everything else is
    stated exactly.
    """

    part = slice(0, 4)
    least_moved = LEAST_MOVED_ALONE
    scaled: ClassVar[_ScaledLink] = LoneLink()

    def quantities(self, gap: Gap, site: Site) -> tuple[Quantity, ...]:
        """The factor, then the shift."""
        return (*self.scaled.quantities(gap, site), *super().quantities(gap, site))

    def admissible(self, gap: Gap, site: Site, strengths: Floats) -> bool:
        """Both the factor and the shift are admissible."""
        return self.scaled.admissible(gap, site, strengths[:1]) and super().admissible(gap, site, strengths[1:])

    def noteworthy(self, gap: Gap, site: Site, strengths: Floats) -> bool:
        """The factor or the shift is large enough."""
        return self.scaled.noteworthy(gap, site, strengths[:1]) or super().noteworthy(gap, site, strengths[1:])

    def extend(self, robot: Robot, site: Site, strengths: Floats) -> Robot:
        """Scale the link, and move its centre."""
        return super().extend(self.scaled.extend(robot, site, strengths[:1]), site, strengths[1:])

    def evidence(self, gap: Gap, site: Site, strengths: Floats) -> str:
        """Give the factor and the shift."""
        scaled = self.scaled.evidence(gap, site, strengths[:1])
        return f"{scaled}; {super().evidence(gap, site, strengths[1:])}"


@final
class LinkMoments(_Link):
    """The moments of inertia of one link about its centre of mass are off by a factor, and its mass is right."""

    part = slice(4, 5)

    def sites(self, gap: Gap) -> list[Site]:
        """Of all links those with moments that a body can have, and on which no payload is stated."""
        payload, names = gap.robot.table.payload, gap.robot.joints
        laden = None if payload is None else gap.body.link_holding(payload.parent)
        return [
            s for s in super().sites(gap) if names[s.joint] != laden and moments_of_a_body(gap.robot, names[s.joint])
        ]

    def quantities(self, gap: Gap, site: Site) -> tuple[Quantity, ...]:
        """The factor."""
        name = gap.robot.joints[site.joint]
        meaning = "moments of inertia, about its centre, of the link that the joint moves, relative to what is stated"
        return (Quantity(Parameter(f"link_moments.{name}", "1", meaning, lower=0.0), shift=1.0),)

    def admissible(self, gap: Gap, site: Site, strengths: Floats) -> bool:
        """Some of the stated moments are left, and they are not many times as large."""
        return bool(-0.95 < strengths[0] < MOST_MOMENTS)

    def noteworthy(self, gap: Gap, site: Site, strengths: Floats) -> bool:
        """More than stated moments of inertia, which come from drawings, are usually off."""
        return bool(abs(strengths[0]) > LEAST_MOMENTS)

    def extend(self, robot: Robot, site: Site, strengths: Floats) -> Robot:
        """State the link with the moments multiplied."""
        return with_moments(robot, robot.joints[site.joint], 1.0 + float(strengths[0]))

    def evidence(self, gap: Gap, site: Site, strengths: Floats) -> str:
        """Give the factor."""
        factor, name = 1.0 + strengths[0], gap.robot.joints[site.joint]
        return f"as the link of {name} turns, joints need what {factor:.3g} times its stated moments of inertia need"
