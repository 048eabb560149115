"""The gap between a log and the robot as stated: residuals, their noise, and how far each row can be believed."""

from __future__ import annotations

import functools
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from mjfriction.body.inverse import motion_derivatives
from mjfriction.body.model import Body
from mjfriction.body.regressor import link_change_torques
from mjfriction.identify.blocks import Blocks
from mjfriction.identify.blows import quick_accelerations
from mjfriction.identify.kept import Kept, Lately
from mjfriction.identify.rows import Chain
from mjfriction.record.log import Floats, Log
from mjfriction.record.motion import Motion
from mjfriction.robot.effort import (
    Carried,
    Effort,
    as_reported,
    bare,
    carry,
    delayed,
    effort_of,
    later,
    link_motion,
    predict_effort,
    reported_of,
    stiff,
    unheard,
    without_offsets,
)
from mjfriction.robot.own_slopes import Slopes, own_slopes
from mjfriction.robot.robot import Robot
from mjfriction.robot.rubbing import forward_share

FILTER_PERIODS = 8.0  # periods of a low-pass's bandwidth, after which it has forgotten its input
KEPT_LATELY = 4  # robots whose torques are cached


@dataclass(frozen=True)
class Known:
    """The ``robot`` as far as it is known so far, its ``body``, and the ``effort`` it needs along the motion."""

    robot: Robot
    body: Body
    effort: Effort


