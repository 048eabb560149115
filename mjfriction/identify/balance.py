"""What acts beside friction, fitted over all joints at once, with every joint's friction as free as it can be."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from mjfriction.identify.background import Background
from mjfriction.identify.beside import Beside, beside_of
from mjfriction.identify.fit import LawFit
from mjfriction.identify.gap import Gap
from mjfriction.identify.link_inertias import LinkInertias, nearest_physical
from mjfriction.identify.regression import Columns, Rows, System
from mjfriction.record.log import Floats
from mjfriction.robot.rubbing import forward_share

SPREADS = (0.05, 0.2, 1.0)  # values tried for how far off links usually are: as shares of a mass, for example
RESTING = 1e-3  # factor on the weight of rows that are in doubt about friction, where links and offsets are fitted


@dataclass(frozen=True)
class Friction:
    """A joint's friction while the rest is fitted.

    ``rows`` (rows,) is its current value, and ``columns`` (rows, k) is how it may still change, each with a
    ``precision`` (k,).  Without columns it stays as it is.
    """

    rows: Floats
    columns: Floats
    precision: Floats


@dataclass(frozen=True)
class Balance:
    """A fit: the ``strengths`` (p,) of a ``system``, the first ``shared`` of which belong to the background's
    ``parts``.
    """

    parts: tuple[Background, ...]
    system: System
    strengths: Floats
    shared: int

    @property
    def changes(self) -> list[Floats]:
        """The strengths of each part."""
        ends = np.cumsum([part.precision.size for part in self.parts])
        return np.split(self.strengths, ends)[: len(self.parts)]

    def left(self) -> Floats:
        """Return the residual of every row, (rows, joints)."""
        return self.system.residual(self.strengths)

    def effort(self, joint: int) -> Floats:
        """Return the background's effort at a joint, (rows,)."""
        pairs = zip(self.parts, self.changes, strict=True)
        parts = [part.columns[joint] @ own for part, own in pairs if joint in part.columns]
        return np.asarray(sum(parts, start=np.zeros(self.system.rows.block.size)))

    def beside(self, joint: int) -> Beside:
        """Return what is unknown at a joint beside its friction, relative to this fit."""
        return beside_of(self.system, joint, self.shared, self.strengths)


def first_friction(gap: Gap, joint: int) -> Friction:
    """Return a joint's friction before any law is known: a level and a damping, both free."""
    columns = np.column_stack([forward_share(gap.motion, joint), gap.motion.velocity[:, joint]])
    rows = gap.reported(joint, columns)
    return Friction(np.zeros(rows.shape[0]), rows, np.zeros(2))


def fitted_friction(fit: LawFit, *, free: bool) -> Friction:
    """Return a fitted law's friction; its coordinates may still change where it is ``free``."""
    rows = fit.problem.rows(fit.term)
    if not free:
        return Friction(rows, np.empty((rows.size, 0)), np.empty(0))
    return Friction(rows, fit.slopes, fit.precision)


def balance(
    gap: Gap, parts: Sequence[Background], friction: Mapping[int, Friction], deviation: Mapping[int, Floats]
) -> Balance:
    """Fit the background beside every joint's friction, each row with its joint's standard ``deviation`` (rows,).

    Links stay physical.
    """
    system = _system(gap, parts, friction, deviation)
    normal = system.normal
    strengths = normal.fitted
    ends = np.cumsum([0, *(part.precision.size for part in parts)]).tolist()
    for part, start in zip(parts, ends, strict=False):
        place = slice(start, start + part.precision.size)
        if isinstance(part, LinkInertias) and not part.physical(strengths[place]):
            strengths = nearest_physical(*normal.equations(), place, part.stated)
    return Balance(tuple(parts), system, strengths, ends[-1])


def as_far_off(
    links: LinkInertias,
    gap: Gap,
    parts: Sequence[Background],
    friction: Mapping[int, Friction],
    deviation: Mapping[int, Floats],
) -> LinkInertias:
    """Return the links with the prior spread about the stated values that has the lowest held-out error."""
    normal = _system(gap, [links, *parts], friction, deviation).normal
    errors = []
    for spread in SPREADS:
        tried = replace(links, spread=spread)
        precision = normal.precision.copy()
        precision[: tried.precision.size] = tried.precision
        errors.append(float(np.sum(replace(normal, precision=precision).heldout_errors(gap.blocks.folds))))
    return replace(links, spread=SPREADS[int(np.argmin(errors))])


def _system(
    gap: Gap, parts: Sequence[Background], friction: Mapping[int, Friction], deviation: Mapping[int, Floats]
) -> System:
    target = np.nan_to_num(gap.residual)
    weight = np.zeros_like(target)
    blocks: list[Columns] = [part.columns for part in parts]
    precisions = [part.precision for part in parts]
    for joint, own in friction.items():
        target[:, joint] -= own.rows
        # A joint at rest may hold any friction within its level, for as long as it likes.  In passes of one joint after
        # another that is true of most rows, and all err to one side.
        weight[:, joint] = np.where(gap.clear[:, joint], 1.0, RESTING) / deviation[joint]
        blocks.append({joint: own.columns})
        precisions.append(own.precision)
    return System(Rows(target, weight, gap.blocks.row), blocks, precisions)
