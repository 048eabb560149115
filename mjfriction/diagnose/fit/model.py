"""A model under construction: the nuisances and the causes chosen so far, fitted to the rows."""

from __future__ import annotations

import functools
import itertools
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from mjfriction.diagnose.causes.cause import Cause, Site
from mjfriction.diagnose.fit.nuisance import Nuisance
from mjfriction.identify.gap import Gap
from mjfriction.identify.link_inertias import nearest_physical
from mjfriction.identify.normal import Normal
from mjfriction.identify.regression import UNSEEN, Columns, Rows, System
from mjfriction.identify.row_noise import least_noise, row_noise
from mjfriction.record.log import Floats
from mjfriction.robot.friction import stated_levels, stribeck_excess

SAME = 1e-9  # two columns are the same if the cosine between them falls short of one by less than this
BACKWARD_COULOMB = 0.1  # share of a joint's friction by which its fitted Coulomb level may be negative
MOST_TAKEN = 1.25  # share of a joint's Coulomb level that its causes may move into laws of their own
NOISE_ROUNDS, SETTLED = 8, 0.02  # most rounds of estimating the noise, and its relative change at which they end
UNMOVED = 1e-3  # relative change of a joint's noise below which its rows keep their weight
FRICTIONLESS = 1e-12  # N·m or N: stands for the friction of a joint that has none
BACKWARD_VISCOUS = 0.3  # the same as BACKWARD_COULOMB for its damping, which errors of the links' inertias affect too

Key = tuple[str, int, int]  # a cause's name, its joint, and its number among those of its kind there


@dataclass(frozen=True)
class Tangent:
    """A curved effect linearised around a point: effort = ``columns`` · strengths + ``bend`` (rows, joints), with the
    slopes at the strengths ``drawn_at``.
    """

    columns: Columns
    bend: Floats
    drawn_at: Floats


@dataclass(frozen=True)
class Chosen:
    """A cause at a site, as part of a model.

    ``tangent`` replaces a curved cause's columns once it has been fitted.  ``instead`` are the causes whose place it
    took, if they leave clearly less than it does.
    """

    cause: Cause
    site: Site
    tangent: Tangent | None = None
    instead: tuple[Chosen, ...] = ()

    @property
    def key(self) -> Key:
        """The cause's name, its joint, and its number among those of its kind there."""
        return self.cause.name, self.site.joint, self.cause.first_order + self.site.order


