"""One candidate cause tried against a model."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mjfriction.diagnose.model import Chosen, Model, cause_block
from mjfriction.diagnose.nearness import nearness, nearness_of
from mjfriction.diagnose.refitted import FEWEST_JOINTS
from mjfriction.diagnose.wald import Wald, wald
from mjfriction.identify.normal import Normal
from mjfriction.identify.regression import Columns
from mjfriction.record.log import Floats, Integers

FALSE_ALARM = 0.01  # stated chance that a log without any cause yields one, from noise alone
LEAST_SHARE = 0.01  # of a joint's remaining error that a cause must take away on motion not fitted
LEAST_EFFECT = 0.005  # of the joint's RMS effort that a cause's own effort must reach
UNEVEN = 0.015  # of a joint's friction, that waves along its stroke are at on a machine as uneven as real ones
EVENEST = 0.25  # of what is asked on such a machine, that is asked on the most even one
# Times as large as waves are at two joints at least, that one has to be; past how much of friction they are not such.
STANDS_OUT, WAVIEST = 1.5, 0.06
MOST = 0.95  # of rows, on which an effort is less than it is at its most
MOST_OF_SEVERAL = 0.995  # the same where several joints feel it


@dataclass(frozen=True)
class Trial:
    """What a candidate does for a model.

    ``improvement`` (blocks,) is the weighted squared error it takes off each block when fitted to the others, ``error``
    (blocks,) what was there before, both at the joints it touches; ``elsewhere`` is the improvement at the others,
    whose links stood in for it, and ``relief`` by how much likelier it makes the refitted drives and links, in the same
    unit.  At the joint that loses the largest share of its error, ``effect`` is its RMS effort relative to the joint's,
    which has to be ``least_effect``, ``of_friction`` its most beside levels, relative to the joint's friction, of which
    it has to be ``least_of_friction``, and ``least_told`` to be told.  ``walds`` test its strengths by what the blocks
    of motion say of them, and, where refitted drives and links had stood in for it, by what these say.
    """

    chosen: Chosen
    improvement: Floats
    error: Floats
    elsewhere: float
    relief: float
    effect: float
    of_friction: float
    least_effect: float
    least_of_friction: float
    least_told: float
    walds: tuple[Wald, ...]

    @property
    def gain(self) -> float:
        """The improvement summed over the blocks, here and elsewhere, and the relief."""
        return float(np.sum(self.improvement)) + self.elsewhere + self.relief

    @property
    def stood_in_for(self) -> bool:
        """Whether drives and links are much nearer to what is stated with it, and all of them near."""
        return len(self.walds) > 1

    @property
    def merit(self) -> float:
        """The gain less what every freedom, the searched shape included, is worth on noise alone."""
        fitted = self.walds[0].count + len(self.chosen.site.shape)
        return self.gain - fitted * float(np.log(self.improvement.size))

    @property
    def share(self) -> float:
        """The share of the error taken away on motion not fitted."""
        return self.gain / max(float(np.sum(self.error)), 1e-300)

    @property
    def chance(self) -> float:
        """The probability of strengths so far from zero if there is no such effect."""
        return min(own.chance for own in self.walds)

    def least_seen(self, chance: float) -> float:
        """Return how much of the joint's friction such an effect would be if it were just beyond a ``chance``."""
        return self.of_friction * min(own.reached(chance) for own in self.walds)

    def beyond_chance(self, candidates: float) -> bool:
        """Return whether the effect is beyond chance among so many candidates, however little it makes."""
        # Of an error that drives and links have taken away nothing is left to take.
        counts = self.share > LEAST_SHARE or self.stood_in_for
        return counts and self.chance < FALSE_ALARM / max(candidates, 1.0)

    def passes(self, candidates: float) -> bool:
        """Return whether the effect is beyond chance among so many candidates, and large enough to matter."""
        large = self.effect > self.least_effect and self.of_friction > self.least_of_friction
        return large and self.beyond_chance(candidates)


