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
from mjfriction.errors import LogError
from mjfriction.identify.blocks import Blocks, cut_blocks
from mjfriction.identify.blows import blows, quick_accelerations
from mjfriction.identify.doubt import WITHIN, YIELDING, doubt_speeds, rows_of_rests, share_in_doubt, unusable_rows
from mjfriction.identify.effort_band import filtered_from, whole_below
from mjfriction.identify.kept import Kept, Lately
from mjfriction.identify.rows import Chain, make_chain
from mjfriction.identify.turning import turning_speeds
from mjfriction.record.log import Floats, Log, check_joints
from mjfriction.record.motion import Motion
from mjfriction.record.noise import raw_noise
from mjfriction.record.resample import SHORTEST_PIECE
from mjfriction.record.reversals import travel_since_turn
from mjfriction.robot.bandwidth import HIGHEST, choose_cutoff
from mjfriction.robot.effort import (
    Carried,
    Effort,
    as_reported,
    bare,
    carry,
    delayed,
    effort_of,
    effort_per_reported,
    later,
    link_motion,
    predict_effort,
    reported_of,
    unheard,
    without_offsets,
)
from mjfriction.robot.measured_motion import measured_motion
from mjfriction.robot.robot import Robot
from mjfriction.robot.rubbing import forward_share, resting_level, unsettled_along

CLEAR = 0.1  # a row is clear where less than this share of its window is in doubt
# A joint that has both a smaller share of clear rows and fewer clear rows than these is judged on that share of its
# rows, the least doubtful ones.
FEWEST_CLEAR, ENOUGH_CLEAR = 0.2, 50
MOST_SPOILT = 0.9  # a joint is not examined where more than this share of its faster rows is unusable
HOPELESS = 1e6  # times the joint's largest effort: the doubt given to a row that says nothing
FILTER_PERIODS = 8.0  # periods of a low-pass's bandwidth, after which it has forgotten its input
ENOUGH_PER_PERIOD = 4.0  # samples per period of the position filter's cutoff that leave the rows unchanged
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
    did.  ``yielding``: the share of its stroke over which a joint's contact may yield after a rest.  ``late``
    (joints,): by how much (s) more than stated the drives are taken to report late, in the columns set beside the
    residual.  ``known``: what those columns are computed with: the stated robot, or one whose link masses and positions
    are those found so far.
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
            carried = self._carried_lately.recall(laden, lambda: carry(laden, laden.body(), motion))
            return effort_of(drives, motion, carried).total

        return self._needed_lately.recall(drives, torques)

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

    def heard_later(self, late: Floats) -> Gap:
        """Return the gap with drives that report later than stated by ``late`` (joints,), s.

        Residual and prediction stay.  The columns set beside them, and the rows where friction's direction is in doubt,
        are delayed.
        """
        table = self.robot.table
        joints = tuple(later(joint, float(more)) for joint, more in zip(table.joint, late, strict=True))
        heard = gap_of(replace(self.robot, table=table.model_copy(update={"joint": joints})), self)
        gap = replace(self, late=np.asarray(late), doubt=heard.doubt, clear=heard.clear)
        gap.__dict__["kept"] = self.kept.apart_from(np.flatnonzero(gap.late != self.late).tolist())
        return gap

    def beside(self, robot: Robot) -> Gap:
        """Return the gap whose columns are computed with another robot's loads; residual and prediction stay."""
        body = robot.body()
        gap = replace(self, known=Known(robot, body, predict_effort(robot, body, self.motion)))
        same = {"_kinematics", "_forward", "blown", "link_rows", "linked", "predicted_as_stated"}
        same |= {"_needed_lately", "_carried_lately"}
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


def measure_gap(log: Log, robot: Robot, *, yielding: float = YIELDING, highest: float = HIGHEST) -> Gap:
    """Compare a log with a robot.

    ``yielding`` is the share of its stroke within which a joint's friction is in doubt after it has rested, or while it
    settles; 0 where laws are fitted that say how friction builds up.  ``highest`` is the upper limit of the position
    filter's cutoff (Hz).

    Raises :class:`LogError` when the log is not of this robot, nothing moves or nothing that moves reports a usable
    effort, or the log is too short; :class:`~mjfriction.errors.RobotError` when the robot's model cannot be read.
    """
    body = robot.body()
    robot = robot.with_stated_friction(body)
    check_joints(log, robot.name, robot.joints)
    motion = measured_motion(log, robot, body, choose_cutoff(log, robot, body, highest))
    effort = predict_effort(robot, body, motion)
    torque = motion.torque * _per_reported(robot, motion)
    filtered = filtered_from(motion, effort, torque)
    chain = make_chain(motion, log.source, whole_below(filtered))
    gap = _judging(_held_against(log, robot, body, motion, effort, chain, filtered, yielding))
    if not gap.examined:
        raise LogError(
            f"{log.source}: no joint moves for a while and reports an effort or a current that changes meanwhile; "
            "record motion that neither creeps nor jumps from rest to rest, with what the drives give"
        )
    return gap


def thinned(gap: Gap) -> Gap:
    """Return the gap on only as many samples as its rows need, to make further work faster and smaller."""
    motion = gap.motion.thinned(thinning(gap.motion))
    if motion is gap.motion:
        return gap
    effort = predict_effort(gap.robot, gap.body, motion)
    chain = make_chain(motion, gap.log.source, whole_below(gap.filtered))
    return _judging(_held_against(gap.log, gap.robot, gap.body, motion, effort, chain, gap.filtered, gap.yielding))