@dataclass(frozen=True)
class Model:
    """Nuisances and chosen causes, set up as a regression on a gap."""

    gap: Gap
    nuisance: Nuisance
    chosen: tuple[Chosen, ...]
    system: System

    @property
    def strengths(self) -> Floats:
        """The strengths fitted on all rows: the nuisances', then the causes'."""
        return self.system.normal.fitted

    @property
    def known_of_nuisance(self) -> Floats:
        """The prior precision of the nuisances' strengths, tightened for those that would otherwise go too far."""
        return self.system.normal.precision[: self.nuisance.count]

    @property
    def link_changes(self) -> Floats:
        """The change of each refitted link from what is stated: of its scale, relative, and centre, m, (links, 4)."""
        return self.nuisance.link_changes(self.strengths)

    @functools.cached_property
    def built(self) -> Floats:
        """The strengths as they can be built into the robot: where links were let go, the nearest ones that a real body
        can have, and everything else refitted beside them.
        """
        return self.built_from()

    def built_from(self, training: NDArray[np.bool_] | None = None) -> Floats:
        """Return the strengths as :attr:`built`, but fitted on the blocks marked in ``training`` (blocks,) only."""
        inertias, place, normal = self.nuisance.inertias, self.nuisance.of_inertias, self.system.normal
        fitted = normal.fitted if training is None else normal.strengths(training)
        if inertias is None or inertias.physical(fitted[place]):
            return fitted
        return nearest_physical(*normal.equations(training), place, inertias.stated)

    @property
    def places(self) -> list[slice]:
        """The slice of the strengths that belongs to each chosen cause."""
        ends = [self.nuisance.count]
        for choice in self.chosen:
            ends.append(ends[-1] + len(choice.cause.quantities(self.gap, choice.site)))
        return [slice(a, b) for a, b in itertools.pairwise(ends)]

    @functools.cached_property
    def fitted_causes(self) -> tuple[tuple[Chosen, Floats], ...]:
        """Each chosen cause with its fitted strengths."""
        return tuple((choice, self.strengths[place]) for choice, place in zip(self.chosen, self.places, strict=True))

    def strengths_of(self, target: Chosen) -> Floats:
        """Return the fitted strengths of a chosen cause.

        Raises :class:`KeyError` if it is none of the model's.
        """
        return {choice.key: strengths for choice, strengths in self.fitted_causes}[target.key]

    @property
    def noteworthy(self) -> tuple[Chosen, ...]:
        """The chosen causes that would be findings; the others are only refitted along."""
        return tuple(
            choice
            for choice, strengths in self.fitted_causes
            if choice.cause.noteworthy(self.gap, choice.site, strengths)
        )

    @functools.cached_property
    def friction(self) -> dict[int, float]:
        """The RMS Coulomb and viscous friction of each examined joint, stated plus refitted change, N·m or N."""
        gap, nuisance, strengths = self.gap, self.nuisance, self.strengths
        refitted = {level.site.joint: strengths[nuisance.of_level(level.site.joint)] for level in nuisance.levels}
        out = {}
        for joint in gap.examined:
            levels = np.array(stated_levels(gap.robot.table.joint[joint])) + refitted.get(joint, 0.0)
            course = np.column_stack([gap.at_rows(name)[:, joint] for name in ("forward", "velocity")]) @ levels
            out[joint] = max(gap.rms(course, joint), FRICTIONLESS)
        return out

    def beyond_levels(self, effort: Floats, joint: int) -> Floats:
        """Return the part of an effort (rows,) at a joint that freely refitted levels cannot reproduce, N·m or N."""
        for level in self.nuisance.levels:
            if level.site.joint == joint and not level.near:
                columns = level.columns[joint]
                effort = effort - columns @ np.linalg.lstsq(columns, effort, rcond=None)[0]
        return effort

    @functools.cached_property
    def heldout_errors(self) -> Floats:
        """The weighted squared error (joints, blocks), each block predicted by a fit that has not seen it."""
        return self.system.normal.heldout_errors(self.gap.blocks.folds)

    def residual(self, *, oscillations: bool = False, built: bool = False) -> Floats:
        """Return the residual of the model fitted on all rows: (rows, joints), N·m or N.

        With ``oscillations``, refitted oscillations stay in the residual, since no robot file holds them.  With
        ``built``, the strengths are those that can be built into the robot.
        """
        return self._left(self.built if built else self.strengths, oscillations=oscillations)

    def heldout_residual(self, *, oscillations: bool = False) -> Floats:
        """Return the held-out residual, every row predicted by a fit that has not seen it: (rows, joints).

        ``oscillations`` is as in :meth:`residual`.
        """
        out = np.zeros_like(self.gap.residual)
        for fold in self.gap.blocks.folds:
            rows = fold[self.gap.blocks.row]
            out[rows] = self._left(self.system.normal.strengths(~fold), oscillations=oscillations)[rows]
        return out

    def _left(self, strengths: Floats, *, oscillations: bool) -> Floats:
        if oscillations:
            strengths = strengths.copy()
            strengths[self.nuisance.of_oscillations] = 0.0
        return self.system.residual(strengths)

    def made_by(self, places: Sequence[slice]) -> Floats:
        """Return what the strengths at some places make of the effort, the rest being as it is, (rows, joints)."""
        none = self.strengths.copy()
        for place in places:
            none[place] = 0.0
        made = self._left(none, oscillations=False) - self.residual()
        for choice, place in zip(self.chosen, self.places, strict=True):
            if choice.tangent and place in places:
                made = made + choice.tangent.bend
        return made

    def with_also(self, choice: Chosen) -> Model:
        """Return the model with one more cause."""
        return build_model(self.gap, self.nuisance, (*self.chosen, choice))

    def without(self, target: Chosen) -> Model:
        """Return the model without one of its causes."""
        rest = tuple(choice for choice in self.chosen if choice.key != target.key)
        return build_model(self.gap, self.nuisance, rest)

    def without_links(self) -> Model:
        """Return the model with every link as stated."""
        return build_model(self.gap, self.nuisance.without_links(), self.chosen)

    def without_zeros(self) -> Model:
        """Return the model with no zero refitted: efforts read zero where there is none."""
        return build_model(self.gap, self.nuisance.without_zeros(), self.chosen)

    def without_drives(self) -> Model:
        """Return the model with every drive as stated."""
        return build_model(self.gap, self.nuisance.without_drives(), self.chosen)

    def admissible(self) -> Model:
        """Return the model without the causes whose fitted strengths are not physical: these explain nothing."""
        for choice, strengths in self.fitted_causes:
            if not choice.cause.admissible(self.gap, choice.site, strengths):
                return self.without(choice).admissible()
        return self

    def with_candidate(self, choice: Chosen) -> Normal:
        """Return the normal equations with one more cause, its strengths last."""
        columns, precision = cause_block(self.gap, choice)
        if choice.tangent is None:
            return self.system.extended(columns, precision)
        rows = replace(self.system.rows, target=self.system.rows.target - choice.tangent.bend)
        return self._normal(rows, (*self.chosen, choice))

    def with_others(self, chosen: tuple[Chosen, ...]) -> Normal:
        """Return the normal equations with other causes in place of the model's, and the same row weights."""
        return self._normal(self.system.rows, chosen)

    def _normal(self, rows: Rows, chosen: tuple[Chosen, ...]) -> Normal:
        blocks = [cause_block(self.gap, own) for own in chosen]
        columns = [self.nuisance.columns, *(block for block, _ in blocks)]
        return System(rows, columns, [self.known_of_nuisance, *(own for _, own in blocks)]).normal

    def friction_is_physical(self, strengths: Floats, joints: list[int], candidate: Chosen) -> bool:
        """Return whether the friction levels of some joints, fitted with one more cause, work against the motion.

        ``strengths`` end with those of the ``candidate``.  Where columns are alike, least squares tends to balance a
        large level against its negative.  The sign of that is a Coulomb level or damping further below zero than errors
        elsewhere can make it, or causes that take more of the level than there is.
        """
        taken, brought = dict.fromkeys(joints, 0.0), dict.fromkeys(joints, 0.0)
        first = self.places[-1].stop if self.places else self.nuisance.count
        for choice, place in zip((*self.chosen, candidate), (*self.places, slice(first, None)), strict=True):
            if choice.site.joint in taken:
                taken[choice.site.joint] += choice.cause.taken_level(strengths[place])
                brought[choice.site.joint] += choice.cause.brought_level(strengths[place])
        for level in self.nuisance.levels:
            joint = level.site.joint
            if joint not in joints:
                continue
            table = self.gap.robot.table.joint[joint]
            stated = stated_levels(table)
            speed = float(np.sqrt(np.mean(np.square(self.gap.motion.velocity[:, joint]))))
            level_change, damping_change = strengths[self.nuisance.of_level(joint)]
            coulomb = stated[0] + float(level_change)
            if taken[joint] > MOST_TAKEN * max(coulomb + stribeck_excess(table) + brought[joint], 0.0):
                return False
            damping = (stated[1] + float(damping_change)) * speed
            scale = abs(coulomb) + abs(damping)
            if coulomb < -BACKWARD_COULOMB * scale or damping < -BACKWARD_VISCOUS * scale:
                return False
        return True


