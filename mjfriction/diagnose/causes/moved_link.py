"""Base of the causes that put a link elsewhere than its sensor says: a zero that is off, and a transmission that is
compliant or has play.
"""

from __future__ import annotations

import functools
from abc import abstractmethod
from collections.abc import Callable, Sequence
from typing import ClassVar

import numpy as np

from mjfriction.diagnose.causes.cause import Cause, Site, column
from mjfriction.identify.gap import Gap
from mjfriction.identify.regression import Columns
from mjfriction.record.log import Floats
from mjfriction.record.motion import smooth_derivatives
from mjfriction.robot.robot import Robot
from mjfriction.robot.transmission import LEAST_INERTIA
from mjfriction.sim.lagging import Lagging

WIDEST = 0.2  # rad or m, largest play, or deflection under load
NEAR = (0.6, 1.6)  # range of a fitted strength, relative to the one that its columns were computed around
AT_A_TIME = 4_000_000  # samples, over all sites, that are computed at a time to bound memory
FELT = 1e-6  # fraction of the RMS effort up to which a shift counts as not felt


class MovedLink(Cause):
    """The link lags its sensor by ``shift`` per unit strength; every joint feels the resulting change of torque."""

    covariate = "effort"
    # Range of strengths, relative to the one that columns are computed around, that promise more at another shape.
    promises: ClassVar[tuple[float, float] | None] = None

    @abstractmethod
    def shift(self, gap: Gap, site: Site) -> list[Floats]:
        """Return how far the sensor is ahead of the link per unit strength, and the two derivatives, each (n,)."""

    def samples(self, gap: Gap, site: Site) -> Floats:
        """The torque at the joint itself, (n, 1)."""
        torque = self._beside(gap, site)
        for slope, part in zip(own_slopes(gap, site.joint), self.shift(gap, site), strict=True):
            torque = torque - slope * part
        return column(torque)

    def columns(self, gap: Gap, site: Site) -> Columns:
        """The change of torque at every examined joint, through the measurement chain."""
        return self._kept(gap, site, lambda: self.shift(gap, site))

    def columns_behind(self, gap: Gap, sites: Sequence[Site], behind: Floats) -> list[Columns]:
        """Return the columns of some sites, given how far each one's link is ``behind`` its sensor per unit strength,
        (n, sites), before the position filter.
        """
        return [
            self._kept(gap, site, functools.partial(smooth_derivatives, gap.motion, np.ascontiguousarray(own)))
            for site, own in zip(sites, behind.T, strict=True)
        ]

    def _kept(self, gap: Gap, site: Site, shift: Callable[[], list[Floats]]) -> Columns:
        key = f"{type(self).__name__} {site.joint} {site.around} {site.shape}"

        def made() -> Columns:
            torques = self._torques(gap, site, shift())
            return {i: gap.reported(i, torques[:, [i]]) for i in gap.examined}

        return gap.kept.recall(key, made)

    def promising(self, gap: Gap, site: Site, strengths: Floats) -> bool:
        """A part of the shift shows in columns that are computed around another one, which may itself be admissible."""
        if self.promises is None or not as_drawn(site, strengths, self.promises):
            return False
        return self.admissible(gap, site, np.array([site.around]))

    def sites(self, gap: Gap) -> list[Site]:
        """Every joint whose shift any examined joint would feel."""
        joints = [j for j in range(len(gap.robot.joints)) if j in gap.examined]
        return [
            Site(j)
            for j in joints
            if any(np.max(np.abs(c)) > self._felt(gap) for c in self.columns(gap, Site(j)).values())
        ]

    def _felt(self, gap: Gap) -> float:
        return FELT * float(np.sqrt(np.mean(np.square(np.nan_to_num(gap.measured)))))

    def _torques(self, gap: Gap, site: Site, shift: list[Floats]) -> Floats:
        out = np.zeros((len(gap.robot.joints), gap.motion.time.size))
        for derivative, part in zip(gap.derivatives, shift, strict=True):
            out -= derivative[:, :, site.joint].T * part
        out[site.joint] += self._beside(gap, site)
        return out.T

    def _beside(self, gap: Gap, site: Site) -> Floats:
        # What else changes at the joint itself, beyond gravity and inertia, (n,) per unit strength: by default nothing.
        return np.zeros(gap.motion.time.size)


def own_slopes(gap: Gap, joint: int) -> tuple[Floats, ...]:
    """Return how a joint's torque changes with its own position, velocity and acceleration, (n,) each."""
    return tuple(derivative[:, joint, joint] for derivative in gap.derivatives)


def noise_of_inertia(gap: Gap, joint: int) -> float:
    """Return what the noise of a joint's position adds to the torque of its inertia, as RMS at the rows, N·m or N.

    It is I·2π·b·√(b/3c)·σ: I is the joint's inertia (RMS over the motion), σ its velocity's noise, white up to the
    cutoff c of the position filter, and b the band of the rows.
    """
    band, motion = gap.chain.band, gap.motion
    inertia = float(np.sqrt(np.mean(np.square(own_slopes(gap, joint)[2]))))
    noise = 2.0 * np.pi * band * np.sqrt(band / (3.0 * motion.cutoff)) * motion.velocity_noise[joint]
    return float(inertia * noise)


def lagging(gap: Gap, joint: int, load: Floats) -> Lagging:
    """Return what a joint's link carries where it lags its motor, given its ``load`` (n,) where it does not."""
    stiffness, damping, inertia = own_slopes(gap, joint)
    return Lagging(load, np.maximum(inertia, LEAST_INERTIA), stiffness, damping)


def felt_by_itself(
    gap: Gap, sites: Sequence[Site], behind: Callable[[Gap, Sequence[Site]], Floats], every: int
) -> Columns:
    """Return the torque at the joint itself where its link is ``behind``, at every ``every``-th row, for many sites.

    ``behind`` returns the lag at some sites of the joint, (n, sites).  The position filter is left out; the columns are
    accurate enough to rank the sites.  On a long log, fewer sites are computed at a time, so that it needs no more
    memory for them than a short one.
    """
    joint, count = sites[0].joint, max(1, AT_A_TIME // gap.motion.time.size)
    stiffness, damping, inertia = (slope[:, None] for slope in own_slopes(gap, joint))
    parts = []
    for first in range(0, len(sites), count):
        off = behind(gap, sites[first : first + count])
        moving = gap.motion.differentiated(off)
        torques = -(stiffness * off + damping * moving + inertia * gap.motion.differentiated(moving))
        parts.append(gap.reported(joint, torques[:, :, None])[::every])
    return {joint: np.concatenate(parts, axis=1)}


def changed(robot: Robot, site: Site, **changes: object) -> Robot:
    """Return the robot with values of the joint at a site changed."""
    return robot.with_joint(robot.table.joint[site.joint].model_copy(update=changes))


def as_drawn(site: Site, strengths: Floats, near: tuple[float, float] = NEAR) -> bool:
    """Return whether a strength is ``near`` the one that its columns were computed around, if there is one."""
    return site.around == 0.0 or near[0] < float(strengths[0]) / site.around < near[1]