@dataclass(frozen=True)
class Gap:
    """Measured against stated effort, along one log.

    ``residual`` (rows, joints): reported effort less the stated robot's, N·m or N at the joint, NaN where a joint has
    no measurement or is merely held.  ``measured`` (rows, joints): the effort itself.  ``noise_floor`` (joints,): the
    effort sensor's own noise in the rows' band.  ``doubt`` (rows, joints): what the unknown direction of friction, near
    reversals and at rest, may add to a row, same unit.  ``doubt_speed`` (joints,): the speed below which that direction
    is unknown.  ``clear`` (rows, joints): the rows on which a joint's errors are judged.  ``blocks``: the stretches of
    motion that the rows fall into.  ``per_reported`` (joints,): effort per unit of what the drive reports, 1 or N·m/A.
    ``filtered`` (joints,): the frequency (Hz) above which a drive has filtered its effort away, infinite where none
    did.  ``yielding``: the share of its stroke over which a joint's contact may yield after a rest.  ``heeding``:
    whether rows with blows count.  ``late`` (joints,): by how much (s) more than stated the drives are taken to report
    late, in the columns set beside the residual.  ``known``: what those columns are computed with: the stated robot, or
    one whose link masses and positions are those found so far.
    """

    robot: Robot
    body: Body
    log: Log
    motion: Motion
    effort: Effort
    chain: Chain
    measured: Floats
    residual: Floats
    noise_floor: Floats
    doubt: Floats
    doubt_speed: Floats
    clear: NDArray[np.bool_]
    blocks: Blocks
    per_reported: Floats
    filtered: Floats
    yielding: float
    heeding: bool
    late: Floats
    known: Known

    @property
    def examined(self) -> tuple[int, ...]:
        """Indices of the joints that move, rather than being held, and have a measurement."""
        return tuple(i for i in range(len(self.robot.joints)) if np.isfinite(self.residual[0, i]))

    @functools.cached_property
    def _kinematics(self) -> dict[str, Floats]:
        motion = self.motion
        forward = np.column_stack([self.forward(i) for i in range(len(motion.joints))])
        courses = {"position": motion.position, "velocity": motion.velocity, "forward": forward}
        return {name: self.chain.rows(self._heard(course)) for name, course in courses.items()}

    def _heard(self, course: Floats) -> Floats:
        # Delay each joint's course (n, joints) by as much as its drive reports late beyond what is stated.
        columns = [delayed(own, self.motion, late) for own, late in zip(course.T, self.late, strict=True)]
        return np.column_stack(columns) if np.any(self.late) else course

    def at_rows(self, name: str) -> Floats:
        """Return ``position``, ``velocity`` or the ``forward`` direction of friction at the rows, (rows, joints)."""
        return self._kinematics[name]

    @functools.cached_property
    def kept(self) -> Kept:
        """Cache of columns that are costly and needed repeatedly, by the name of their cause."""
        return Kept()

    def reported(self, joint: int, torque: Floats) -> Floats:
        """Return what a joint's sensor would report for torques at that joint, (n, ...), at the rows: (rows, ...)."""
        return self._reported(joint, torque, self.motion, self.chain)

    def _reported(self, joint: int, torque: Floats, motion: Motion, chain: Chain) -> Floats:
        table = later(self.robot.table.joint[joint], float(self.late[joint]))
        seen = as_reported(table, torque, motion, motion.position[:, joint] - table.position_sensor.offset)
        rows = chain.rows(seen.reshape(seen.shape[0], -1))
        return np.asarray(rows.reshape(-1, *torque.shape[1:]))

    def rows_of(self, torques: Callable[[slice], Floats]) -> dict[int, Floats]:
        """Return what each examined joint would report for given torques, at the rows: (rows, ...) by joint.

        ``torques`` returns those of a range of samples, (m, joints, ...), so that the regressors of all samples are
        never in memory at once.
        """
        found: dict[int, list[Floats]] = {joint: [] for joint in self.examined}
        for samples, chain in self.chain.parts(self.motion, self._reach):
            motion, values = self.motion.part(samples), torques(samples)
            for joint, rows in found.items():
                rows.append(self._reported(joint, values[:, joint], motion, chain))
        return {joint: np.concatenate(rows) for joint, rows in found.items()}

    def predicted(self, robot: Robot) -> Floats:
        """Return what a robot would report along this motion, at the rows, (rows, joints)."""
        return self.chain.rows(reported_of(robot, self.motion, self._needed(robot)))

    def _needed(self, robot: Robot) -> Floats:
        # The torques that a robot needs.  They are the same for all robots that differ only in their sensors.  What
        # links and rotors need is the same for all that differ only in friction.
        drives, motion = unheard(robot), self.motion

        def torques() -> Floats:
            laden = bare(drives)
            carried = self._carried_lately.recall(
                laden, lambda: carry(laden, laden.body(), motion, self._slopes_of(laden))
            )
            return effort_of(drives, motion, carried).total

        return self._needed_lately.recall(drives, torques)

    def _slopes_of(self, robot: Robot) -> Slopes:
        # The slopes of the loads, kept while only transmissions, friction or sensors differ.
        return lambda body, motor: self._slopes_lately.recall(stiff(robot), lambda: own_slopes(body, motor))

    @functools.cached_property
    def _slopes_lately(self) -> Lately[Robot, Floats]:
        return Lately(KEPT_LATELY)

    @functools.cached_property
    def _needed_lately(self) -> Lately[Robot, Floats]:
        return Lately(KEPT_LATELY)

    @functools.cached_property
    def _carried_lately(self) -> Lately[Robot, Carried]:
        return Lately(KEPT_LATELY)

    @functools.cached_property
    def predicted_as_stated(self) -> Floats:
        """What the stated robot would report, as from :meth:`predicted`, (rows, joints)."""
        return self.predicted(self.robot)

    @property
    def _reach(self) -> int:
        # How many samples away another sample no longer affects what a sensor reports for this one.
        sensors = [joint.effort_sensor for joint in self.robot.table.joint]
        late = max(abs(sensor.delay) + abs(more) for sensor, more in zip(sensors, self.late, strict=True))
        slow = max((FILTER_PERIODS / sensor.bandwidth for sensor in sensors if sensor.bandwidth), default=0.0)
        return int(np.ceil((late + slow) * self.motion.rate)) + 1

    def delayed(self, late: Floats, doubt: Floats, clear: NDArray[np.bool_]) -> Gap:
        """Return the gap with columns that are reported later than stated by ``late`` (joints,), s, and with the
        ``doubt`` and the ``clear`` rows that go with that.
        """
        gap = replace(self, late=np.asarray(late), doubt=doubt, clear=clear)
        gap.__dict__["kept"] = self.kept.apart_from(np.flatnonzero(gap.late != self.late).tolist())
        return gap

    def beside(self, robot: Robot) -> Gap:
        """Return the gap whose columns are computed with another robot's loads; residual and prediction stay."""
        body = robot.body()
        gap = replace(self, known=Known(robot, body, predict_effort(robot, body, self.motion)))
        same = {"_kinematics", "_forward", "blown", "link_rows", "linked", "predicted_as_stated"}
        same |= {"_needed_lately", "_carried_lately", "_slopes_lately"}
        gap.__dict__.update({name: self.__dict__[name] for name in same if name in self.__dict__})
        return gap

    @functools.cached_property
    def prompt(self) -> Gap:
        """The gap with columns as late as stated, and no later."""
        return replace(self, late=np.zeros_like(self.late))

    def rms(self, values: Floats, joint: int) -> float:
        """Return the RMS of a joint's values (rows,) over its clear rows."""
        return float(np.sqrt(np.mean(np.square(values[self.clear[:, joint]]))))

    def forward(self, joint: int) -> Floats:
        """Return the direction of friction on a joint, (n,): −1 or 1, or between these where the joint may be stuck."""
        return self._forward[joint]

    @functools.cached_property
    def _forward(self) -> list[Floats]:
        return [forward_share(self.motion, joint) for joint in range(len(self.motion.joints))]

    @functools.cached_property
    def blown(self) -> Floats:
        """The acceleration during each joint's own blows, (n, joints), 0 elsewhere."""
        return quick_accelerations(self.motion, self.doubt_speed)

    @functools.cached_property
    def link_rows(self) -> dict[int, Floats]:
        """What each examined joint reports for every link, (rows, links, 5).

        The first number is the link's share of the inverse dynamics, the next three are the change per metre that its
        centre of mass is moved along x, y and z, and the last is the share of its moments of inertia about that centre.
        """
        at = self.linked
        return self.rows_of(
            lambda own: link_change_torques(self.body, at.position[own], at.velocity[own], at.acceleration[own])
        )

    @functools.cached_property
    def linked(self) -> Motion:
        """The motion of the links as stated, without sensor offsets and without what the transmissions give."""
        return link_motion(self.robot, self.body, without_offsets(self.robot, self.motion))

    @functools.cached_property
    def derivatives(self) -> tuple[Floats, ...]:
        """Derivatives of the known links' torques by position, velocity and acceleration, each (n, joints, joints)."""
        linked = self.linked
        return motion_derivatives(self.known.body, linked.position, linked.velocity, linked.acceleration)
