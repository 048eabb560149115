"""What a log could show: how large every cause would have to be for this motion to reveal it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.stats import chi2

from mjfriction.diagnose.causes.catalog import STRUCTURAL
from mjfriction.diagnose.fit.model import Chosen, Model, build_model, cause_block
from mjfriction.diagnose.fit.nuisance import make_nuisance
from mjfriction.diagnose.fit.small_errors import as_noise, least_to_stand_out
from mjfriction.diagnose.fit.trial import (
    FALSE_ALARM,
    LEAST_SHARE,
    at_its_most,
    least_effect,
    least_told,
    left_of_friction,
)
from mjfriction.diagnose.search.field import make_field, size
from mjfriction.diagnose.search.unevenness import with_unevenness
from mjfriction.diagnose.tell.alike import redundancy
from mjfriction.identify.gap import Gap
from mjfriction.progress import Tell, counting, silently
from mjfriction.record.log import Floats


@dataclass(frozen=True)
class Visible:
    """A cause at a joint (None for one of the whole arm), and the least RMS effort (``size``, N·m or N) that it has to
    make there to be found; ``share`` is this size over the joint's RMS effort.
    """

    cause: str
    joint: str | None
    size: float
    share: float


def visible_causes(gap: Gap, tell: Tell = silently) -> tuple[Visible, ...]:
    """Return the least detectable effect of every cause that the motion of a log excites, smallest first at each joint.

    A cause's strengths θ are beyond chance when θᵀC⁻¹θ exceeds the χ² quantile at the competition's level.  C is their
    covariance in a regression with all nuisances.  The effect is the mean over the directions of θ, at the middle shape
    of the cause's grid.  The noise is the residual of the stated robot with its nuisances refitted.  ``tell`` is called
    for each cause.
    """
    field = make_field(gap, STRUCTURAL)
    model = build_model(gap, with_unevenness(gap, make_nuisance(gap)), ())
    chance = FALSE_ALARM / max(size(field), 1)
    # Coloured noise carries less information: ``alike`` is the number of rows that count as one.
    left = model.residual()
    alike = {joint: redundancy(left[:, joint] * model.system.rows.weight[:, joint]) for joint in gap.examined}
    least: dict[tuple[str, str | None], Visible] = {}
    begin = counting(tell, len(field))
    for entrant in field:
        begin(f"could it show {entrant.cause.name}")
        joint = entrant.joint
        if joint not in alike:
            continue
        choice = Chosen(entrant.cause, entrant.sites[len(entrant.sites) // 2])
        effect = max(_least(model, choice, chance, alike[joint]), _least_told(model, choice, left[:, joint]))
        name = None if entrant.cause.whole_arm else gap.robot.joints[joint]
        found = Visible(entrant.cause.name, name, effect, effect / max(_rms(gap.measured[:, joint]), 1e-300))
        key = (found.cause, found.joint)
        if np.isfinite(effect) and (key not in least or effect < least[key].size):
            least[key] = found
    return tuple(sorted(least.values(), key=lambda one: (one.joint or "", one.share)))


def _least(model: Model, choice: Chosen, chance: float, alike: float) -> float:
    columns, precision = cause_block(model.gap, choice)
    own, count = columns[choice.site.joint], precision.size
    covariance = model.with_candidate(choice).known_to(alike)[-count:, -count:]
    power = own.T @ own / own.shape[0]
    return float(np.sqrt(chi2.isf(chance, count) * np.trace(power @ covariance) / count))


def _least_told(model: Model, choice: Chosen, left: Floats) -> float:
    # However certain, an effect is not reported if it is less than a share of the effort, of the residual or, at its
    # largest, of the joint's friction, if it does not stand out of the model's small errors, or if no such value is
    # known any better.
    joint, (columns, _) = choice.site.joint, cause_block(model.gap, choice)
    rms = model.gap.rms(left, joint)
    beside, quiet = left_of_friction(model, rms, joint), as_noise(model.gap, joint, rms)
    most = max(at_its_most(model, choice, columns, own, joint) / max(_rms(own), 1e-300) for own in columns[joint].T)
    return max(
        least_effect(model, choice, beside, quiet=quiet) * _rms(model.gap.measured[:, joint]),
        least_told(model, choice, beside) * model.friction[joint] / max(most, 1e-300),
        float(np.sqrt(LEAST_SHARE)) * _rms(left),
        least_to_stand_out(model.gap, joint, left),
        choice.cause.least_change(model.gap, choice.site) * _rms(columns[joint][:, 0]),
    )


def _rms(values: Floats) -> float:
    return float(np.sqrt(np.mean(np.square(values))))