def try_out(model: Model, choice: Chosen, *, repeating: bool = False) -> Trial | None:
    """Measure a candidate's held-out improvement over a model; None when what is fitted with it is not physical.

    With ``repeating``, chance is judged over the repetitions of the motion where it repeats, else over the blocks: what
    a repeated motion leaves alike each time is then no noise, and there are few repetitions to judge by.
    """
    gap = model.gap
    columns, precision = cause_block(gap, choice)
    normal = model.with_candidate(choice)
    fitted = normal.fitted
    strengths = fitted[-precision.size :]
    touched = list(columns)
    if not choice.cause.admissible(gap, choice.site, strengths):
        return None
    if not model.friction_is_physical(fitted, touched, choice):
        return None
    errors_before, errors_after = model.heldout_errors, normal.heldout_errors(gap.blocks.folds)
    before, after = errors_before[touched], errors_after[touched]
    elsewhere = float(np.sum(errors_before - errors_after)) - float(np.sum(before - after))
    # What no motion shows, three of a payload's four numbers on a sliding axis, is no freedom.
    shown = np.any([np.any(values != 0.0, axis=0) for values in columns.values()], axis=0)
    count = max(1, int(np.count_nonzero(shown)))
    groups = gap.blocks.group if repeating else np.arange(gap.blocks.count)
    walds = [_wald(model, normal, groups, precision.size, count, int(groups[-1]))]
    far, near = nearness_of(model), nearness(model.nuisance, normal)
    relief = far.strain - near.strain
    if near.spread < 1.0 and relief > count * float(np.log(gap.blocks.count)):
        tighter = normal.tighter(model.nuisance.of_stated, near.spread**-2)
        walds.append(_wald(model, tighter, groups, precision.size, count, min(int(groups[-1]), round(far.shown))))
    if len(walds) > 1 and np.sum(before - after) < LEAST_SHARE * np.sum(before):
        # What stood in for it left no error that could show where it is.
        most = max(_feeling(columns), key=lambda joint: effects(model, choice, strengths, joint)[1])
    else:
        most = _where_it_shows(columns, before.sum(axis=1), after.sum(axis=1))
    size = effects(model, choice, strengths, most)
    improvement, error = (before - after).sum(axis=0), before.sum(axis=0)
    left = left_of_friction(model, _rms_of(model, after[touched.index(most)], most), most)
    least = least_effect(model, choice, left), least_of_friction(model, choice, left), least_told(model, choice, left)
    return Trial(choice, improvement, error, elsewhere, relief, *size, *least, tuple(walds))


def _wald(model: Model, normal: Normal, groups: Integers, size: int, count: int, spare: int) -> Wald:
    # Of the last strengths of a fit, as many as ``size``.
    own, blocks = slice(-size, None), model.gap.blocks
    covariances = [normal.covariance(groups)]
    if int(groups[-1]) + 1 == blocks.count:
        # Where few blocks carry most of the information the clustered covariance is too small; where noise is coloured
        # the one for white noise is.  The effect must stand out against both.  (Over repetitions there is no second:
        # white noise would count in what they leave alike.)
        covariances.append(normal.white_covariance(_left_of_noise(model, normal)))
    return wald(normal.fitted[own], [one[own, own] for one in covariances], count, spare)


def effects(model: Model, choice: Chosen, strengths: Floats, joint: int) -> tuple[float, float]:
    """Return the RMS effort that strengths of a cause make at a joint, relative to the joint's, and the most that it
    makes beside the joint's levels, relative to its friction.
    """
    columns, _ = cause_block(model.gap, choice)
    made = columns[joint] @ strengths
    of_effort = float(np.linalg.norm(made) / np.linalg.norm(model.gap.measured[:, joint]))
    return of_effort, at_its_most(model, columns, made, joint) / model.friction[joint]


def at_its_most(model: Model, columns: Columns, made: Floats, joint: int) -> float:
    """Return how large what a cause with such ``columns`` has ``made`` at a joint (rows,) gets, less what the joint's
    refitted levels could make of it: friction that grows with the load is a higher level, and little besides.

    What several joints feel is no unevenness of one joint's friction, and may show in few rows, as play does.
    """
    share = MOST if len(columns) == 1 else MOST_OF_SEVERAL
    return float(np.quantile(np.abs(model.beyond_levels(made, joint)), share))


