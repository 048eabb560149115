"""``reproduce manipulator``: friction of industrial arms from forward-backward passes, and the currents it predicts.

Indri, Lazzero, Antoniazza, Bottero, "Friction modeling and identification for industrial manipulators", ETFA 2013.
"""

from __future__ import annotations

import numpy as np

from mjfriction.body.gravity_pose import GravityClass
from mjfriction.identify.bristle_fit import BRISTLE
from mjfriction.laws.ambient import ambient
from mjfriction.laws.law import Floats
from mjfriction.progress import Tell, counting
from mjfriction.reproduce.manipulator.arm import (
    ARMS,
    stated_arm,
)
from mjfriction.reproduce.manipulator.experiments import LAWS, STEPS, Arm, run_arm
from mjfriction.reproduce.manipulator.tables import (
    bristles_found,
    current_errors,
    gravity_classes,
    load_found,
    pendulums,
    static_errors,
    static_parameters,
)
from mjfriction.reproduce.outcome import Claim, Line, Picture, Reproduction

SHOWN = {0: "figure 2", 2: "figure 3", 4: "figure 4"}
THIN = slice(None, None, 5)
SLOW_SPEED = 8.0  # rad/s of the motor; figure 1 is drawn up to this speed


def reproduce_manipulator(tell: Tell, seed: int = 0) -> Reproduction:
    """Run the document's experiments on both arms; ``tell`` is called at each step."""
    begin = counting(tell, STEPS * len(ARMS))
    arms = [run_arm(name, begin, seed) for name in ARMS]
    first = arms[0]
    return Reproduction(
        name="manipulator",
        title="Friction of industrial manipulators, and the currents it takes",
        source=(
            "Indri, Lazzero, Antoniazza, Bottero, Friction modeling and identification for industrial manipulators, "
            "ETFA 2013"
        ),
        how=_how(),
        tables=(
            gravity_classes(arms),
            *(static_parameters(arm) for arm in arms),
            *(bristles_found(arm) for arm in arms),
            pendulums(arms),
            load_found(arms),
            *(static_errors(arm) for arm in arms),
            *(current_errors(arm, "slow", "Table 4: currents along the near-sinusoidal motion") for arm in arms),
            *(current_errors(arm, "work", "Currents of pick and place") for arm in arms),
        ),
        pictures=tuple(picture for arm in arms for picture in _pictures(arm)),
        claims=_claims(arms),
        differs=_differs(first),
    )


def _pictures(arm: Arm) -> list[Picture]:
    out = [_very_slow(arm)]
    for i, figure in SHOWN.items():
        fit = arm.fits[i]
        speed = np.geomspace(fit.points.speed[0], fit.points.speed[-1], 200) * fit.ratio
        around = ambient(speed.size)
        lines = [Line("passes", fit.points.speed * fit.ratio, fit.points.friction / fit.ratio, marks=True)]
        for name, found in (("Coulomb-viscous", fit.coulomb_viscous), ("static law", fit.static)):
            lines.append(Line(name, speed, found.law.along(speed, around, found.law.pack(found.values))))
        out.append(
            Picture(
                f"{arm.name}: friction of joint {i + 1}",
                "speed of the motor, rad/s",
                "friction, N·m of the motor",
                tuple(lines),
                figure,
                logarithmic=True,
            )
        )
    for told, joint, figure, what in (
        (arm.slow, 0, "figure 5", "near-sinusoidal motion"),
        (arm.work, 1, "figure 6", "pick and place"),
    ):
        lines = [Line("measured", told.time[THIN], told.measured[THIN, joint])]
        lines += [Line(law, told.time[THIN], told.by[law][THIN, joint]) for law in (LAWS[0], LAWS[2])]
        out.append(
            Picture(f"{arm.name}: current of joint {joint + 1}, {what}", "time, s", "current, A", tuple(lines), figure)
        )
    return out


def _very_slow(arm: Arm) -> Picture:
    # Figure 1: the current that the links do not explain, against speed, at low speeds.
    told, constant = arm.slow, stated_arm(arm.name).table.joint[0].actuator.torque_constant
    assert constant is not None
    speed = told.speed[:, 0]
    slow = (np.abs(speed) < SLOW_SPEED) & (told.time > 0.25 * told.time[-1]) & (told.time < 0.75 * told.time[-1])

    def course(name: str, current: Floats) -> Line:
        # The slow parts of the motion are separate in time; NaN gaps keep them separate in the picture.
        cut = np.flatnonzero(np.diff(np.flatnonzero(slow)) > 1) + 1
        return Line(name, np.insert(speed[slow], cut, np.nan), np.insert(constant * current[slow], cut, np.nan))

    return Picture(
        f"{arm.name}: friction of joint 1 at very low speeds",
        "speed of the motor, rad/s",
        "friction, N·m of the motor",
        (
            course("measured", told.measured[:, 0] - told.links[:, 0]),
            course("dynamic law", told.by[LAWS[2]][:, 0] - told.links[:, 0]),
        ),
        "figure 1",
    )


