"""A model in the making: the nuisances and the causes chosen so far, held against the rows."""

from __future__ import annotations

import functools
import itertools
from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from mjfriction.diagnose.causes.cause import Cause, Site
from mjfriction.diagnose.nuisance import Nuisance
from mjfriction.identify.gap import Gap
from mjfriction.identify.link_inertias import nearest_physical
from mjfriction.identify.normal import Normal
from mjfriction.identify.regression import UNSEEN, Columns, Rows, System
from mjfriction.identify.row_noise import least_noise, row_noise
from mjfriction.record.log import Floats
from mjfriction.robot.friction import stated_levels, stribeck_excess

SAME = 1e-9  # of one, that the cosine between two columns may fall short by for them to be the same
PRIOR_SHARE = 100.0  # a cause's strength may be worth this many times the joint's effort: next to no restraint
BACKWARD_COULOMB = 0.1  # of a joint's friction that its Coulomb level may seem to be negative by
MOST_TAKEN = 1.25  # of a joint's Coulomb level, that its causes may move into laws of their own
NOISE_ROUNDS, SETTLED = 8, 0.02  # at most, and the relative change of a noise at which they end
UNMOVED = 1e-3  # relative change of a joint's noise below which its rows keep their weight
FRICTIONLESS = 1e-12  # N·m or N: a joint without friction
BACKWARD_VISCOUS = 0.3  # and its damping, which errors of the links' inertias reach too

Key = tuple[str, int, int]  # a cause's name, its joint, and which of its kind it is there


@dataclass(frozen=True)
class Tangent:
    """A curved effect around a point: effort = ``columns`` · strengths + ``bend`` (rows, joints), with the slopes as
    they were at strengths ``drawn_at``.
    """

    columns: Columns
    bend: Floats
    drawn_at: Floats


@dataclass(frozen=True)
class Chosen:
    """A cause at a place, as part of a model; ``tangent`` stands for a curved cause's columns once it is fitted."""

    cause: Cause
    site: Site
    tangent: Tangent | None = None

    @property
    def key(self) -> Key:
        """The cause's name, its joint, and which of its kind it is there."""
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
        """The strengths fitted on everything: the nuisances', then the causes'."""
        return self.system.normal.fitted

    @property
    def known_of_nuisance(self) -> Floats:
        """What is known beforehand of the nuisances' strengths, those drawn tighter that would go too far."""
        return self.system.normal.precision[: self.nuisance.count]

    @property
    def link_changes(self) -> Floats:
        """How far each refitted link is from what is stated: its scale, relative, and its centre, m, (links, 4)."""
        return self.nuisance.link_changes(self.strengths)

    @functools.cached_property
    def built(self) -> Floats:
        """The strengths as they can be built into the robot: where links were let go, the nearest of those that bodies
        can have, and what is fitted beside these.
        """
        return self.built_from()

    def built_from(self, training: NDArray[np.bool_] | None = None) -> Floats:
        """Return the strengths fitted on the blocks marked in ``training`` (blocks,), as :attr:`built` are on all."""
        inertias, place, normal = self.nuisance.inertias, self.nuisance.of_inertias, self.system.normal
        fitted = normal.fitted if training is None else normal.strengths(training)
        if inertias is None or inertias.physical(fitted[place]):
            return fitted
        return nearest_physical(*normal.equations(training), place, inertias.stated)

    @property
    def places(self) -> list[slice]:
        """Where the strengths of each chosen cause stand."""
        ends = [self.nuisance.count]
        for choice in self.chosen:
            ends.append(ends[-1] + len(choice.cause.quantities(self.gap, choice.site)))
        return [slice(a, b) for a, b in itertools.pairwise(ends)]

    @property
    def noteworthy(self) -> tuple[Chosen, ...]:
        """The chosen causes that would be findings; the others are values refitted along."""
        pairs = zip(self.chosen, self.places, strict=True)
        return tuple(one for one, at in pairs if one.cause.noteworthy(self.gap, one.site, self.strengths[at]))

    @functools.cached_property
    def friction(self) -> dict[int, float]:
        """The RMS Coulomb and viscous friction of each examined joint that moves, as stated and refitted, N·m or N."""
        gap, nuisance, strengths = self.gap, self.nuisance, self.strengths
        refitted = {level.site.joint: strengths[nuisance.of_level(level.site.joint)] for level in nuisance.levels}
        out = {}
        for joint in gap.examined:
            levels = np.array(stated_levels(gap.robot.table.joint[joint])) + refitted.get(joint, 0.0)
            course = np.column_stack([gap.at_rows(name)[:, joint] for name in ("forward", "velocity")]) @ levels
            out[joint] = max(gap.rms(course, joint), FRICTIONLESS)
        return out

    def beyond_levels(self, effort: Floats, joint: int) -> Floats:
        """Return what freely refitted levels cannot make of an effort (rows,) at a joint, N·m or N."""
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
        """Return what the model, fitted on everything, leaves: (rows, joints), N·m or N.

        With ``oscillations``, those that are refitted along are left too, since no robot file holds them; with
        ``built``, it is left as it can be built into the robot.
        """
        return self._left(self.built if built else self.strengths, oscillations=oscillations)

    def heldout_residual(self, *, oscillations: bool = False) -> Floats:
        """Return what the model leaves, every row predicted by a fit that has not seen it: (rows, joints).

        ``oscillations`` as in :meth:`residual`.
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

    def with_also(self, choice: Chosen) -> Model:
        """Return the model with one cause more."""
        return build_model(self.gap, self.nuisance, (*self.chosen, choice))

    def without(self, target: Chosen) -> Model:
        """Return the model with one cause taken out."""
        rest = tuple(choice for choice in self.chosen if choice.key != target.key)
        return build_model(self.gap, self.nuisance, rest)

    def without_links(self) -> Model:
        """Return the model with every link as stated."""
        return build_model(self.gap, self.nuisance.without_links(), self.chosen)

    def without_zeros(self) -> Model:
        """Return the model with no effort where there is none."""
        return build_model(self.gap, self.nuisance.without_zeros(), self.chosen)

    def without_drives(self) -> Model:
        """Return the model with every drive as stated."""
        return build_model(self.gap, self.nuisance.without_drives(), self.chosen)

    def admissible(self) -> Model:
        """Return the model without causes that came out as nature does not allow: they explain nothing."""
        for choice, place in zip(self.chosen, self.places, strict=True):
            if not choice.cause.admissible(self.gap, choice.site, self.strengths[place]):
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
        """Return the normal equations with other causes than the model's, rows weighed as they are."""
        return self._normal(self.system.rows, chosen)

    def _normal(self, rows: Rows, chosen: tuple[Chosen, ...]) -> Normal:
        blocks = [cause_block(self.gap, own) for own in chosen]
        columns = [self.nuisance.columns, *(block for block, _ in blocks)]
        return System(rows, columns, [self.known_of_nuisance, *(own for _, own in blocks)]).normal

    def friction_is_physical(self, strengths: Floats, joints: list[int], candidate: Chosen) -> bool:
        """Return whether friction levels fitted with one more cause, its strengths last, work against the motion.

        Where columns are alike, least squares likes to set a large level against its negative; a Coulomb level or a
        damping below zero by more than errors elsewhere can make it is the mark of that.
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
    """Return the joint at which a cause's effort is measured: its own, or, where that has no effort, the one that feels
    it most.
    """
    joint = choice.site.joint
    return joint if joint in columns else max(columns, key=lambda one: float(np.linalg.norm(columns[one])))


def partners(choice: Chosen, others: Iterable[Chosen]) -> list[Chosen]:
    """Return those of other causes whose other half a cause is: it was asked for by name."""
    return [one for one in others if choice.cause.name in one.cause.kin and one.site.joint == choice.site.joint]


def without_contained(chosen: Iterable[Chosen], newcomer: Chosen) -> tuple[Chosen, ...]:
    """Return those of a model's causes that a newcomer does not contain: a spring has the offset told before it."""
    return tuple(
        choice
        for choice in chosen
        if choice.site.joint != newcomer.site.joint or choice.cause.name not in newcomer.cause.contains
    )


