"""Columns of a log whose sign is inverted, or that stand in another joint's place."""

from __future__ import annotations

import functools
from collections.abc import Callable, Collection, Iterator, Sequence
from dataclasses import replace

import numpy as np

from mjfriction.diagnose.faults.look import FEWEST_ROWS, HALF, NO_WORSE, SOME, Look, look_at
from mjfriction.diagnose.faults.read_so import off_as_stated, read_so
from mjfriction.identify.gap import Gap
from mjfriction.record.fault import Fault, Mend
from mjfriction.record.log import POSITION, Floats
from mjfriction.record.span import EVER, Span, within

POOR = 0.25  # share of an effort's variance left unexplained, beyond which columns may be misplaced
MUCH = 0.1  # the same for a further joint, once another is beyond POOR
MENDED = 0.3  # with the columns in their places, at least one joint must keep less than this fraction of that share
NOTHING, MENDED_FROM_NOTHING = 0.9, 0.5  # a joint with more than NOTHING unexplained may keep this fraction instead
ALL_MENDED, SLIGHTLY = 0.6, 0.005  # fraction all joints together may keep; extra share allowed at any one
TURN, TURN_JOINT = "turn its sign", "turn their signs: this joint is counted the other way round"
EXCHANGE, EXCHANGE_JOINTS = "exchange the two columns", "exchange the two joints"
NOTICED = 0.05  # share of an effort's variance left unexplained at two joints, beyond which an exchange is tried
MENDED_BOTH = 0.2  # fraction of that share that both joints may keep once they are exchanged
EXPLAINED = 0.01  # share of an effort's variance in clear motion that the stated robot leaves where columns are right
CLEARLY = 0.7  # one explanation is clearly better where it leaves less than this fraction of what the other leaves

_Reading = tuple[Sequence[Floats], Floats, Fault]


