"""One candidate cause tried against a model."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mjfriction.diagnose.fit.model import Chosen, Model, cause_block
from mjfriction.diagnose.fit.nearness import nearness, nearness_of
from mjfriction.diagnose.fit.refitted import FEWEST_JOINTS
from mjfriction.diagnose.fit.small_errors import as_noise, noise_alone
from mjfriction.diagnose.fit.wald import Wald, wald
from mjfriction.identify.normal import Normal
from mjfriction.identify.regression import Columns
from mjfriction.record.log import Floats, Integers

FALSE_ALARM = 0.01  # target chance that noise alone yields a cause on a log without any
LEAST_SHARE = 0.01  # share of the remaining held-out error that a cause must remove at the joints it touches
LEAST_EFFECT = 0.005  # fraction of the joint's RMS effort that a cause's own effort must reach
BRIEFLY = 0.5  # the same for a cause that shows in few rows, as a part of it: its RMS effort says little of its size
QUIETLY = 0.2  # the same where no more than the sensor's noise is left
UNEVEN = 0.015  # size of waves along the stroke, relative to friction, on a machine as uneven as real ones
EVENEST = 0.25  # size required of a cause on the most even machine, relative to one that is as uneven as real ones
# A wave must be STANDS_OUT times as large as the waves that half of the joints show.  Of those, no more than WAVIEST
# (relative to friction) is counted: larger ones are not the machine's unevenness.
STANDS_OUT, WAVIEST = 1.5, 0.06
MOST = 0.95  # quantile over the rows that is taken for the maximum of an effort
OF_FEW = 0.3  # an effort comes in few rows where the one quantile is less than this fraction of the other
MOST_OF_FEW = 0.995  # the same for an effort that several joints feel, or that comes in few rows


@dataclass(frozen=True)
class Trial:
    """What a candidate does for a model.

    ``improvement`` (blocks,) is the weighted squared error it removes from each block when fitted to the others, and
    ``error`` (blocks,) the error before, both at the joints it touches.  ``elsewhere`` is the improvement at the other
    joints, whose links stood in for it.  ``relief`` is how much likelier it makes the refitted drives and links, in the
    same unit.

    The sizes are taken at the joint that loses the largest share of its error or, where drives and links had taken that
    error away, at the joint with the largest ``of_friction``.  ``effect`` is the candidate's RMS effort relative to the
    joint's effort; it must exceed ``least_effect``.  ``of_friction`` is the largest effort that it makes beyond the
    joint's levels, relative to the joint's friction; it must exceed ``least_of_friction``, and reach ``least_told`` to
    be reported.

    ``walds`` test its strengths on the blocks of motion and, where refitted drives and links had stood in for it, on
    these drives and links.
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
        """Whether drives and links stood in for it: with it they are much nearer to what is stated, and all near."""
        return len(self.walds) > 1

    @property
    def merit(self) -> float:
        """The gain less what every degree of freedom, searched shapes included, gains on noise alone."""
        fitted = self.walds[0].count + len(self.chosen.site.shape)
        return self.gain - fitted * float(np.log(self.improvement.size))

    @property
    def share(self) -> float:
        """The share of the held-out error that it removes."""
        return self.gain / max(float(np.sum(self.error)), 1e-300)

    @property
    def chance(self) -> float:
        """The probability of strengths so far from zero if there is no such effect."""
        return min(own.chance for own in self.walds)

    def least_seen(self, chance: float) -> float:
        """Return the size, relative to the joint's friction, at which such an effect is just beyond a ``chance``."""
        return self.of_friction * min(own.reached(chance) for own in self.walds)

    def beyond_chance(self, candidates: float) -> bool:
        """Return whether the effect is beyond chance among so many candidates, however small it is."""
        # Where drives and links have absorbed the error, none is left for the candidate to remove.
        counts = self.share > LEAST_SHARE or self.stood_in_for
        return counts and self.chance < FALSE_ALARM / max(candidates, 1.0)

    def passes(self, candidates: float) -> bool:
        """Return whether the effect is beyond chance among so many candidates, and large enough to matter."""
        large = self.effect > self.least_effect and self.of_friction > self.least_of_friction
        return large and self.beyond_chance(candidates)