def cause_block(gap: Gap, choice: Chosen) -> tuple[Columns, Floats]:
    """Return a cause's columns and the precision that keeps them from blowing up where the data say nothing."""
    straight = _drawn(gap, choice)
    columns = choice.tangent.columns if choice.tangent else straight
    size = _size(columns)
    # What the motion does not show at all, as a moment along an axis that never leaves the vertical, stays at zero:
    # of a tangent there is the error of its difference quotient.
    seen = _size(straight)
    shown = seen > UNSEEN * np.max(seen)
    if not np.all(shown):
        columns = {joint: values * shown for joint, values in columns.items()}
        size = np.where(shown, size, np.max(size))
    effort = np.sqrt(np.mean(np.square(gap.measured[:, seat(choice, columns)])))
    return columns, np.square(size / (PRIOR_SHARE * effort))


def _size(columns: Columns) -> Floats:
    return np.asarray(np.sqrt(sum(np.mean(np.square(values), axis=0) for values in columns.values())))


def _drawn(gap: Gap, choice: Chosen) -> Columns:
    return gap.kept.recall((type(choice.cause), choice.site), lambda: choice.cause.columns(gap, choice.site))


def same_columns(gap: Gap, one: Chosen, other: Chosen) -> bool:
    """Return whether two causes, of one strength each that this motion shows, do the same on it at every joint."""
    a, b = (_shown_columns(gap, choice) for choice in (one, other))
    if a.shape[1] != 1 or b.shape[1] != 1:
        return False
    return bool(abs(a[:, 0] @ b[:, 0]) > (1.0 - SAME) * np.linalg.norm(a) * np.linalg.norm(b))


def _shown_columns(gap: Gap, choice: Chosen) -> Floats:
    # Those columns of a cause that are not zero, all joints beneath one another.
    columns, precision = cause_block(gap, choice)
    none = np.zeros((gap.chain.time.size, precision.size))
    whole = np.concatenate([columns.get(joint, none) for joint in gap.examined])
    return whole[:, np.any(whole != 0.0, axis=0)]


def build_model(gap: Gap, nuisance: Nuisance, chosen: tuple[Chosen, ...]) -> Model:
    """Set up the regression of a model.

    The noise of each joint is measured on what the model itself leaves, where friction's direction is not in doubt, in
    a few rounds; every row then counts by that noise and its doubt.  Links stay within what stated ones are ever off
    by: what takes them farther is a cause of its own.
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
