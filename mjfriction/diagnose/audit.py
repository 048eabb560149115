"""Faults of a log that would otherwise be blamed on physics."""

from __future__ import annotations

import functools
import itertools
import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import nnls

from mjfriction.body.inverse import inverse_dynamics
from mjfriction.diagnose.units import DEGREE, find_degrees_by_velocity, find_unit_faults, stretched_clock
from mjfriction.identify.gap import Gap
from mjfriction.record.faults import Fault
from mjfriction.record.log import Floats
from mjfriction.robot.links_torque import held_torque, is_held

ALIKE = 0.9  # correlation from which on an effort is taken as the image of a prediction
UNLIKE = 0.6  # and under which it is not
FEWEST_ROWS = 50  # in clear motion, that a joint's effort is judged by
SAMPLES = 1500  # of a log that positions are judged by
POOR = 0.25  # of an effort's variance left unexplained, past which columns may be misplaced
MUCH = 0.1  # the same, that is much beside another joint past POOR
MENDED = 0.3  # of that, which may be left at one joint at least once they are in their places
NOTHING, MENDED_FROM_NOTHING = 0.9, 0.5  # the same where as good as nothing is explained as it is
NO_WORSE = 0.03  # of an effort's variance, that any joint may be explained less well by then
SOME, HALF = 0.03, 0.5  # of an effort's variance left, of which one joint at least, or all together, must lose so much
ALL_MENDED, SLIGHTLY = 0.6, 0.005  # of what is left at all joints together, and by how much more at any one
TURN, TURN_JOINT = "turn its sign", "turn their signs: this joint is counted the other way round"
EXCHANGE, EXCHANGE_JOINTS = "exchange the two columns", "exchange the two joints"
NOTICED = 0.05  # of an effort's variance left unexplained, that is worth a look where another joint leaves as much
MENDED_BOTH = 0.2  # of that, which may be left at both once they are in their places
CLEARLY = 0.7  # of what one explanation leaves, that a better one leaves
Span = tuple[float, float]
EVER: Span = (-math.inf, math.inf)
MOST_OFF = 5.0  # times too large or small, past which no constant of a drive is off


def find_faults(gap: Gap) -> list[Fault]:
    """Hold every joint's effort against what the robot says it needs, and name what no physics does.

    Positions beyond what limits, measured velocities or efforts allow are in another unit, and a clock may be off.
    A clear likeness to the prediction with its sign turned, or many times too large or small, or to another joint's
    prediction that in turn looks like this one's, is a fault of signs, units or wiring.  Then positions with a sign or
    at a joint that they should not have.
    """
    units = find_unit_faults(gap.log, gap.body) or find_degrees_by_velocity(gap.log, gap.body, gap.motion)
    return (
        units
        or find_degrees(gap)
        or find_stretched(gap)
        or find_misread(gap)
        or find_misplaced(gap)
        or _in_one_log(gap, find_misread)
        or _in_one_log(gap, find_misplaced)
    )


def _in_one_log(gap: Gap, find: Callable[[Gap, Span], list[Fault]]) -> list[Fault]:
    # What is at fault in one of several logs alone is lost in what all of them say together.
    begins = [begin for _, begin in gap.log.joined]
    if len(begins) < 2:
        return []
    found = []
    for (name, _), span in zip(gap.log.joined, itertools.pairwise([*begins, math.inf]), strict=True):
        found += [replace(fault, where=f"{fault.where}, in {name} alone") for fault in find(gap, span)]
    return found


def find_degrees(gap: Gap) -> list[Fault]:
    """Return the positions of turning joints that go farther than a turn, if the efforts fit once they are degrees."""
    turning = ~np.array(gap.body.sliding)
    if not np.any(np.max(np.abs(gap.motion.position[:, turning]), axis=0, initial=0.0) > 2.0 * np.pi):
        return []
    look = _look(gap)
    as_logged = look.left(look.course, look.effort)
    as_degrees = look.left([values * np.where(turning, DEGREE, 1.0) for values in look.course], look.effort)
    if not np.any(as_logged > SOME) or np.sum(as_degrees) > HALF * np.sum(as_logged):
        return []
    names = [joint for joint, turns in zip(gap.robot.joints, turning, strict=True) if turns]
    action = "the efforts fit if it is in degrees; convert it to radians"
    return [Fault("data.unit", f"position.{joint}", action) for joint in names]