def try_out(model: Model, choice: Chosen, *, repeating: bool = False) -> Trial | None:
    """Measure a candidate's held-out improvement over a model; None if what is fitted with it is not physical.

    With ``repeating``, chance is judged over the repetitions of a motion that repeats, otherwise over the blocks.  Over
    repetitions, a residual that is alike in all of them does not count as noise, and there are few to judge by.
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
    # Strengths that no motion excites, such as three of a payload's four on a sliding axis, are no degrees of freedom.
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
        # The drives and links that stood in for it left no error that could show where it is.
        most = max(_feeling(columns), key=lambda joint: effects(model, choice, strengths, joint)[1])
    else:
        most = _where_it_shows(columns, before.sum(axis=1), after.sum(axis=1))
    size = effects(model, choice, strengths, most)
    improvement, error = (before - after).sum(axis=0), before.sum(axis=0)
    rms = _rms_of(model, after[touched.index(most)], most)
    left, quiet = left_of_friction(model, rms, most), as_noise(gap, most, rms)
    least = (
        least_effect(model, choice, left, quiet=quiet),
        least_of_friction(model, choice, left),
        least_told(model, choice, left),
    )
    return Trial(choice, improvement, error, elsewhere, relief, *size, *least, tuple(walds))


def _wald(model: Model, normal: Normal, groups: Integers, size: int, count: int, spare: int) -> Wald:
    # The test of the last ``size`` strengths of a fit.
    own, blocks = slice(-size, None), model.gap.blocks
    covariances = [normal.covariance(groups)]
    if int(groups[-1]) + 1 == blocks.count:
        # The clustered covariance is too small where few blocks carry most of the information, and the white-noise one
        # is too small where noise is coloured.  The effect must stand out against both.  (Over repetitions only the
        # first is used: the white-noise one would count residuals that are alike in all repetitions.)
        covariances.append(normal.white_covariance(_left_of_noise(model, normal)))
    return wald(normal.fitted[own], [one[own, own] for one in covariances], count, spare)


def effects(model: Model, choice: Chosen, strengths: Floats, joint: int) -> tuple[float, float]:
    """Return the RMS effort that a cause makes at a joint, relative to the joint's effort, and the largest effort that
    it makes beyond the joint's levels, relative to the joint's friction.
    """
    columns, _ = cause_block(model.gap, choice)
    made = columns[joint] @ strengths
    of_effort = float(np.linalg.norm(made) / np.linalg.norm(model.gap.measured[:, joint]))
    return of_effort, at_its_most(model, choice, columns, made, joint) / model.friction[joint]


def at_its_most(model: Model, choice: Chosen, columns: Columns, made: Floats, joint: int) -> float:
    """Return the largest value of the effort that a cause with these ``columns`` has ``made`` at a joint (rows,), less
    what the joint's refitted levels could make of it.

    Friction that grows with load, for example, is mostly a higher level and little besides.  The largest value is a
    high quantile.  It is higher for a cause that several joints feel, which is not unevenness of one joint's friction,
    and for one that shows in few rows: by its nature, as play does, or because the motion accelerates in few.
    """
    usual, most = np.quantile(np.abs(model.beyond_levels(made, joint)), (MOST, MOST_OF_FEW)).tolist()
    few = choice.cause.brief or len(columns) > 1 or (choice.cause.brief_in_passes and usual < OF_FEW * most)
    return float(most if few else usual)


def negligible(model: Model, choice: Chosen, strengths: Floats, before: Floats, after: Floats) -> bool:
    """Return whether a cause makes too little of the effort, or of the friction, to be reported at the joint where it
    shows most; ``before`` and ``after`` (rows, joints) are the residuals without and with it.
    """
    joint = shown_at(model, choice, before, after)
    of_effort, of_friction = effects(model, choice, strengths, joint)
    left = left_of_friction(model, model.gap.rms(after[:, joint], joint), joint)
    least = least_effect(model, choice, left, quiet=noise_alone(model.gap, after))
    return of_effort < least or of_friction < least_told(model, choice, left)


def least_effect(model: Model, choice: Chosen, left: float = np.inf, *, quiet: bool = False) -> float:
    """Return the share of a joint's RMS effort that a cause must make; ``left`` is as for :func:`least_of_friction`.

    So small an effect at a single joint may be anything.  One that all joints show may not, if the machine is even: a
    cause of the whole arm may be smaller there, and so may one that shows in few rows.  Nor may one where all is
    ``quiet``, where no more than the sensor's noise is left: a joint that holds a heavy link has a large effort.  But
    a little of some causes is everywhere.
    """
    least = LEAST_EFFECT * (BRIEFLY if choice.cause.brief else 1.0)
    least *= _unevenness(model, choice, left) if choice.cause.whole_arm else 1.0
    return min(least, QUIETLY * LEAST_EFFECT) if quiet and not choice.cause.everywhere else least


def least_of_friction(model: Model, choice: Chosen, left: float = np.inf) -> float:
    """Return the size, relative to a joint's friction, that a cause must have on this machine.

    It is not known how uneven a machine with few joints is.  But if what is ``left`` beside the cause and the sensor's
    noise (RMS, relative to friction) is less than an uneven machine's waves would leave, this one is more even.  This
    does not hold for waves, which are the unevenness itself.  Where all joints show waves, as the ripple of their
    gears, a wave must stand out from them.
    """
    least = _unevenness(model, choice, left) * choice.cause.least_of_friction
    return max(least, STANDS_OUT * min(model.nuisance.wavy, WAVIEST)) if choice.cause.of_unevenness else least


def least_told(model: Model, choice: Chosen, left: float = np.inf) -> float:
    """Return the size, relative to a joint's friction, that a cause must have on this machine to be reported; a smaller
    one is refitted along.  ``left`` is as for :func:`least_of_friction`.
    """
    told = _unevenness(model, choice, left) * choice.cause.least_told
    return max(least_of_friction(model, choice, left), told)


def _unevenness(model: Model, choice: Chosen, left: float) -> float:
    # How uneven the machine is, relative to real ones.
    uneven, few = model.nuisance.uneven, len(model.gap.examined) < FEWEST_JOINTS
    if few and not choice.cause.of_unevenness:
        uneven = min(uneven, max(EVENEST, left / (UNEVEN / np.sqrt(2.0))))
    return float(uneven)


def shown_at(model: Model, choice: Chosen, before: Floats, after: Floats) -> int:
    """Return the joint, of those that feel a cause, at which it removes the largest share of the error."""
    gap, (columns, _) = model.gap, cause_block(model.gap, choice)
    return max(_feeling(columns), key=lambda j: gap.rms(before[:, j], j) / max(gap.rms(after[:, j], j), 1e-300))


def left_of_friction(model: Model, rms: float, joint: int) -> float:
    """Return the part of a joint's residual ``rms`` that is beyond its sensor's noise, relative to its friction."""
    beyond = max(0.0, rms**2 - float(model.gap.noise_floor[joint]) ** 2)
    return float(np.sqrt(beyond)) / model.friction[joint]


def _rms_of(model: Model, errors: Floats, joint: int) -> float:
    # The RMS residual of a joint with these weighted squared errors (blocks,).
    power = float(np.sum(np.square(model.system.rows.weight[:, joint])))
    return float(np.sqrt(np.sum(errors) / max(power, 1e-300)))


def _where_it_shows(columns: Columns, before: Floats, after: Floats) -> int:
    # The joint, of those that feel a cause, that loses the largest share of its error; the errors (joints,) are those
    # of all joints that have a column.
    left = np.divide(after, before, out=np.ones_like(after), where=before > 0.0)
    of_joint = dict(zip(columns, left.tolist(), strict=True))
    return min(_feeling(columns), key=lambda joint: of_joint[joint])


def _feeling(columns: Columns) -> list[int]:
    # The joints that feel a cause itself.  Others may improve too, when links that stood in for it return to what is
    # stated.
    felt = [joint for joint, values in columns.items() if np.any(values)]
    return felt or list(columns)


def _left_of_noise(model: Model, normal: Normal) -> Floats:
    # The variance of the noise of weighted rows (joints,).  Rows are weighted by the model's residual without the
    # candidate, and what the candidate explains is not noise.
    without, beside = model.system.normal.error(model.strengths), normal.error(normal.fitted)
    return np.asarray(np.divide(beside, without, out=np.ones_like(beside), where=without > 0.0))
