"""A thinned log, and how it would read with the sign of a column reversed or two columns exchanged."""

from __future__ import annotations

import functools
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import nnls

from mjfriction.body.inverse import inverse_dynamics
from mjfriction.identify.gap import Gap
from mjfriction.record.log import Floats
from mjfriction.record.span import EVER, Span, within
from mjfriction.robot.links_torque import held_torque

SAMPLES = 1500  # samples of a log on which positions are judged
FEWEST_ROWS = 50  # clear rows that are needed to judge a joint's effort
# A reading of a log is doubted only where more than ``SOME`` of an effort's variance is left unexplained. A better
# reading leaves less than ``HALF`` of that, at one joint or at all joints together.
SOME, HALF = 0.03, 0.5
NO_WORSE = 0.03  # of an effort's variance: a better reading may leave this much more at any joint


@dataclass(frozen=True)
class Look:
    """A thinned log: position, velocity and acceleration (k, joints), and the efforts of the examined joints (k, e)."""

    gap: Gap
    course: tuple[Floats, ...]
    effort: Floats

    @functools.cached_property
    def left_as_logged(self) -> Floats:
        """What :meth:`left` returns for the log as it is, (e,)."""
        return self.left(self.course, self.effort)

    def left(self, course: Sequence[Floats], effort: Floats) -> Floats:
        """Return the share of each examined joint's effort variance that rigid-body torque, friction and an offset do
        not explain, (e,).
        """
        examined = list(self.gap.examined)
        rigid, velocity = inverse_dynamics(self.gap.body, *course)[:, examined], course[1][:, examined]
        left = []
        for own, torque, speed in zip(effort.T, rigid.T, velocity.T, strict=True):
            one = np.ones_like(speed)
            columns = np.column_stack([torque, np.sign(speed), speed, one, -one])
            # A negative scale of the torque, or friction that drives the joint, is no explanation: least squares are
            # non-negative.
            left.append(float(nnls(columns, own)[1]) ** 2 / max(own.size * float(np.var(own)), 1e-300))
        return np.asarray(left)

    def positions_exchanged(self, i: int, j: int) -> list[Floats]:
        """Return position, velocity and acceleration with two joints' columns exchanged."""
        order = np.arange(len(self.gap.robot.joints))
        order[[i, j]] = order[[j, i]]
        return [values[:, order] for values in self.course]

    def effort_turned(self, i: int) -> Floats:
        """Return the efforts with one joint's sign reversed."""
        return self.effort * np.where(np.array(self.gap.examined) == i, -1.0, 1.0)

    def efforts_exchanged(self, i: int, j: int) -> Floats:
        """Return the efforts with two joints' columns exchanged.

        This works for currents too, since the scales of torque and friction are free.
        """
        order = np.arange(len(self.gap.examined))
        places = [self.gap.examined.index(i), self.gap.examined.index(j)]
        order[places] = order[places[::-1]]
        return self.effort[:, order]

    def position_turned(self, i: int) -> list[Floats]:
        """Return position, velocity and acceleration with one joint's sign reversed."""
        sign = np.where(np.arange(len(self.gap.robot.joints)) == i, -1.0, 1.0)
        return [values * sign for values in self.course]


def look_at(gap: Gap, span: Span = EVER) -> Look:
    """Return the thinned log as it was written, within a ``span`` of time."""
    motion = gap.motion
    rows = np.flatnonzero(within(span, motion.time))
    rows = rows[:: max(1, rows.size // SAMPLES)]
    course = tuple(values[rows] for values in (motion.position, motion.velocity, motion.acceleration))
    # Loads known to be held besides the payload do not tell whose column is whose, so their torques are taken off.
    effort = motion.torque * gap.per_reported - held_torque(gap.robot, gap.body, motion)
    return Look(gap, course, effort[rows][:, list(gap.examined)])
