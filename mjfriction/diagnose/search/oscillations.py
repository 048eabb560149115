"""Oscillations that no cause of a model makes: detected once causes were found, and refitted while all compete anew."""

from __future__ import annotations

import numpy as np
from scipy.optimize import minimize

from mjfriction.diagnose.causes.cause import Site
from mjfriction.diagnose.causes.elasticity import Swinging
from mjfriction.diagnose.causes.rotor_inertia import RotorInertia
from mjfriction.diagnose.causes.spring import Spring
from mjfriction.diagnose.fit.model import Chosen, Model, build_model
from mjfriction.diagnose.fit.refitted import Source
from mjfriction.identify.gap import Gap
from mjfriction.identify.measure import heard_later
from mjfriction.identify.structure import Structure
from mjfriction.identify.swing import Swing, courses, shown_swings
from mjfriction.identify.tone import Tone, steady_tone, waves
from mjfriction.record.log import Floats

QUIETER = 0.5  # an oscillation must leave less than this fraction of the model's mean square residual
INSTEAD = 0.75  # the same for an oscillation in place of causes
RESONANT = 0.75  # a load that swings must leave less than this fraction of what a spring and a rotor leave
PLAINER = 0.9  # a load that swings must leave less than this fraction of what a steady tone leaves
LOUD = 0.3  # share of the residual, with or without causes, that a tone must make up to be tried
FINER = 10  # frequencies tried per frequency step that the length of the log can resolve
MOST_AT_A_JOINT = 3
NEAR = 1.15  # an oscillation within this factor of the frequencies that a link swings at comes from the link
LEAST_TOLD = 0.003  # share of a joint's RMS effort that an oscillation must reach
UNTUNED = 0.5  # the nearest swing on the search grid has at least this fraction of the gain of the tuned swing
SCREENED_ROWS = 4000  # rows that are enough to tell swings apart
CLOSE = 0.01  # precision of a swing's tuned frequency, as a fraction of its damping ratio
MOST_TUNINGS = 100


def new_oscillations(model: Model) -> list[Source]:
    """Return the sources that oscillate and are not refitted yet, at most one for each joint.

    A steady tone or a load that swings is one if it takes away half of the held-out mean square that the model leaves
    at a joint.  A quarter is enough if it takes the place of the joint's causes, since these may not be real: a delay,
    an elastic transmission, a rotor or friction levels may be fitted to imitate it.  But another machine on the same
    floor, a control loop that oscillates, or a liquid that sloshes is none of the causes.  Far from resonance, a load
    that swings acts as a mass or a spring does: it has to leave a quarter less than these.
    """
    gap, after, out = model.gap, model.heldout_residual(), []
    known = [source.joint for source in model.nuisance.sources]
    for joint in gap.examined:
        weight = model.system.rows.weight[:, joint]
        left = _power(after[:, joint], weight)
        if known.count(joint) >= MOST_AT_A_JOINT or float(gap.noise_floor[joint]) ** 2 > INSTEAD * left:
            continue
        loudest, least = None, left
        for reading in _readings(model, joint):
            still = _with_spring_and_rotor(reading, joint)
            bar = (QUIETER if reading is model else INSTEAD) * left
            swinging = min(bar, RESONANT * _power(still.heldout_residual()[:, joint], weight))
            tone, swing = _loudest_tone(reading, joint), _loudest_swing(reading, still, joint)
            for source, most in ((tone, bar), (swing, swinging)):
                if source is None or _of_own_link(model, source.frequency):
                    continue
                beside = _beside(reading, source)
                rest = _power(beside.heldout_residual()[:, joint], weight)
                plainer = isinstance(source, Swing) and isinstance(loudest, Tone)
                enough = min(most, least * (PLAINER if plainer else 1.0))
                if rest < enough and _size(beside, joint) > LEAST_TOLD * _effort(gap, joint):
                    loudest, least = source, rest
        if loudest is not None:
            out.append(loudest)
    return out


def _of_own_link(model: Model, frequency: float) -> bool:
    # A link that swings on its transmission has other frequencies in other poses, and does not swing quite as the cause
    # models it.  What is left of that, at any joint, has no other source.
    for choice, fitted in model.fitted_causes:
        if isinstance(choice.cause, Swinging):
            own = choice.cause.resonances(model.gap, choice.site, fitted)
            if np.min(own) / NEAR < frequency < np.max(own) * NEAR:
                return True
    return False


