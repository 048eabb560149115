"""A law's statics from a joint's passes forward and backward, where it has them."""

from __future__ import annotations

from mjfriction.errors import LogError
from mjfriction.identify.fit import STATIC_SIBLING, LawFit
from mjfriction.identify.friction_map import FrictionMap
from mjfriction.identify.map_fit import MapFit, arctan_procedure, fit_map, static_names
from mjfriction.laws.arctan import ARCTAN
from mjfriction.laws.catalog import find_law
from mjfriction.laws.law import Law


def statics_from_passes(fit: LawFit, points: FrictionMap) -> MapFit | None:
    """Return the statics of a fit's law by least squares on the passes, None where these cannot tell them.

    What reads more than the speed, or differs between directions, does not show in the directions' difference.
    """
    law = _static(fit)
    if law.reads or not law.odd:
        return None
    try:
        return fit_map(points, law, fit.problem.side, _ratio(fit))
    except LogError:
        return None


def why_not_from_passes(fit: LawFit, points: FrictionMap | None) -> str:
    """Say why a fit's statics are not those of its joint's passes; nothing where it has none."""
    if points is None:
        return ""
    law = _static(fit)
    if law.reads or not law.odd:
        return f"; the passes' differences do not tell {law.name}"
    needed = len(static_names(law)) + 1
    return f"; {points.speed.size} speeds were steady both ways, {law.name} needs {needed}"


def statics_by_slope(fit: LawFit, points: FrictionMap | None) -> MapFit | None:
    """Return law (14) by the manipulator paper's own procedure, None where the fit's statics are another law's."""
    if points is None or _static(fit) is not ARCTAN:
        return None
    try:
        return arctan_procedure(points, fit.problem.side, _ratio(fit))
    except LogError:
        return None


def _static(fit: LawFit) -> Law:
    return find_law(STATIC_SIBLING.get(fit.law.name, fit.law.name))


def _ratio(fit: LawFit) -> float:
    return fit.problem.gap.robot.table.joint[fit.problem.joint].actuator.gear_ratio