def seat(choice: Chosen, columns: Columns) -> int:
    """Return the joint at which a cause's effort is measured: its own, or, if that has no column, the one that feels it
    most.
    """
    joint = choice.site.joint
    return joint if joint in columns else max(columns, key=lambda one: float(np.linalg.norm(columns[one])))


def partners(choice: Chosen, others: Iterable[Chosen]) -> list[Chosen]:
    """Return those of the other causes that ask for this one by name, as their other half on the same joint."""
    return [one for one in others if choice.cause.name in one.cause.kin and one.site.joint == choice.site.joint]


def without_contained(chosen: Iterable[Chosen], newcomer: Chosen) -> tuple[Chosen, ...]:
    """Return those of a model's causes that a newcomer does not contain.

    A spring, for instance, contains the offset that was found before it.
    """
    return tuple(
        choice
        for choice in chosen
        if choice.site.joint != newcomer.site.joint or choice.cause.name not in newcomer.cause.contains
    )


def cause_block(gap: Gap, choice: Chosen) -> tuple[Columns, Floats]:
    """Return a cause's columns, and the prior precision that keeps strengths small where the data say nothing."""
    straight = _drawn(gap, choice)
    columns = choice.tangent.columns if choice.tangent else straight
    size = _size(columns)
    # What the motion does not show at all, such as a moment along an axis that never leaves the vertical, stays at
    # zero.  A tangent's column holds nothing there but the error of its difference quotient.
    seen = _size(straight)
    shown = seen > UNSEEN * np.max(seen)
    if not np.all(shown):
        columns = {joint: values * shown for joint, values in columns.items()}
        size = np.where(shown, size, np.max(size))
    effort = np.sqrt(np.mean(np.square(gap.measured[:, seat(choice, columns)])))
    return columns, np.square(size / (effort * choice.cause.spreads()))