def find_stretched(gap: Gap) -> list[Fault]:
    """Return the fault of a clock that runs too fast or too slow, where measured velocities say so and the efforts fit
    no worse once it is put right; else the velocities are what is wrong, and they are not used.
    """
    factor = stretched_clock(gap.log, gap.motion)
    if factor is None:
        return []
    look = _look(gap)
    position, velocity, acceleration = look.course
    mended = look.left([position, factor * velocity, factor**2 * acceleration], look.effort)
    if np.sum(mended) > np.sum(look.left(look.course, look.effort)):
        return []
    action = (
        f"measured velocities are {factor:.3g} times what positions do on this clock, and the efforts fit if it is at "
        f"fault: {'stretch' if factor < 1.0 else 'shorten'} time by {1.0 / factor:.3g}, or leave the velocities out"
    )
    return [Fault("data.clock", "whole log", action)]


def find_misread(gap: Gap, span: Span = EVER) -> list[Fault]:
    """Return the effort columns that look like no prediction, but like one turned, scaled, or of another joint, within
    a ``span`` of time.
    """
    examined = list(gap.examined)
    own = is_held(*span, gap.chain.time)
    clear = gap.clear[own]
    if not np.any(clear):
        return []
    predicted = gap.chain.rows(gap.effort.reported)[own][:, examined]
    measured = gap.measured[own][:, examined]
    measured, predicted = (values - np.mean(values, axis=0) for values in (measured, predicted))
    size = np.sqrt(np.outer(np.sum(np.square(measured), axis=0), np.sum(np.square(predicted), axis=0)))
    likeness = np.divide(measured.T @ predicted, size, out=np.zeros_like(size), where=size > 0.0)
    faults = []
    for i, joint in enumerate(examined):
        name = gap.robot.joints[joint]
        column = f"{gap.motion.quantity[joint]}.{name}"
        if np.count_nonzero(clear[:, joint]) < FEWEST_ROWS:
            continue
        # At rest friction may be anything; of pick and place that is most of a log.
        alike, factor = _likeness(*(rows[clear[:, joint], i] for rows in (measured, predicted)))
        for j in range(i):
            crossed = min(likeness[i, j], likeness[j, i])
            if crossed > ALIKE and max(likeness[i, i], likeness[j, j]) < UNLIKE:
                faults.append(_of_efforts_or_positions(gap, span, column, joint, examined[j]))
        if alike < -ALIKE and 1.0 / MOST_OFF < factor < MOST_OFF:
            faults.append(_of_efforts_or_positions(gap, span, column, joint, None))
        elif abs(alike) > ALIKE and not 1.0 / MOST_OFF < factor < MOST_OFF:
            action = f"it reads {factor:.3g} times what the robot needs; convert it to N·m or N at the joint, or A"
            faults.append(Fault("data.unit", column, action))
    return faults


def _likeness(measured: Floats, predicted: Floats) -> tuple[float, float]:
    # How alike two courses (rows,) are about their means, and how many times the second the first is.
    a, b = (values - np.mean(values) for values in (measured, predicted))
    size = float(np.sqrt((a @ a) * (b @ b)))
    return (float(a @ b) / size if size > 0.0 else 0.0), float(np.sqrt((a @ a) / max(float(b @ b), 1e-300)))


_Reading = tuple[Sequence[Floats], Floats, Fault]


