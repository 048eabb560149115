"""drive.backlash detected in the positions themselves: sensors that jump as the load changes sign.

A jump is over before any effort can show it, and its apparent acceleration looks like a blow if only efforts are
examined.  So it is measured in the positions, and removed from the motion before any cause is tried.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from mjfriction.diagnose.causes.play import BACKLASH, Play
from mjfriction.diagnose.tell.alike import MOST_CONFIDENT
from mjfriction.diagnose.tell.outcome import Finding
from mjfriction.identify.fitted import Fitted
from mjfriction.identify.gap import Gap
from mjfriction.identify.measure import gap_along, measure_gap, thinned, thinning
from mjfriction.identify.proof import gain_at
from mjfriction.record.jumps import Jumps
from mjfriction.record.log import Floats
from mjfriction.record.motion import estimate_motion
from mjfriction.robot.measured_motion import seen_jumps
from mjfriction.robot.robot import Robot

OFF = 0.05  # fraction of the stated play by which the measured play must differ from it to be a finding


@dataclass(frozen=True)
class SeenPlay:
    """The play that was detected: its ``jumps``, by joint.

    ``gap`` is the gap of the robot with this play, on motion that is free of its jumps; ``whole`` is the same on every
    sample of the log.  ``stated`` (rows, joints) is the residual of the robot as stated, at the rows of ``gap``, on
    motion that still has the jumps that were detected.
    """

    whole: Gap
    gap: Gap
    stated: Floats
    jumps: Mapping[int, Jumps]


def unseen(stated: Gap) -> SeenPlay:
    """Return the result for a log without detected play: the gap stays as it is."""
    gap = thinned(stated)
    return SeenPlay(stated, gap, gap.residual, {})


def see_play(stated: Gap, highest: float) -> SeenPlay:
    """Look for jumps that the stated robot does not explain; without any, the gap stays as it is.

    ``highest`` is the upper limit of the position filter's cutoff (Hz).  Joints whose stated play is not crossed at
    once, such as coasting play, are skipped, and so are joints that are not examined: no effort shows what the play
    would explain.
    """
    robot, found = stated.robot, {}
    motion = stated.motion
    if motion.jump_free:
        motion = estimate_motion(stated.log, motion.joints, motion.cutoff, motion.sliding)
    for joint, jumps in seen_jumps(stated.log, robot, stated.body, motion).items():
        if joint not in stated.examined:
            continue
        transmission = robot.table.joint[joint].transmission
        off = abs(jumps.size - transmission.jump) > max(OFF * transmission.jump, jumps.half_width)
        if transmission.backlash == transmission.jump and off:
            found[joint] = jumps
    if not found:
        return unseen(stated)
    whole = measure_gap(stated.log, _with_play(robot, found), highest=highest)
    jumping = estimate_motion(stated.log, motion.joints, whole.motion.cutoff, motion.sliding)
    gap = thinned(whole)
    return SeenPlay(whole, gap, gap_along(robot, jumping.thinned(thinning(whole.motion)), gap).residual, found)


def _with_play(robot: Robot, seen: Mapping[int, Jumps]) -> Robot:
    for joint, jumps in seen.items():
        own = robot.table.joint[joint]
        played = own.transmission.model_copy(update={"backlash": jumps.size, "coasting": False})
        robot = robot.with_joint(own.model_copy(update={"transmission": played}))
    return robot


def play_findings(seen: SeenPlay, heldout: Floats, seed: int) -> list[Finding]:
    """Return the detected play as findings.

    ``heldout`` (rows, joints) is the held-out residual of the extended robot; ``seed`` sets the resampling behind the
    intervals of the gains.
    """
    return [_finding(seen, joint, jumps, heldout, seed) for joint, jumps in seen.jumps.items()]


def _finding(seen: SeenPlay, joint: int, jumps: Jumps, heldout: Floats, seed: int) -> Finding:
    gap = seen.gap
    name, sliding = gap.robot.joints[joint], gap.body.sliding[joint]
    unit = BACKLASH.unit_for(sliding=sliding)
    low, high = jumps.size - jumps.half_width, jumps.size + jumps.half_width
    fitted = Fitted(BACKLASH.name, BACKLASH.meaning, unit, jumps.size, max(low, BACKLASH.lower), high)
    return Finding(
        cause=Play.name,
        joint=name,
        confidence=MOST_CONFIDENT,
        alternatives=(),
        parameters=(fitted,),
        gain=gain_at(gap, seen.stated, heldout, joint, seed),
        evidence=(
            f"the position jumps by {jumps.size:.3g} {unit} as the load changes sign, {jumps.count} times of "
            f"{jumps.turns}: no link could go so far in so little time"
        ),
        covariate=Play.covariate,
        picture=Play.picture,
        shown_at=name,
        without=(heldout + seen.stated - gap.residual)[:, joint],
    )