def told_oscillations(model: Model) -> list[Structure]:
    """Return what oscillates at each joint and its share of the residual there: structure that no cause explains."""
    gap, out = model.gap, []
    courses_left = model.heldout_residual(), model.heldout_residual(oscillations=True)
    for joint in dict.fromkeys(source.joint for source in model.nuisance.sources):
        if _size(model, joint) > LEAST_TOLD * _effort(gap, joint):
            weight = model.system.rows.weight[:, joint]
            clean, whole = (_power(course[:, joint], weight) for course in courses_left)
            words = " and ".join(source.words for source in model.nuisance.sources if source.joint == joint)
            out.append(Structure(gap.robot.joints[joint], words, 1.0 - clean / whole))
    return out


def _power(course: Floats, weight: Floats) -> float:
    # The mean square of a course (rows,), each row weighted by its inverse variance.
    return float(np.average(np.square(course), weights=np.square(weight)))


def _effort(gap: Gap, joint: int) -> float:
    return gap.rms(gap.measured[:, joint], joint)


def _size(model: Model, joint: int) -> float:
    # The held-out RMS of all that oscillates at a joint.
    course = model.heldout_residual(oscillations=True)[:, joint] - model.heldout_residual()[:, joint]
    return float(np.sqrt(_power(course, model.system.rows.weight[:, joint])))


def _readings(model: Model, joint: int) -> list[Model]:
    # The model; if the joint has causes of its sensor, such as a delay, the model without these and with the joint no
    # later than stated; and if it has others, the model without any cause of the joint's own.
    own = [one for one in model.chosen if one.site.joint == joint and not one.cause.whole_arm]
    of_sensor = [one for one in own if one.cause.of_sensor]
    out = [model]
    if of_sensor:
        gap = heard_later(model.gap, np.where(np.arange(model.gap.late.size) == joint, 0.0, model.gap.late))
        out.append(build_model(gap, model.nuisance.along(gap, model.nuisance.sources), _left_of(model, of_sensor)))
    if len(own) > len(of_sensor):
        out.append(build_model(out[-1].gap, out[-1].nuisance, _left_of(model, own)))
    return out


def _left_of(model: Model, taken: list[Chosen]) -> tuple[Chosen, ...]:
    return tuple(one for one in model.chosen if one not in taken)


def _with_spring_and_rotor(model: Model, joint: int) -> Model:
    # The model with the effect of a load that is carried along (rotor) or held back (spring) but does not swing.
    more = [Chosen(cause, Site(joint)) for cause in (Spring(), RotorInertia())]
    known = {one.key for one in model.chosen}
    return build_model(model.gap, model.nuisance, (*model.chosen, *(one for one in more if one.key not in known)))


def _beside(model: Model, source: Source) -> Model:
    gap = model.gap
    return build_model(gap, model.nuisance.along(gap, (*model.nuisance.sources, source)), model.chosen)


def _loudest_tone(model: Model, joint: int) -> Tone | None:
    # The tone with the largest gain over the model at a joint, among frequencies near the strongest tone in the model's
    # residual and in that of the stated robot.
    gap = model.gap
    left = (model.residual()[:, joint], np.nan_to_num(gap.residual[:, joint]))
    strongest = [found for found in (steady_tone(gap, joint, course) for course in left) if found is not None]
    loud = [tone for tone, share in strongest if share > LOUD]
    if not loud:
        return None
    time = gap.chain.time
    around = np.linspace(-1.0, 1.0, 2 * FINER + 1) / (time[-1] - time[0])
    near = [Tone(joint, tone.frequency + float(shift)) for tone in loud for shift in around]
    _, gains = model.system.screen({joint: np.stack([waves(tone.frequency, time) for tone in near], axis=1)})
    return near[int(np.argmax(gains))]


def _loudest_swing(model: Model, still: Model, joint: int) -> Swing | None:
    # The swing with the largest gain at a joint beside a spring and a rotor (``still``), then tuned without these two.
    gap = model.gap
    every = max(1, gap.chain.time.size // SCREENED_ROWS)
    shown = shown_swings(gap)
    tried = shown.swings(joint)
    if not tried:
        return None
    _, gains = still.system.screen({joint: courses(gap, tried, every)}, every)
    if np.max(gains) < UNTUNED * (1.0 - RESONANT) * still.system.normal.error(still.strengths)[joint]:
        return None
    best = tried[int(np.argmax(gains))]

    def lost(place: Floats) -> float:
        swing = Swing(joint, *map(float, np.exp(place)))
        return -float(model.system.screen({joint: courses(gap, [swing])})[1][0]) if shown.holds(swing) else np.inf

    start = np.log([best.frequency, best.damping_ratio])
    around = start + np.array([[0.0, 0.0], [best.damping_ratio, 0.0], [0.0, 0.5]])
    options = {"initial_simplex": around, "xatol": CLOSE * best.damping_ratio, "fatol": CLOSE, "maxfev": MOST_TUNINGS}
    tuned = minimize(lost, start, method="Nelder-Mead", options=options)
    return Swing(joint, *map(float, np.exp(tuned.x)))