@dataclass(frozen=True)
class _Look:
    """A log thinly: position, velocity and acceleration (k, joints), and the efforts of the examined joints (k, e)."""

    gap: Gap
    course: tuple[Floats, ...]
    effort: Floats

    def left(self, course: Sequence[Floats], effort: Floats) -> Floats:
        """Return the share of each examined joint's effort that no weight, friction or offset explains, (e,)."""
        examined = list(self.gap.examined)
        rigid, velocity = inverse_dynamics(self.gap.body, *course)[:, examined], course[1][:, examined]
        left = []
        for own, torque, speed in zip(effort.T, rigid.T, velocity.T, strict=True):
            one = np.ones_like(speed)
            columns = np.column_stack([torque, np.sign(speed), speed, one, -one])
            # A weight below none, or friction that drives, is no explanation.
            left.append(float(nnls(columns, own)[1]) ** 2 / max(own.size * float(np.var(own)), 1e-300))
        return np.asarray(left)

    def positions_exchanged(self, i: int, j: int) -> list[Floats]:
        """Return the course with two joints' columns exchanged."""
        order = np.arange(len(self.gap.robot.joints))
        order[[i, j]] = order[[j, i]]
        return [values[:, order] for values in self.course]

    def effort_turned(self, i: int) -> Floats:
        """Return the efforts with one joint's sign turned."""
        return self.effort * np.where(np.array(self.gap.examined) == i, -1.0, 1.0)

    def efforts_exchanged(self, i: int, j: int) -> Floats:
        """Return the efforts with two joints' columns exchanged."""
        order = np.arange(len(self.gap.examined))
        places = [self.gap.examined.index(i), self.gap.examined.index(j)]
        order[places] = order[places[::-1]]
        return self.effort[:, order]

    def position_turned(self, i: int) -> list[Floats]:
        """Return the course with one joint's sign turned."""
        sign = np.where(np.arange(len(self.gap.robot.joints)) == i, -1.0, 1.0)
        return [values * sign for values in self.course]