def negligible(model: Model, choice: Chosen, strengths: Floats, before: Floats, after: Floats) -> bool:
    """Return whether strengths of a cause make too little of the effort, or of the friction, to be told, at the joint
    where it shows most: ``before`` and ``after`` (rows, joints) are left without it and with it.
    """
    joint = shown_at(model, choice, before, after)
    of_effort, of_friction = effects(model, choice, strengths, joint)
    left = left_of_friction(model, model.gap.rms(after[:, joint], joint), joint)
    return of_effort < least_effect(model, choice, left) or of_friction < least_told(model, choice, left)


def least_effect(model: Model, choice: Chosen, left: float = np.inf) -> float:
    """Return how much of a joint's RMS effort a cause has to make, ``left`` being as for :func:`least_of_friction`.

    What one joint shows of so little may be anything; what all show alike, on a machine that is even, may not.
    """
    return LEAST_EFFECT * (_unevenness(model, choice, left) if choice.cause.whole_arm else 1.0)


def least_of_friction(model: Model, choice: Chosen, left: float = np.inf) -> float:
    """Return how much of a joint's friction a cause has to be on this machine.

    Of few joints it is not known how uneven they are; but where what is ``left`` beside the cause and the sensor's
    noise (RMS, relative to friction) is less than an uneven machine's waves would leave, this one is more even.  Waves
    themselves are those, and where all joints show some, the ripple of their gears, one has to stand out.
    """
    least = _unevenness(model, choice, left) * choice.cause.least_of_friction
    return max(least, STANDS_OUT * min(model.nuisance.wavy, WAVIEST)) if choice.cause.of_unevenness else least


def least_told(model: Model, choice: Chosen, left: float = np.inf) -> float:
    """Return how much of a joint's friction a cause has to be on this machine to be told, ``left`` being as for
    :func:`least_of_friction`; one that is less is refitted along.
    """
    told = _unevenness(model, choice, left) * choice.cause.least_told
    return max(least_of_friction(model, choice, left), told)


def _unevenness(model: Model, choice: Chosen, left: float) -> float:
    # Relative to real machines.
    uneven, few = model.nuisance.uneven, len(model.gap.examined) < FEWEST_JOINTS
    if few and not choice.cause.of_unevenness:
        uneven = min(uneven, max(EVENEST, left / (UNEVEN / np.sqrt(2.0))))
    return float(uneven)


def shown_at(model: Model, choice: Chosen, before: Floats, after: Floats) -> int:
    """Return at which of the joints that feel it a cause takes the largest share of the error away."""
    gap, (columns, _) = model.gap, cause_block(model.gap, choice)
    return max(_feeling(columns), key=lambda j: gap.rms(before[:, j], j) / max(gap.rms(after[:, j], j), 1e-300))


def left_of_friction(model: Model, rms: float, joint: int) -> float:
    """Return what is left at a joint (RMS) beyond its sensor's noise, relative to its friction."""
    beyond = max(0.0, rms**2 - float(model.gap.noise_floor[joint]) ** 2)
    return float(np.sqrt(beyond)) / model.friction[joint]


def _rms_of(model: Model, errors: Floats, joint: int) -> float:
    # What weighted errors (blocks,) at a joint come to, RMS.
    power = float(np.sum(np.square(model.system.rows.weight[:, joint])))
    return float(np.sqrt(np.sum(errors) / max(power, 1e-300)))


def _where_it_shows(columns: Columns, before: Floats, after: Floats) -> int:
    # At which of the joints that feel a cause the largest share of the error goes; the errors (joints,) are those of
    # all that have a column.
    left = np.divide(after, before, out=np.ones_like(after), where=before > 0.0)
    of_joint = dict(zip(columns, left.tolist(), strict=True))
    return min(_feeling(columns), key=lambda joint: of_joint[joint])


def _feeling(columns: Columns) -> list[int]:
    # The joints that feel a cause itself.  Others may gain too: links that stood in for it are as stated again.
    felt = [joint for joint, values in columns.items() if np.any(values)]
    return felt or list(columns)


def _left_of_noise(model: Model, normal: Normal) -> Floats:
    # Rows are weighed by what the model leaves without the candidate: what it explains is no noise, (joints,).
    without, beside = model.system.normal.error(model.strengths), normal.error(normal.fitted)
    return np.asarray(np.divide(beside, without, out=np.ones_like(beside), where=without > 0.0))