def thinning(motion: Motion) -> int:
    """Return the factor by which a motion's samples may be thinned."""
    shortest = int(min(own.stop - own.start for own in motion.pieces))
    return max(1, min(int(motion.rate / (ENOUGH_PER_PERIOD * motion.cutoff)), shortest // SHORTEST_PIECE))


def gap_of(robot: Robot, along: Gap) -> Gap:
    """Return the gap of another robot with the same joints along the same motion, row by row."""
    return gap_along(robot, along.motion, along)


def gap_along(robot: Robot, motion: Motion, along: Gap) -> Gap:
    """Return the gap of another robot with the same joints along another estimate of the same motion, row by row."""
    body = robot.body()
    robot = robot.with_stated_friction(body)
    effort = predict_effort(robot, body, motion)
    gap = _held_against(along.log, robot, body, motion, effort, along.chain, along.filtered, along.yielding)
    # Examine the same joints: where no row of a joint is clear with this robot (or none was before), the joint keeps
    # the clear rows of ``along``.
    both = np.any(gap.clear, axis=0) & np.any(along.clear, axis=0)
    return _judging(replace(gap, clear=np.where(both, gap.clear, along.clear)))


def _judging(gap: Gap) -> Gap:
    # Set the measurement of joints without any clear row to NaN, so that they are not examined.
    judged = np.any(gap.clear, axis=0)
    measured, residual = (np.where(judged, values, np.nan) for values in (gap.measured, gap.residual))
    return replace(gap, measured=measured, residual=residual)


def _per_reported(robot: Robot, motion: Motion) -> Floats:
    pairs = zip(robot.table.joint, motion.quantity, strict=True)
    return np.array([effort_per_reported(joint, quantity, robot.name) for joint, quantity in pairs])


def _wholly_spoilt(unusable: NDArray[np.bool_], velocity: Floats) -> NDArray[np.bool_]:
    # Whether nearly all rows (rows, joints) of a joint at or above its median speed are unusable, (joints,).
    fast = np.abs(velocity) >= np.median(np.abs(velocity), axis=0)
    return np.asarray(np.sum(unusable & fast, axis=0) > MOST_SPOILT * np.sum(fast, axis=0))


def _held_against(
    log: Log,
    robot: Robot,
    body: Body,
    motion: Motion,
    effort: Effort,
    chain: Chain,
    filtered: Floats,
    yielding: float,
) -> Gap:
    per_reported = _per_reported(robot, motion)
    # Leave out drives that say nothing.  One that reports a constant has measured nothing.  One that holds its joint
    # still may report anything within the joint's friction.  One that hardly moves its joint says nothing about the
    # joint's laws.  One that clipped, or stuck, whenever its joint moved is of no use.
    still = ~motion.moving | motion.dawdling
    unusable = unusable_rows(log, motion, chain)
    still |= _wholly_spoilt(unusable, chain.rows(motion.velocity))
    told = np.where((np.ptp(motion.torque, axis=0) == 0.0) | still, np.nan, motion.torque)
    measured = chain.rows(told * per_reported)
    residual = measured - chain.rows(effort.reported)
    noise = [
        abs(per_reported[i]) * raw_noise(log, quantity, joint, motion.clock) if quantity else np.nan
        for i, (joint, quantity) in enumerate(zip(motion.joints, motion.quantity, strict=True))
    ]
    slow = doubt_speeds(motion)
    unsettled = unsettled_along(robot, motion, effort.load, effort.rotor)
    touched = share_in_doubt(robot, motion, chain, slow, yielding, unsettled)
    resting = resting_level(robot, motion, effort.load, effort.rotor, slow)
    travel = chain.rows(travel_since_turn(motion.velocity, motion.position, motion.pieces)[0])
    velocity = chain.rows(motion.velocity)
    turning = turning_speeds(velocity, travel, residual, touched < CLEAR, resting, motion.top_speed)
    if np.any(turning > slow):
        slow = np.maximum(slow, turning)
        touched = share_in_doubt(robot, motion, chain, slow, yielding, unsettled)
    # While its direction is unknown, friction may be as large as its stated level or as the RMS residual, whichever is
    # more.  A joint at rest holds one friction value all the time, so the many rows of a rest count as one observation.
    level = resting_level(robot, motion, effort.load, effort.rotor, slow)
    doubt = touched * np.maximum(level, np.sqrt(np.mean(np.square(np.nan_to_num(residual)), axis=0)))
    doubt *= np.sqrt(rows_of_rests(touched, chain))
    felt, struck = blows(body, motion, chain, slow)
    doubt = doubt + felt
    spoilt = unusable | struck
    doubt = np.where(spoilt, HOPELESS * np.max(np.abs(np.nan_to_num(measured))), doubt)
    floor = np.array(noise) * np.sqrt(motion.rate * motion.clock.step) * chain.noise_gain
    clear = (touched < CLEAR) & (felt <= floor) & ~spoilt
    few = (np.mean(clear, axis=0) < FEWEST_CLEAR) & (np.sum(clear, axis=0) < ENOUGH_CLEAR)
    # Spoilt rows rank last.  Rows within a rest say nothing and are never taken.
    unclear = touched + spoilt
    clear[:, few] |= ((unclear <= np.quantile(unclear, FEWEST_CLEAR, axis=0)) & (unclear < WITHIN))[:, few]
    return Gap(
        robot=robot,
        body=body,
        log=log,
        motion=motion,
        effort=effort,
        chain=chain,
        measured=measured,
        residual=residual,
        noise_floor=floor,
        doubt=doubt,
        clear=clear,
        doubt_speed=slow,
        blocks=cut_blocks(chain, chain.rows(motion.position), log.source),
        per_reported=per_reported,
        filtered=filtered,
        yielding=yielding,
        late=np.zeros(len(motion.joints)),
        known=Known(robot, body, effort),
    )
