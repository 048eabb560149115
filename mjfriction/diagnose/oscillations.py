"""Oscillations that no cause of a model makes: heard once causes were found, and refitted while all compete anew."""

from __future__ import annotations

import numpy as np

from mjfriction.diagnose.causes.cause import Site
from mjfriction.diagnose.causes.rotor_inertia import RotorInertia
from mjfriction.diagnose.causes.spring import Spring
from mjfriction.diagnose.model import Chosen, Model, build_model
from mjfriction.diagnose.nuisance import Oscillation, make_nuisance
from mjfriction.identify.gap import Gap
from mjfriction.identify.structure import Structure
from mjfriction.identify.swing import Swing, courses, swings
from mjfriction.identify.tone import Tone, steady_tone, waves
from mjfriction.record.log import Floats

QUIETER = 0.5  # of the mean square that is left, that is left beside an oscillation
INSTEAD = 0.75  # of it, that is left beside one in the place of causes
RESONANT = 0.75  # of what a spring and a rotor leave, that is left beside a load that swings
LOUD = 0.3  # of what is left with or without causes, that a tone must be to be tried
FINER = 10  # frequencies that are tried for one that the length of the log can tell apart
MOST_HEARD = 3  # at one joint
LEAST_TOLD = 0.003  # of a joint's RMS effort, that an oscillation must reach


def unheard(model: Model) -> list[Oscillation]:
    """Return the oscillations that are heard and not refitted yet, at most one for each joint.

    One is heard where, of what a model leaves there on motion not fitted, a steady tone or a load that swings takes
    half, or, in the place of causes of the joint, a quarter: beside it, they may be none.  A late effort, a link that
    gives, a rotor or the levels of friction may be made to look like it; but another machine on the same floor, a loop
    that sings, or a liquid that sloshes is none of the causes.  Far from resonance a load that swings pulls as a mass
    or a spring does: it is heard where it leaves a quarter less than these.
    """
    gap, after, out = model.gap, model.heldout_residual(), []
    heard = [one.joint for one in model.nuisance.oscillations]
    for joint in gap.examined:
        weight = model.system.rows.weight[:, joint]
        left = _power(after[:, joint], weight)
        if heard.count(joint) >= MOST_HEARD or float(gap.noise_floor[joint]) ** 2 > INSTEAD * left:
            continue
        loudest, least = None, left
        for reading in _readings(model, joint):
            still = _carried(reading, joint)
            bar = (QUIETER if reading is model else INSTEAD) * left
            swinging = min(bar, RESONANT * _power(still.heldout_residual()[:, joint], weight))
            for oscillation, most in ((_loudest_tone(reading, joint), bar), (_loudest_swing(still, joint), swinging)):
                if oscillation is None:
                    continue
                beside = _beside(reading, oscillation)
                rest = _power(beside.heldout_residual()[:, joint], weight)
                if rest < min(least, most) and _size(beside) > LEAST_TOLD * _effort(gap, joint):
                    loudest, least = oscillation, rest
        if loudest is not None:
            out.append(loudest)
    return out


def told_oscillations(model: Model) -> list[Structure]:
    """Return what is heard at each joint, and its share of what is left there, as structure that no cause explains."""
    gap, out = model.gap, []
    clean, whole = model.heldout_residual(), model.heldout_residual(oscillations=True)
    for joint in dict.fromkeys(one.joint for one in model.nuisance.oscillations):
        weight = model.system.rows.weight[:, joint]
        size = np.sqrt(_power(whole[:, joint] - clean[:, joint], weight))
        if size > LEAST_TOLD * _effort(gap, joint):
            words = " and ".join(one.words for one in model.nuisance.oscillations if one.joint == joint)
            share = 1.0 - _power(clean[:, joint], weight) / _power(whole[:, joint], weight)
            out.append(Structure(gap.robot.joints[joint], words, share))
    return out


def _power(course: Floats, weight: Floats) -> float:
    # The mean square of a course (rows,), each row as sure as it is.
    return float(np.average(np.square(course), weights=np.square(weight)))


def _effort(gap: Gap, joint: int) -> float:
    return gap.rms(gap.measured[:, joint], joint)


def _size(beside: Model) -> float:
    # The RMS of the oscillation that a model's nuisance heard last.
    last = beside.nuisance.heard[-1]
    joint = last.oscillation.joint
    strengths = beside.strengths[beside.nuisance.of_oscillations][-last.precision.size :]
    return beside.gap.rms(last.columns[joint] @ strengths, joint)


def _readings(model: Model, joint: int) -> list[Model]:
    # The model; where a cause made the joint late, the one that hears the joint as it is stated; and the one without
    # any cause of the joint's own.
    own = [one for one in model.chosen if one.site.joint == joint and not one.cause.whole_arm]
    of_sensor = [one for one in own if one.cause.of_sensor]
    out = [model]
    if of_sensor:
        gap = model.gap.heard_later(np.where(np.arange(model.gap.late.size) == joint, 0.0, model.gap.late))
        out.append(build_model(gap, make_nuisance(gap, model.nuisance.oscillations), _left_of(model, of_sensor)))
    if len(own) > len(of_sensor):
        out.append(build_model(out[-1].gap, out[-1].nuisance, _left_of(model, own)))
    return out


def _left_of(model: Model, taken: list[Chosen]) -> tuple[Chosen, ...]:
    return tuple(one for one in model.chosen if one not in taken)


def _carried(model: Model, joint: int) -> Model:
    # With what a load makes that is carried along or held back, but does not swing.
    more = [Chosen(cause, Site(joint)) for cause in (Spring(), RotorInertia())]
    known = {one.key for one in model.chosen}
    return build_model(model.gap, model.nuisance, (*model.chosen, *(one for one in more if one.key not in known)))


def _beside(model: Model, oscillation: Oscillation) -> Model:
    gap = model.gap
    return build_model(gap, make_nuisance(gap, (*model.nuisance.oscillations, oscillation)), model.chosen)


def _loudest_tone(model: Model, joint: int) -> Tone | None:
    # The tone that takes most off what a model leaves at a joint, of those near the strongest in that and in what the
    # robot as it is stated leaves.
    gap = model.gap
    left = (model.residual()[:, joint], np.nan_to_num(gap.residual[:, joint]))
    heard = [found for found in (steady_tone(gap, joint, course) for course in left) if found is not None]
    loud = [tone for tone, share in heard if share > LOUD]
    if not loud:
        return None
    time = gap.chain.time
    around = np.linspace(-1.0, 1.0, 2 * FINER + 1) / (time[-1] - time[0])
    near = [Tone(joint, tone.frequency + float(shift)) for tone in loud for shift in around]
    _, gains = model.system.screen({joint: np.stack([waves(tone.frequency, time) for tone in near], axis=1)})
    return near[int(np.argmax(gains))]


def _loudest_swing(model: Model, joint: int) -> Swing | None:
    # The swing that takes most off what a model leaves at a joint.
    tried = swings(model.gap, joint)
    if not tried:
        return None
    _, gains = model.system.screen({joint: courses(model.gap, tried)[:, :, None]})
    best = tried[int(np.argmax(gains))]
    near = best.finer()
    _, gains = model.system.screen({joint: courses(model.gap, near)[:, :, None]})
    return near[int(np.argmax(gains))]