def _claims(arms: list[Arm]) -> tuple[Claim, ...]:
    static = {arm.name: [fit.checked[0] / fit.checked[1] for fit in arm.fits] for arm in arms}
    current = {arm.name: arm.slow.rms(LAWS[0]) / arm.slow.rms(LAWS[2]) for arm in arms}
    working = {arm.name: arm.work.rms(LAWS[0]) / arm.work.rms(LAWS[2]) for arm in arms}

    loads = [own for arm in arms for own in arm.loads]
    loaded = [
        fit.off
        for arm in arms
        for fit, kind in zip(arm.fits, arm.classes, strict=True)
        if kind == GravityClass.ALWAYS.value
    ]

    def listed(values: dict[str, list[float]] | dict[str, Floats]) -> str:
        return "; ".join(f"{name}: {', '.join(f'{value:.3g}' for value in own)}" for name, own in values.items())

    return (
        Claim(
            "At every joint the static law fits new passes better than Coulomb and viscous friction.",
            all(value > 1.0 for own in static.values() for value in own),
            f"times better, joints 1 to 6: {listed(static)}",
        ),
        Claim(
            "Along the near-sinusoidal motion the dynamic law tells the currents of every joint better.",
            all(value > 1.0 for own in current.values() for value in own),
            f"times better: {listed(current)}",
        ),
        Claim(
            "So it does along a typical operation.",
            all(value > 1.0 for own in working.values() for value in own),
            f"times better: {listed(working)}",
        ),
        Claim(
            "Where gravity loads a joint, the model's pendulum tells its friction worse than passes both ways.",
            all(model > both for model, _, both in loaded),
            f"times worse: {', '.join(f'{model / both:.3g}' for model, _, both in loaded)}",
        ),
        Claim(
            "What a payload adds to friction comes out of passes without it and with it.",
            all(abs(own.found.values["static_load"] - own.static) < own.found.half["static_load"] for own in loads),
            "; ".join(
                f"{arm.name}, joint {own.joint + 1}: {own.found.values['static_load']:.3g} "
                f"± {own.found.half['static_load']:.2g}, true {own.static:.3g}"
                for arm in arms
                for own in arm.loads
            ),
        ),
    )


def _how() -> tuple[str, ...]:
    return (
        "The arms are simulated in MuJoCo with the published friction (the NJ60's scaled from it) and more than any "
        "law under test holds: levels that grow with the torque transmitted, ripple of the motors, links 3 % off "
        "the model, current loops, encoders of 21 bit, currents of 16 bit with noise.",
        "Passes forward and backward of each joint alone, at motor speeds from 0.8 to 400 rad/s, each where gravity "
        "loads the joint least; phases of constant speed are found in the log, and half the difference of both "
        "directions is friction. Judged is on new passes at other speeds.",
        "Currents are told along the wanted motion, as by the document's simulator, and held against those recorded.",
    )


def _differs(arm: Arm) -> tuple[str, ...]:
    told = [i + 1 for i, fit in enumerate(arm.bristles) if fit.half[BRISTLE[0]] < fit.together[BRISTLE[0]]]
    return (
        "The Coulomb-viscous model that the document compares with is the one in the robot's controller; ours is "
        "fitted to the same passes, and so is nearer.",
        "Our currents carry the errors of a simulated machine only, so that the dynamic law leaves less than the "
        "document's, and the ratios are larger than its 1.3 to 1.4.",
        "Of Table 2 logs like these tell little: a bristle of 765 500 N·m/rad yields within 2 µrad of the motor, less "
        "than one step of its encoder (3 µrad). Its stiffness is known to within its own size at "
        f"{'joints ' + ', '.join(map(str, told)) if told else 'no joint'}; the document printed no intervals.",
        "The slope near zero gives δ only where passes are slow enough that friction still falls steeply: at 0.8 "
        "rad/s an arctangent with δ = 10 s has fallen by nine tenths already.",
    )