def of_efforts_or_positions(gap: Gap, span: Span, i: int, j: int | None) -> Fault:
    """Return the fault of joint ``i``'s effort (wrong sign, or exchanged with joint ``j``'s), or the same fault of the
    positions, if that explains all joints better.

    At the joint itself, an inverted effort looks like an inverted position.  They are told apart by the loads on the
    other joints, and by how far off the stated robot is with each.  If neither is clear, the fault has no mend.
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
    # The fault whose mend leaves the stated robot least off, if it does so clearly.
    mends = [replace(fault.mend, span=span) for fault in faults if fault.mend is not None]
    if len(mends) < len(faults):
        return None
    readings = [read_so(gap, [mend], gap.robot, highest=gap.motion.cutoff) for mend in mends]
    off = off_as_stated(readings, span)
    least, *others = np.argsort(off)
    clearly = all(off[least] < off[other] + np.log(CLEARLY) for other in others)
    return faults[least] if clearly else None


def find_misplaced(gap: Gap, span: Span = EVER) -> list[Fault]:
    """Return the column or joint whose sign is inverted, or the two that are exchanged, if correcting that makes the
    efforts fit within a ``span`` of time.

    If a model explains efforts badly, but explains them well once one column is inverted or two are exchanged, the
    cause is not physical.  The same holds for two joints that are both explained far better once exchanged, even if
    neither is bad as logged.  Where all columns of a joint belong to another, or count it in the opposite direction,
    its friction still fits and less is left unexplained; all joints together must then decide.  A joint whose effort
    the stated robot explains while it moves has its columns in the right place.
    """
    clear = gap.clear[within(span, gap.chain.time)][:, list(gap.examined)]
    if span != EVER and np.any(np.count_nonzero(clear, axis=0) < FEWEST_ROWS):
        return []  # a joint hardly moves within the span, and what it shows at rest is noise
    look = look_at(gap, span)
    as_logged, sound = look.left_as_logged, _sound(gap, span)
    columns: list[Fault] = []
    if np.any(as_logged > POOR):
        columns = _least(look, span, _columns_misplaced(look, sound), functools.partial(_mended, as_logged))
    if not columns and np.count_nonzero(as_logged > NOTICED) > 1:
        exchanged = (reading for reading in _columns_misplaced(look, sound) if reading[-1].kind == "data.swap")
        columns = _least(look, span, exchanged, functools.partial(_both_mended, as_logged))
    if columns:
        return columns
    if np.any(as_logged > SOME):
        return _least(look, span, _joints_misplaced(look, sound), functools.partial(_all_mended, as_logged))
    return []


def _sound(gap: Gap, span: Span) -> set[int]:
    # The joints whose effort the stated robot explains while they move.  Over the whole log, an effort that comes
    # mostly from rests may match no model, because a resting joint may hold any friction.
    within_span, out = within(span, gap.chain.time), set[int]()
    for joint in gap.examined:
        rows = within_span & gap.clear[:, joint]
        measured, residual = gap.measured[rows, joint], gap.residual[rows, joint]
        if residual.size >= FEWEST_ROWS and np.mean(np.square(residual)) < EXPLAINED * np.var(measured):
            out.add(joint)
    return out


def _mended(as_logged: Floats, left: Floats) -> bool:
    # Joints that carry little but friction leave much unexplained in any reading.  So not every poor joint must
    # improve; it is enough that none gets worse.
    poor = as_logged > POOR
    enough = np.where(as_logged > NOTHING, MENDED_FROM_NOTHING, MENDED) * as_logged
    own = np.any(left[poor] < enough[poor])
    # A poor joint that is also noisy improves only by half, but another joint improves as one with a wrong column does.
    together = np.any((as_logged > MUCH) & (left < enough)) and np.sum(left) < HALF * np.sum(as_logged)
    return bool((own or together) and np.all(left < as_logged + NO_WORSE))


def _both_mended(as_logged: Floats, left: Floats) -> bool:
    # Gravity may look alike at two exchanged joints, so that neither is poor.  Then both must improve.
    both = np.count_nonzero((as_logged > NOTICED) & (left < MENDED_BOTH * as_logged)) > 1
    return bool(both and np.all(left < as_logged + NO_WORSE))


def _all_mended(as_logged: Floats, left: Floats) -> bool:
    better = np.any((as_logged > SOME) & (left < HALF * as_logged))
    together = np.sum(left) < ALL_MENDED * np.sum(as_logged)
    return bool(better and together and np.all(left < as_logged + SLIGHTLY))


def _least(look: Look, span: Span, readings: Iterator[_Reading], accepted: Callable[[Floats], bool]) -> list[Fault]:
    # The fault of the accepted reading that leaves least.  If other accepted readings leave hardly more, as where
    # gravity on a lift may be an offset of either sign, the robot as stated decides.  If it does not either, it is not
    # certain which of them is right, and the fault has no mend.
    judged = [(look.left(course, effort), fault) for course, effort, fault in readings]
    passing = [(float(np.sum(left)), fault) for left, fault in judged if accepted(left)]
    if not passing:
        return []
    least, fault = min(passing, key=lambda entry: entry[0])
    near = [other for left, other in passing if CLEARLY * left <= least]
    if len(near) == 1:
        return [fault]
    return [_as_stated(look.gap, span, near) or replace(fault, mend=None)]


def _columns_misplaced(look: Look, sound: Collection[int]) -> Iterator[_Reading]:
    # Each column inverted and each pair exchanged, except at sound joints: how the log would then read, and the fault.
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
    # As _columns_misplaced, but with a joint's position and effort inverted or exchanged together.
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
    # A current and an effort cannot be read in each other's place, so such a pair has no mend.
    alike = one.partition(".")[0] == other.partition(".")[0]
    mend = Mend(exchanged=((one, other),)) if alike else None
    return Fault("data.swap", f"{one} and that of {gap.robot.joints[j]}", EXCHANGE, mend=mend)
