"""The verdict of a diagnosis, and the sentence that states it."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence

import numpy as np

from mjfriction.diagnose.causes.catalog import STATED_LEVELS
from mjfriction.diagnose.faults.mend import Audited
from mjfriction.diagnose.faults.which_log import logs_with
from mjfriction.diagnose.fit.judged import judged
from mjfriction.diagnose.fit.model import Chosen, Model
from mjfriction.diagnose.search.oscillations import told_oscillations
from mjfriction.diagnose.search.stroke_curve import ALONG_STROKE, FRICTION_ALONG_STROKE, StrokeCurve, vague_friction
from mjfriction.diagnose.tell.outcome import Finding, Verdict
from mjfriction.diagnose.tell.what_gives import BLOWS
from mjfriction.diagnose.tell.with_play import with_play
from mjfriction.identify.bursts import BURST_SHARE, BURSTS, burst_share
from mjfriction.identify.colour import COLOURED, NOTHING, coloured_share
from mjfriction.identify.gap import Gap
from mjfriction.identify.joint_error import JointError
from mjfriction.identify.structure import Structure, find_structure
from mjfriction.record.log import Floats

STRUCTURED = 0.1  # share of the residual that a smooth curve may predict before it counts as unexplained
OUTWEIGHED = 0.5  # the curve's RMS must also exceed this fraction of the RMS that was explained
OUTWEIGHED_COURSE = 0.25  # the same for a course that follows nothing that is known
LEAST_EFFORT = 0.01  # fraction of a joint's RMS effort that either must exceed
LEAST_FRICTION = 0.05  # and of its friction, on a machine as uneven as real ones
# Causes found at one joint from which on what they leave counts as if nothing had been explained: so many together fit
# many a course that is none of theirs.
MANY_AT_A_JOINT = 3
MUCH_LEFT = 0.1  # fraction of a joint's effort; a larger residual, far above the noise, need not meet these limits
MUCH_COLOURED = 0.3  # share of such a residual that must stand above the noise in its spectrum
FAR_ABOVE_NOISE = 5.0  # multiple of the sensor's noise
# Fewest blocks in which a joint must move clearly, and their least share of all blocks: if a joint moves only once or
# twice, nothing is known about it on held-out motion.
FEWEST_SHOWN, LEAST_SHOWN = 3, 0.1
MOST_NAMED = 4  # findings that a summary names; the page lists all
REFITTED = 0.8  # fraction of an error; refitted values are mentioned if they reduce it to less than that


def unexplained(
    model: Model, after: tuple[Structure, ...], heldout: Floats, curves: Sequence[StrokeCurve]
) -> list[Structure]:
    """Return, for each joint whose held-out residual is too large, what this residual follows most.

    ``after`` are the structured shares of ``heldout`` (rows, joints).  ``curves`` along strokes and oscillations are
    unexplained too, since they are not of any cause; and so is, where nothing else is, friction of which only waves
    whose period is not known tell how it differs along the stroke.
    """
    oscillating = [one for one in told_oscillations(model) if one.share > STRUCTURED]
    out = [*(one.structure for one in curves), *oscillating]
    spelt = {structure.joint for structure in out}
    for joint in model.gap.examined:
        if model.gap.robot.joints[joint] not in spelt:
            out += _followed(model, joint, after, heldout)
    told = {structure.joint for structure in out}
    return out + [structure for structure in vague_friction(model, heldout) if structure.joint not in told]


def beside_oscillations(model: Model, clean: Floats) -> dict[int, float]:
    """Return, by joint with oscillations, the unexplained share of what they leave, ``clean`` (rows, joints)."""
    joints = {source.joint for source in model.nuisance.sources}
    after = find_structure(judged(model), clean) if joints else []
    return {joint: entry.share for joint in joints for entry in _followed(model, joint, after, clean)}


def _followed(model: Model, joint: int, after: Sequence[Structure], heldout: Floats) -> list[Structure]:
    # What a joint's residual follows most, if the residual is too large.
    gap = judged(model)
    if np.unique(gap.blocks.row[gap.clear[:, joint]]).size < max(FEWEST_SHOWN, LEAST_SHOWN * gap.blocks.count):
        return []
    name = gap.robot.joints[joint]
    curve = max((entry for entry in after if entry.joint == name), key=lambda entry: entry.share)
    course = Structure(name, NOTHING, coloured_share(gap, joint, heldout))
    # Where a link lands after play, some of each landing is always left, at all joints.
    bursts = Structure(name, BURSTS, 0.0 if with_play(model) else burst_share(gap, joint, heldout))
    left = gap.rms(heldout[:, joint], joint)
    effort = gap.rms(gap.measured[:, joint], joint)
    explained = np.sqrt(max(0.0, gap.rms(gap.residual[:, joint], joint) ** 2 - left**2))
    if sum(_of_joint(choice, joint) for choice in model.noteworthy) >= MANY_AT_A_JOINT:
        explained = 0.0
    # The stated friction limits the fitted one: a level that was fitted in place of something else is no measure of
    # friction.
    stated = float(np.sqrt(np.mean(np.square(gap.effort.friction[:, joint]))))
    friction = min(model.friction[joint], stated) if stated > 0.0 else model.friction[joint]
    told = [
        entry
        for entry, least, outweighed in (
            (curve, STRUCTURED, OUTWEIGHED),
            (course, COLOURED, OUTWEIGHED_COURSE),
            (bursts, BURST_SHARE, OUTWEIGHED_COURSE),
        )
        if entry.share >= least
        and np.sqrt(entry.share) * left
        > max(
            LEAST_EFFORT * effort,
            LEAST_FRICTION * model.nuisance.uneven * friction,
            outweighed * explained,
        )
    ]
    if not told and left > max(MUCH_LEFT * effort, FAR_ABOVE_NOISE * float(gap.noise_floor[joint])):
        # A share is still required: noise that a drive has low-passed is not structure, however little noise is left
        # beyond the pass band.
        told = [entry for entry, least in ((curve, STRUCTURED), (course, MUCH_COLOURED)) if entry.share >= least]
    return [max(told, key=lambda entry: entry.share)] if told else []


def _of_joint(choice: Chosen, joint: int) -> bool:
    # Whether a cause is one of a joint's own; levels that are not as stated are off on many a machine.
    return choice.site.joint == joint and not choice.cause.whole_arm and choice.cause is not STATED_LEVELS


def reach_verdict(findings: Sequence[Finding], remaining: tuple[Structure, ...]) -> Verdict:
    """Return the verdict that follows from the findings and from what remains unexplained."""
    if remaining:
        return Verdict.UNEXPLAINED
    if any(finding.alternatives for finding in findings):
        return Verdict.AMBIGUOUS
    return Verdict.EXPLAINED if findings else Verdict.CONSISTENT


def summarize(
    gap: Gap,
    verdict: Verdict,
    findings: Sequence[Finding],
    joints: tuple[JointError, ...],
    remaining: tuple[Structure, ...],
) -> str:
    """Return a sentence on what was found that a person can act on."""
    robot = gap.robot.name
    named = _all_named(findings)
    if verdict is Verdict.CONSISTENT:
        still = _still_left(gap, joints)
        beyond = "that stands out" if still else "beyond the noise"
        return f"The model of '{robot}' agrees with the log: {_refits(joints) or f'nothing {beyond} was found'}.{still}"
    if findings:
        errors = {error.joint: error for error in joints}
        worst = errors[findings[0].shown_at]
        share = 100.0 * (1.0 - worst.rms_heldout_after / max(worst.rms_heldout_before, 1e-300))
        gain = (
            f"building {'it' if len(findings) == 1 else 'them'} in takes the error of {worst.joint} from "
            f"{worst.rms_heldout_before:.3g} to {worst.rms_heldout_after:.3g} {worst.unit} on motion not fitted "
            f"({share:.0f} % less)"
        )
    if verdict is Verdict.UNEXPLAINED:
        left = ", ".join(_left(entry, joints) for entry in remaining)
        found = f"Found: {named}; {gain}. But" if findings else "No cause that this version knows fits, but"
        alone = " and ".join(logs_with(gap, remaining))
        where = f" It is in {alone} alone: what was different then, a load that the arm held?" if alone else ""
        return f"{found} an error remains that none explains: {left}.{where}"
    if verdict is Verdict.AMBIGUOUS:
        unsure = next(finding for finding in findings if finding.alternatives)
        return (
            f"The model of '{robot}' lacks {named}; {gain}. On this motion {_named(unsure)} cannot be told from "
            f"{' or '.join(unsure.alternatives)}."
        )
    return f"The model of '{robot}' lacks {named}; {gain}."


def with_faults(summary: str, audit: Audited) -> str:
    """Return what is wrong with the log, followed by the summary of what was found unless the log was refused."""
    if not audit.faults:
        return summary
    first, more = audit.faults[0], len(audit.faults) - 1
    told = f"{first.kind} in {first.where}: {first.action}" + (f", and {more} more, listed below" if more else "")
    if audit.refused:
        return f"The log itself is at fault, and nothing was fitted to it: {told}."
    return f"The log itself is at fault: {told}. {summary}"


def _all_named(findings: Sequence[Finding]) -> str:
    # Every cause and joint once, and the largest few of many.
    times = Counter(_named(finding) for finding in findings)
    named = [name if count == 1 else f"{name} ({count} of them)" for name, count in times.items()]
    told, more = named[:MOST_NAMED], len(named[MOST_NAMED:])
    return ", ".join(told) + (f" and {more} more" if more else "")


def _named(finding: Finding) -> str:
    return f"{finding.cause} at {finding.joint}" if finding.joint else finding.cause


def _refits(joints: tuple[JointError, ...]) -> str:
    moved = max(joints, key=lambda error: error.rms_heldout_before - error.rms_heldout_after, default=None)
    if moved is None or moved.rms_heldout_after > REFITTED * moved.rms_heldout_before:
        return ""
    return (
        "nothing was found beyond stated values that are a little off; refitting those takes the error of "
        f"{moved.joint} from {moved.rms_heldout_before:.3g} to {moved.rms_heldout_after:.3g} {moved.unit}"
    )


def _still_left(gap: Gap, joints: tuple[JointError, ...]) -> str:
    # What is left of a joint far above its sensor's noise, where that is none too little of its effort.
    shares: dict[float, JointError] = {}
    for error in joints:
        joint = gap.robot.joints.index(error.joint)
        effort = gap.rms(gap.measured[:, joint], joint) / abs(float(gap.per_reported[joint]))
        if error.rms_heldout_after > max(FAR_ABOVE_NOISE * error.noise_floor, LEAST_EFFORT * effort):
            shares[error.rms_heldout_after / effort] = error
    if not shares:
        return ""
    most = max(shares)
    error = shares[most]
    return (
        f" At {error.joint}, {error.rms_heldout_after:.3g} {error.unit} are left, {100 * most:.1f} % of the effort and "
        "far more than its sensor's noise: many small errors, or a small one of no known cause."
    )


def _left(entry: Structure, joints: tuple[JointError, ...]) -> str:
    error = next(error for error in joints if error.joint == entry.joint)
    share = f"{100 * entry.share:.0f} %"
    if entry.covariate == ALONG_STROKE:
        return f"{share} of the error at {entry.joint} is {ALONG_STROKE}, as a soft stop or a cable makes"
    if entry.covariate == BLOWS:
        return f"{share} of the error at {entry.joint} is in {BLOWS}, as something makes that lands or knocks"
    if entry.covariate == FRICTION_ALONG_STROKE:
        return f"{share} of the error at {entry.joint} is {FRICTION_ALONG_STROKE}, in a form that is not clear"
    course = f", of which {share} follow {entry.covariate}" if entry.share > STRUCTURED else ""
    if course and entry.covariate == NOTHING:
        course = f", of which {share} are no noise, but follow {NOTHING}"
    if entry.covariate == BURSTS:
        course = f", of which {share} are in {BURSTS}, each soon over"
    return f"{error.rms_heldout_after:.3g} {error.unit} at {entry.joint}{course}"
