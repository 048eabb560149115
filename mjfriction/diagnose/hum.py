"""Steady tones that no cause of a model makes: heard once causes were found, and refitted while all compete anew."""

from __future__ import annotations

import numpy as np

from mjfriction.diagnose.model import Model, build_model
from mjfriction.diagnose.nuisance import make_nuisance
from mjfriction.identify.gap import Gap
from mjfriction.identify.structure import Structure
from mjfriction.identify.tone import Tone, steady_tone

QUIETER = 0.5  # of the mean square that is left, that is left beside a tone
LOUD = 0.3  # of what is left with or without causes, that a tone must be to be tried
FINER = 10  # frequencies that are tried for one that the length of the log can tell apart
MOST_TONES = 3  # at one joint
LEAST_TOLD = 0.01  # of a joint's RMS effort, that a tone must reach


def unheard_tones(model: Model) -> list[tuple[int, Tone]]:
    """Return the joints at which a steady tone is heard that is not refitted yet, each with its tone.

    A joint hums where, of what a model leaves there on motion not fitted, one sine more takes half: beside it, the
    joint's causes may be none.  A late effort, a link that gives, or the levels of friction may be made to look like a
    tone; but another machine on the same floor, or a loop that sings, is none of the causes.
    """
    gap, after, out = model.gap, model.heldout_residual(), []
    heard = [joint for joint, _ in model.nuisance.tones]
    for joint in gap.examined:
        if heard.count(joint) >= MOST_TONES:
            continue
        left = gap.rms(after[:, joint], joint) ** 2
        quietest, rest = None, left
        for reading in _readings(model, joint):
            tone = _loudest(reading, joint)
            if tone is not None and (own := _left_beside(reading, joint, tone)) < rest:
                quietest, rest = tone, own
        if quietest is not None and rest < QUIETER * left and left - rest > _least_power(gap, joint):
            out.append((joint, quietest))
    return out


def hums_told(model: Model) -> list[Structure]:
    """Return what hums at each joint, and its share of what is left there, as structure that no cause explains."""
    gap, out = model.gap, []
    clean, whole = model.heldout_residual(), model.heldout_residual(tones=True)
    for joint in dict.fromkeys(joint for joint, _ in model.nuisance.tones):
        heard = [f"{tone.frequency:.3g}" for place, tone in model.nuisance.tones if place == joint]
        words = f"a steady tone of {heard[0]} Hz" if len(heard) == 1 else f"steady tones of {' and '.join(heard)} Hz"
        left, loud = (gap.rms(course[:, joint], joint) ** 2 for course in (clean, whole))
        if loud - left > _least_power(gap, joint):
            out.append(Structure(gap.robot.joints[joint], words, 1.0 - left / loud))
    return out


def _least_power(gap: Gap, joint: int) -> float:
    return float((LEAST_TOLD * gap.rms(gap.measured[:, joint], joint)) ** 2)


def _readings(model: Model, joint: int) -> list[Model]:
    # The model, and, where a cause made the joint late, the one that hears the joint as it is stated.
    rest = tuple(
        one for one in model.chosen if one.site.joint != joint or one.cause.whole_arm or not one.cause.of_sensor
    )
    if len(rest) == len(model.chosen):
        return [model]
    gap = model.gap.heard_later(np.where(np.arange(model.gap.late.size) == joint, 0.0, model.gap.late))
    return [model, build_model(gap, make_nuisance(gap, model.nuisance.tones), rest)]


def _left_beside(model: Model, joint: int, tone: Tone) -> float:
    # The mean square that is left at a joint beside a tone there, on motion not fitted.
    gap = model.gap
    beside = build_model(gap, make_nuisance(gap, (*model.nuisance.tones, (joint, tone))), model.chosen)
    return float(gap.rms(beside.heldout_residual()[:, joint], joint) ** 2)


def _loudest(model: Model, joint: int) -> Tone | None:
    # The tone that takes most off what a model leaves at a joint, of those near the strongest in that, in what the
    # joint's own causes are there for, and in what the robot as it is stated leaves.
    gap = model.gap
    courses = [model.residual()[:, joint], np.nan_to_num(gap.residual[:, joint])]
    own = [choice for choice in model.chosen if choice.site.joint == joint and not choice.cause.whole_arm]
    if own:
        others = tuple(choice for choice in model.chosen if choice not in own)
        courses.append(build_model(gap, model.nuisance, others).residual()[:, joint])
    heard = [tone for tone in (steady_tone(gap, joint, course) for course in courses) if tone is not None]
    loud = [tone for tone in heard if tone.share > LOUD]
    if not loud:
        return None
    time = gap.chain.time
    around = np.linspace(-1.0, 1.0, 2 * FINER + 1) / (time[-1] - time[0])
    tones = [Tone(tone.frequency + float(shift), tone.share) for tone in loud for shift in around]
    _, gains = model.system.screen({joint: np.stack([tone.columns(time) for tone in tones], axis=1)})
    return tones[int(np.argmax(gains))]