def _size(columns: Columns) -> Floats:
    return np.asarray(np.sqrt(sum(np.mean(np.square(values), axis=0) for values in columns.values())))


def _drawn(gap: Gap, choice: Chosen) -> Columns:
    return gap.kept.recall((type(choice.cause), choice.site), lambda: choice.cause.columns(gap, choice.site))


def same_columns(gap: Gap, one: Chosen, other: Chosen) -> bool:
    """Return whether two causes have the same effect on this motion at every joint, up to scale.

    Only causes of which the motion shows exactly one strength each are compared; others are not the same.
    """
    a, b = (_shown_columns(gap, choice) for choice in (one, other))
    if a.shape[1] != 1 or b.shape[1] != 1:
        return False
    return bool(abs(a[:, 0] @ b[:, 0]) > (1.0 - SAME) * np.linalg.norm(a) * np.linalg.norm(b))


def _shown_columns(gap: Gap, choice: Chosen) -> Floats:
    # The nonzero columns of a cause, with the rows of all examined joints stacked.
    columns, precision = cause_block(gap, choice)
    none = np.zeros((gap.chain.time.size, precision.size))
    whole = np.concatenate([columns.get(joint, none) for joint in gap.examined])
    return whole[:, np.any(whole != 0.0, axis=0)]


def build_model(gap: Gap, nuisance: Nuisance, chosen: tuple[Chosen, ...]) -> Model:
    """Set up the regression of a model.

    The noise of each joint is estimated in a few rounds from the model's own residual, on rows where the direction of
    friction is not in doubt.  Each row is then weighted by that noise and its own doubt.  Zeros, drives and links stay
    within the range that stated ones are ever off by: what moves them farther is a cause of its own.
    """
    blocks = [cause_block(gap, choice) for choice in chosen]
    columns = [nuisance.columns, *(block for block, _ in blocks)]
    precisions = [nuisance.precision, *(precision for _, precision in blocks)]
    target = np.nan_to_num(gap.residual) - sum(choice.tangent.bend for choice in chosen if choice.tangent)
    noise = least_noise(gap)
    for joint in gap.examined:
        noise[joint] = max(noise[joint], gap.rms(gap.residual[:, joint], joint))
    system = System(_weighted_rows(gap, target, noise), columns, precisions)
    for _ in range(NOISE_ROUNDS):
        left = Model(gap, nuisance, chosen, system).residual()
        found = {joint: row_noise(gap, joint, left[:, joint], float(noise[joint])) for joint in gap.examined}
        changes = {joint: abs(now / noise[joint] - 1.0) for joint, now in found.items()}
        moved = [joint for joint, change in changes.items() if change > UNMOVED]
        for joint in moved:
            noise[joint] = found[joint]
        system = system.reweighted(_weighted_rows(gap, target, noise).weight, moved)
        if max(changes.values(), default=0.0) <= SETTLED:
            break
    return Model(gap, nuisance, chosen, system.kept_within(nuisance.of_bounded, nuisance.reach))


def _weighted_rows(gap: Gap, target: Floats, noise: Floats) -> Rows:
    measured = np.isfinite(gap.residual)
    deviation = np.sqrt(np.square(noise) + np.square(np.nan_to_num(gap.doubt)))
    weight = np.divide(1.0, deviation, out=np.zeros_like(deviation), where=measured & (deviation > 0.0))
    return Rows(target, weight, gap.blocks.row)
