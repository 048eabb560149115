"""Curved causes on the nonlinear balance: the effort of a delay, tilt, payload or zero offset is nonlinear in its size.

Each is replaced by its tangent at the fitted strengths, taken from what the extended robot predicts, and fitted again
(Gauss-Newton).  Otherwise a second, false cause would absorb what a first-order fit leaves of a tilt of a few degrees.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from mjfriction.diagnose.causes.cause import Site
from mjfriction.diagnose.fit.model import Chosen, Model, Tangent, build_model
from mjfriction.identify.gap import Gap
from mjfriction.identify.regression import Columns
from mjfriction.record.log import Floats
from mjfriction.robot.robot import Robot

ROUNDS = 4
SETTLED = 1e-3  # relative change of the strengths at which the rounds end
NEAR = 0.1  # relative change of the strengths below which slopes are kept; the effort itself is always predicted again


def straightened(model: Model, newcomer: Chosen | None = None) -> Model:
    """Return the model with every curved cause refitted on what the extended robot predicts.

    With a ``newcomer``, one of the model's causes, only this one is linearised again; the others stay at the points
    where they were linearised.
    """
    for _ in range(ROUNDS):
        strengths = [
            _drawn_at(choice, fitted, newcomer is None or choice.key == newcomer.key)
            for choice, fitted in model.fitted_causes
        ]
        pairs = list(zip(model.chosen, strengths, strict=True))
        if not any(_bends(model, *pair) for pair in pairs) or not all(_admissible(model, *pair) for pair in pairs):
            return model
        drawn = [c for c in model.chosen if c.cause.curved and (newcomer is None or c.key == newcomer.key)]
        chosen = _tangents(model, strengths, drawn)
        model = build_model(model.gap, model.nuisance, chosen)
        moved = [fitted for _, fitted in model.fitted_causes]
        anew = {choice.key for choice in drawn}
        steps = [(a, b) for c, a, b in zip(chosen, strengths, moved, strict=True) if c.key in anew]
        if all(np.linalg.norm(b - a) <= SETTLED * np.linalg.norm(a) for a, b in steps):
            break
    return model


def _drawn_at(choice: Chosen, strengths: Floats, anew: bool) -> Floats:
    # The strengths to linearise at.  Columns that were drawn around a searched strength are valid there, but may not be
    # valid at the strength that their fit leads to.
    if choice.tangent:
        return strengths if anew else choice.tangent.drawn_at
    return strengths if not choice.site.around else np.array([choice.site.around])


def _bends(model: Model, choice: Chosen, strengths: Floats) -> bool:
    # An effect that is too small for a finding is too small for its curvature to matter.
    return choice.cause.curved and choice.cause.noteworthy(model.gap, choice.site, strengths)


def _admissible(model: Model, choice: Chosen, strengths: Floats) -> bool:
    # Judged around its present strength, not the one it was drawn around before, however far other causes have since
    # let it move.
    return not choice.cause.curved or choice.cause.admissible(model.gap, _moved(choice.site, strengths), strengths)


def _moved(site: Site, strengths: Floats) -> Site:
    return replace(site, around=float(strengths[0])) if site.around else site


def _tangents(model: Model, strengths: list[Floats], drawn: list[Chosen]) -> tuple[Chosen, ...]:
    gap, keys = model.gap, [choice.key for choice in drawn]
    pairs = list(zip(model.chosen, strengths, strict=True))
    curved = [pair for pair in pairs if pair[0].cause.curved]
    # A late sensor also reports late what other causes add, including the straight (linear) ones.
    sensed = any(choice.cause.of_sensor for choice, _ in curved)
    straight = [(c, own) for c, own in pairs if sensed and not c.cause.curved and _possible(gap, c, own)]
    punctual = _predicted(gap, straight) if straight else gap.predicted_as_stated
    held_late = _held_late(gap, straight)
    stated = punctual - held_late
    whole = _predicted(gap, [*straight, *curved])
    effects, slopes = {}, {}
    for i, (choice, own) in enumerate(curved):
        if choice.key not in keys:
            continue
        others = [*straight, *curved[:i], *curved[i + 1 :]]
        before = punctual if len(others) == len(straight) else _predicted(gap, others)
        effects[choice.key] = whole - before + (held_late if choice.cause.of_sensor else 0.0)
        slopes[choice.key] = _near(choice, own) or _slopes(gap, _lasting(others), choice, own)
    # The combined effect of all curved causes, beyond the sum of what each adds beside the others, is shared equally
    # among them.  If only a newcomer is linearised, it is left to the others.
    together = (whole - stated - sum(effects.values())) / len(curved) if len(drawn) == len(curved) else 0.0
    out = []
    for choice, own in zip(model.chosen, strengths, strict=True):
        if choice.key not in keys:
            out.append(choice)
            continue
        columns, drawn_at = slopes[choice.key]
        bend = effects[choice.key] + together
        for joint, slope in columns.items():
            bend[:, joint] -= slope @ own
        out.append(replace(choice, site=_moved(choice.site, own), tangent=Tangent(columns, bend, drawn_at)))
    return tuple(out)


def _possible(gap: Gap, choice: Chosen, strengths: Floats) -> bool:
    return choice.cause.admissible(gap, choice.site, strengths)


def _held_late(gap: Gap, straight: list[tuple[Chosen, Floats]]) -> Floats:
    # The effort by which punctual columns of straight causes differ from their columns, which are late already: this
    # lateness is no longer an effect of the delay.
    out = np.zeros_like(gap.residual)
    for choice, own in straight if np.any(gap.late) else ():
        now, then = (choice.cause.columns(one, choice.site) for one in (gap, gap.prompt))
        for joint, columns in now.items():
            out[:, joint] += (then[joint] - columns) @ own
    return out


def _near(choice: Chosen, own: Floats) -> tuple[Columns, Floats] | None:
    # The existing slopes, if they were drawn at strengths that are near enough.
    old = choice.tangent
    if old is None or np.linalg.norm(own - old.drawn_at) > NEAR * np.linalg.norm(old.drawn_at):
        return None
    return old.columns, old.drawn_at


def _lasting(others: list[tuple[Chosen, Floats]]) -> list[tuple[Chosen, Floats]]:
    # The other causes beside which a slope is drawn.  The moments at which a link lands after crossing its play jump as
    # its load changes by ever so little, and a difference quotient would hold little else.
    return [(other, own) for other, own in others if not other.cause.brief]


def _slopes(gap: Gap, others: list[tuple[Chosen, Floats]], choice: Chosen, own: Floats) -> tuple[Columns, Floats]:
    whole, parts = _predicted(gap, [*others, (choice, own)]), []
    for k in range(own.size):
        step = np.zeros(own.size)
        step[k] = choice.cause.tangent_step * max(abs(own[k]), 0.1 * float(np.linalg.norm(own)))
        parts.append((_predicted(gap, [*others, (choice, own + step)]) - whole) / step[k])
    slopes = np.stack(parts, axis=2)
    return {joint: slopes[:, joint] for joint in gap.examined}, own


def _predicted(gap: Gap, curved: list[tuple[Chosen, Floats]]) -> Floats:
    robot: Robot = gap.robot
    for choice, strengths in curved:
        robot = choice.cause.extend(robot, choice.site, strengths)
    return gap.predicted(robot)
