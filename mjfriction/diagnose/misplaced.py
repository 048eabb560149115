"""Columns of a log that have their sign turned, or stand at another joint's place."""

from __future__ import annotations

import functools
from collections.abc import Callable, Collection, Iterator, Sequence
from dataclasses import replace

import numpy as np

from mjfriction.diagnose.look import FEWEST_ROWS, HALF, NO_WORSE, SOME, Look, look_at
from mjfriction.diagnose.read_so import off_as_stated, read_so
from mjfriction.identify.gap import Gap
from mjfriction.record.fault import Fault, Mend
from mjfriction.record.log import POSITION, Floats
from mjfriction.record.span import EVER, Span, within

POOR = 0.25  # of an effort's variance left unexplained, past which columns may be misplaced
MUCH = 0.1  # the same, that is much beside another joint past POOR
MENDED = 0.3  # of that, which may be left at one joint at least once they are in their places
NOTHING, MENDED_FROM_NOTHING = 0.9, 0.5  # the same where as good as nothing is explained as it is
ALL_MENDED, SLIGHTLY = 0.6, 0.005  # of what is left at all joints together, and by how much more at any one
TURN, TURN_JOINT = "turn its sign", "turn their signs: this joint is counted the other way round"
EXCHANGE, EXCHANGE_JOINTS = "exchange the two columns", "exchange the two joints"
NOTICED = 0.05  # of an effort's variance left unexplained, that is worth a look where another joint leaves as much
MENDED_BOTH = 0.2  # of that, which may be left at both once they are in their places
EXPLAINED = 0.01  # of an effort's variance in clear motion, that the stated robot leaves where the columns are right
CLEARLY = 0.7  # of what one explanation leaves, that a better one leaves

_Reading = tuple[Sequence[Floats], Floats, Fault]


def of_efforts_or_positions(gap: Gap, span: Span, i: int, j: int | None) -> Fault:
    """Return the fault of an effort that has the wrong sign, or is exchanged with joint ``j``'s, or that of the
    positions, where these explain all joints better.

    A joint's effort turned looks like its position turned, until one looks at what the other joints carry, and at how
    far off the robot is as it is stated.
    """
    look = look_at(gap, span)
    if j is None:
        action, effort, course = TURN, look.effort_turned(i), look.position_turned(i)
        by_effort, by_position = (_turned(column(gap, i)) for column in (effort_column, position_column))
    else:
        action, effort, course = EXCHANGE, look.efforts_exchanged(i, j), look.positions_exchanged(i, j)
        by_effort, by_position = (_exchanged(gap, column, i, j) for column in (effort_column, position_column))
    efforts, positions = (float(np.sum(look.left(*pair))) for pair in ((look.course, effort), (course, look.effort)))
    if positions < CLEARLY * efforts:
        return by_position
    if efforts < CLEARLY * positions:
        return by_effort
    fault = _as_stated(gap, span, [by_effort, by_position])
    if fault is not None:
        return fault
    action = f"{action} (or of the positions: what the other joints carry hardly tells)"
    return replace(by_effort, action=action, mend=None)


def _as_stated(gap: Gap, span: Span, faults: Sequence[Fault]) -> Fault | None:
    # Of several faults the one without which the stated robot is least off, if that is clear.
    mends = [replace(fault.mend, span=span) for fault in faults if fault.mend is not None]
    if len(mends) < len(faults):
        return None
    readings = [read_so(gap, [mend], gap.robot, highest=gap.motion.cutoff) for mend in mends]
    off = off_as_stated(readings, span)
    least, *others = np.argsort(off)
    clearly = all(off[least] < off[other] + np.log(CLEARLY) for other in others)
    return faults[least] if clearly else None


def find_misplaced(gap: Gap, span: Span = EVER) -> list[Fault]:
    """Return the column or joint whose sign is turned, or the two that are exchanged, if that makes the efforts fit
    within a ``span`` of time.

    Efforts that a model explains badly, but well once one column is turned or two are exchanged, are no physics.  Nor
    are those of two joints that are both explained far better once exchanged, though as logged neither is bad.  Where
    all columns of a joint are another's, or count it the other way round, its friction fits nevertheless, and what is
    left is less: there all joints together have to tell.  A joint whose effort the stated robot explains while it moves
    has its columns where they belong.
    """
    clear = gap.clear[within(span, gap.chain.time)][:, list(gap.examined)]
    if span != EVER and np.any(np.count_nonzero(clear, axis=0) < FEWEST_ROWS):
        return []  # what a joint shows that rests there is noise
    look = look_at(gap, span)
    as_logged, sound = look.left_as_logged, _sound(gap, span)
    columns: list[Fault] = []
    if np.any(as_logged > POOR):
        columns = _least(look, _columns_misplaced(look, sound), functools.partial(_mended, as_logged))
    if not columns and np.count_nonzero(as_logged > NOTICED) > 1:
        exchanged = (reading for reading in _columns_misplaced(look, sound) if reading[-1].kind == "data.swap")
        columns = _least(look, exchanged, functools.partial(_both_mended, as_logged))
    if columns:
        return columns
    if np.any(as_logged > SOME):
        return _least(look, _joints_misplaced(look, sound), functools.partial(_all_mended, as_logged))
    return []