def _look(gap: Gap, span: Span = EVER) -> _Look:
    motion = gap.motion
    rows = np.flatnonzero(is_held(*span, motion.time))
    rows = rows[:: max(1, rows.size // SAMPLES)]
    course = tuple(values[rows] for values in (motion.position, motion.velocity, motion.acceleration))
    # What was held besides is no matter of whose column is whose.
    effort = motion.torque * gap.per_reported - held_torque(gap.robot, gap.body, motion)
    return _Look(gap, course, effort[rows][:, list(gap.examined)])


def _of_efforts_or_positions(gap: Gap, span: Span, column: str, i: int, j: int | None) -> Fault:
    """Return the fault of an effort that has the wrong sign, or is exchanged with joint ``j``'s, or that of the
    positions, where these explain all joints better.

    A joint's effort turned looks like its position turned, until one looks at what the other joints carry.
    """
    look, names = _look(gap, span), gap.robot.joints
    if j is None:
        action, effort, course = TURN, look.effort_turned(i), look.position_turned(i)
        by_effort, by_position = Fault("data.sign", column, TURN), Fault("data.sign", f"position.{names[i]}", TURN)
    else:
        action, effort, course = EXCHANGE, look.efforts_exchanged(i, j), look.positions_exchanged(i, j)
        by_effort = Fault("data.swap", f"{column} and that of {names[j]}", EXCHANGE)
        by_position = Fault("data.swap", f"position.{names[i]} and that of {names[j]}", EXCHANGE)
    efforts, positions = (float(np.sum(look.left(*pair))) for pair in ((look.course, effort), (course, look.effort)))
    if positions < CLEARLY * efforts:
        return by_position
    if efforts < CLEARLY * positions:
        return by_effort
    return replace(by_effort, action=f"{action} (or of the positions: what the other joints carry hardly tells)")


def find_misplaced(gap: Gap, span: Span = EVER) -> list[Fault]:
    """Return the column or joint whose sign is turned, or the two that are exchanged, if that makes the efforts fit
    within a ``span`` of time.

    Efforts that a model explains badly, but well once one column is turned or two are exchanged, are no physics.  Nor
    are those of two joints that are both explained far better once exchanged, though as logged neither is bad.  Where
    all columns of a joint are another's, or count it the other way round, its friction fits nevertheless, and what is
    left is less: there all joints together have to tell.
    """
    clear = gap.clear[is_held(*span, gap.chain.time)][:, list(gap.examined)]
    if span != EVER and np.any(np.count_nonzero(clear, axis=0) < FEWEST_ROWS):
        return []  # what a joint shows that rests there is noise
    look = _look(gap, span)
    as_logged = look.left(look.course, look.effort)
    columns: list[Fault] = []
    if np.any(as_logged > POOR):
        columns = _least(look, _columns_misplaced(look), functools.partial(_mended, as_logged))
    if not columns and np.count_nonzero(as_logged > NOTICED) > 1:
        exchanged = (reading for reading in _columns_misplaced(look) if reading[-1].kind == "data.swap")
        columns = _least(look, exchanged, functools.partial(_both_mended, as_logged))
    if columns:
        return columns
    if np.any(as_logged > SOME):
        return _least(look, _joints_misplaced(look), functools.partial(_all_mended, as_logged))
    return []


def _mended(as_logged: Floats, left: Floats) -> bool:
    # Joints with little but friction to do leave much however they are read: what counts is that none gets worse.
    poor = as_logged > POOR
    enough = np.where(as_logged > NOTHING, MENDED_FROM_NOTHING, MENDED) * as_logged
    own = np.any(left[poor] < enough[poor])
    # One that has noise besides is mended by half, and another beside it as a joint is whose column was wrong.
    together = np.any((as_logged > MUCH) & (left < enough)) and np.sum(left) < HALF * np.sum(as_logged)
    return bool((own or together) and np.all(left < as_logged + NO_WORSE))


def _both_mended(as_logged: Floats, left: Floats) -> bool:
    # Where neither is poor, since gravity looks alike at both, two joints that are exchanged are mended both.
    both = np.count_nonzero((as_logged > NOTICED) & (left < MENDED_BOTH * as_logged)) > 1
    return bool(both and np.all(left < as_logged + NO_WORSE))


def _all_mended(as_logged: Floats, left: Floats) -> bool:
    better = np.any((as_logged > SOME) & (left < HALF * as_logged))
    together = np.sum(left) < ALL_MENDED * np.sum(as_logged)
    return bool(better and together and np.all(left < as_logged + SLIGHTLY))


def _least(look: _Look, readings: Iterator[_Reading], accepted: Callable[[Floats], bool]) -> list[Fault]:
    # The fault of the reading that leaves least, of those accepted.
    judged = [(look.left(course, effort), fault) for course, effort, fault in readings]
    passing = [(float(np.sum(left)), fault) for left, fault in judged if accepted(left)]
    return [min(passing, key=lambda entry: entry[0])[1]] if passing else []


def _columns_misplaced(look: _Look) -> Iterator[_Reading]:
    # Every column turned and every pair exchanged: how the log would read without that, and the fault.
    gap, names = look.gap, look.gap.robot.joints
    for i, name in enumerate(names):
        yield look.position_turned(i), look.effort, Fault("data.sign", f"position.{name}", TURN)
        for j in range(i):
            where = f"position.{name} and that of {names[j]}"
            yield look.positions_exchanged(i, j), look.effort, Fault("data.swap", where, EXCHANGE)
    for i in gap.examined:
        column = f"{gap.motion.quantity[i]}.{names[i]}"
        yield look.course, look.effort_turned(i), Fault("data.sign", column, TURN)
        for j in gap.examined[: gap.examined.index(i)]:
            where = f"{column} and that of {names[j]}"
            yield look.course, look.efforts_exchanged(i, j), Fault("data.swap", where, EXCHANGE)


def _joints_misplaced(look: _Look) -> Iterator[_Reading]:
    # The same with positions and efforts together.
    gap, names = look.gap, look.gap.robot.joints
    for i in gap.examined:
        turned = look.position_turned(i), look.effort_turned(i)
        yield *turned, Fault("data.sign", f"all columns of {names[i]}", TURN_JOINT)
        for j in gap.examined[: gap.examined.index(i)]:
            exchanged = look.positions_exchanged(i, j), look.efforts_exchanged(i, j)
            yield *exchanged, Fault("data.swap", f"all columns of {names[i]} and {names[j]}", EXCHANGE_JOINTS)