def _sound(gap: Gap, span: Span) -> set[int]:
    # The joints whose effort the stated robot explains while they move.  Efforts that rests make the most of, which may
    # hold any friction, look like nothing that a model knows.
    within_span, out = within(span, gap.chain.time), set[int]()
    for joint in gap.examined:
        rows = within_span & gap.clear[:, joint]
        measured, residual = gap.measured[rows, joint], gap.residual[rows, joint]
        if residual.size >= FEWEST_ROWS and np.mean(np.square(residual)) < EXPLAINED * np.var(measured):
            out.add(joint)
    return out


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


def _least(look: Look, readings: Iterator[_Reading], accepted: Callable[[Floats], bool]) -> list[Fault]:
    # The fault of the reading that leaves least, of those accepted.  Where another leaves hardly more, which of them it
    # is, is not sure.
    judged = [(look.left(course, effort), fault) for course, effort, fault in readings]
    passing = [(float(np.sum(left)), fault) for left, fault in judged if accepted(left)]
    if not passing:
        return []
    least, fault = min(passing, key=lambda entry: entry[0])
    alone = sum(CLEARLY * left <= least for left, _ in passing) == 1
    return [fault if alone else replace(fault, mend=None)]


def _columns_misplaced(look: Look, sound: Collection[int]) -> Iterator[_Reading]:
    # Every column turned and every pair exchanged, but for joints that are sound: how the log would read without that,
    # and the fault.
    gap = look.gap
    every = [i for i in range(len(gap.robot.joints)) if i not in sound]
    for i in every:
        yield look.position_turned(i), look.effort, _turned(position_column(gap, i))
        for j in every[: every.index(i)]:
            yield look.positions_exchanged(i, j), look.effort, _exchanged(gap, position_column, i, j)
    measured = [i for i in gap.examined if i not in sound]
    for i in measured:
        yield look.course, look.effort_turned(i), _turned(effort_column(gap, i))
        for j in measured[: measured.index(i)]:
            yield look.course, look.efforts_exchanged(i, j), _exchanged(gap, effort_column, i, j)


def _joints_misplaced(look: Look, sound: Collection[int]) -> Iterator[_Reading]:
    # The same with positions and efforts together.
    gap, names = look.gap, look.gap.robot.joints
    measured = [i for i in gap.examined if i not in sound]
    for i in measured:
        columns = (position_column(gap, i), effort_column(gap, i))
        mend = Mend(factors=tuple((column, -1.0) for column in columns))
        turned = look.position_turned(i), look.effort_turned(i)
        yield *turned, Fault("data.sign", f"all columns of {names[i]}", TURN_JOINT, mend=mend)
        for j in measured[: measured.index(i)]:
            one, other = (_exchanged(gap, column, i, j).mend for column in (position_column, effort_column))
            both = Mend(exchanged=(*one.exchanged, *other.exchanged)) if one and other else None
            exchanged = look.positions_exchanged(i, j), look.efforts_exchanged(i, j)
            where = f"all columns of {names[i]} and {names[j]}"
            yield *exchanged, Fault("data.swap", where, EXCHANGE_JOINTS, mend=both)


def effort_column(gap: Gap, joint: int) -> str:
    """Return the name of the column that holds what a joint's drive reports."""
    return f"{gap.motion.quantity[joint]}.{gap.robot.joints[joint]}"


def position_column(gap: Gap, joint: int) -> str:
    """Return the name of the column that holds a joint's position."""
    return f"{POSITION}.{gap.robot.joints[joint]}"


def _turned(column: str) -> Fault:
    return Fault("data.sign", column, TURN, mend=Mend(factors=((column, -1.0),)))


def _exchanged(gap: Gap, column: Callable[[Gap, int], str], i: int, j: int) -> Fault:
    one, other = column(gap, i), column(gap, j)
    # Currents and efforts are no columns that can be taken for each other.
    alike = one.partition(".")[0] == other.partition(".")[0]
    mend = Mend(exchanged=((one, other),)) if alike else None
    return Fault("data.swap", f"{one} and that of {gap.robot.joints[j]}", EXCHANGE, mend=mend)
