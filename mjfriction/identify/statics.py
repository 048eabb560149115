"""A law's static parameters from a joint's passes forward and backward, where it has them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

from mjfriction.errors import LogError
from mjfriction.identify.fit import STATIC_SIBLING, LawFit
from mjfriction.identify.friction_map import FrictionMap
from mjfriction.identify.map_choice import choose_on_map
from mjfriction.identify.map_fit import MapFit, arctan_procedure, fit_map, static_names
from mjfriction.identify.pendulum import ByPendulum
from mjfriction.identify.problem import Side
from mjfriction.laws.arctan import ARCTAN
from mjfriction.laws.catalog import find_law
from mjfriction.laws.law import Law

TOLD_BY_LOADS = ("load_dependent", "arctan_load")
"""Laws that passes tell where they were made at several loads; of driving and being driven they tell the mean only."""


@dataclass(frozen=True)
class Passes:
    """A joint's passes and what was derived from them.

    ``points`` and ``pendulum`` are None where the log has no passes; ``lacking`` then says what it would need.
    """

    points: FrictionMap | None
    pendulum: ByPendulum | None = None
    lacking: str = ""
    _found: dict[str, MapFit | None] = field(default_factory=dict)

    def statics(self, fit: LawFit) -> MapFit | None:
        """Return the static parameters of a fit's law by least squares on the passes, None where they cannot be
        determined.

        A law that reads more than the speed, or differs between directions, does not show in the directions'
        difference.
        """
        law = _static(fit)
        if self.points is None or not self._shows(law):
            return None
        if law.name not in self._found:
            try:
                self._found[law.name] = fit_map(self.points, law, fit.problem.side, _ratio(fit))
            except LogError:
                self._found[law.name] = None
        return self._found[law.name]

    def chosen(self, names: Sequence[str], side: Side, gear_ratio: float) -> str | None:
        """Return the law that the passes need, of those named that they can determine; None where they cannot say."""
        laws = [law for law in map(find_law, names) if self.tells(law)]
        if self.points is None or not laws:
            return None
        try:
            return choose_on_map(self.points, laws, side, gear_ratio)[0].law.name
        except LogError:
            return None

    def tells(self, law: Law) -> bool:
        """Return whether the difference of passes forward and backward determines a law completely."""
        return self._shows(law) and not law.has_state

    def why_none(self, fit: LawFit) -> str:
        """Say why a fit's static parameters do not come from the passes; empty where none were intended."""
        if self.points is None:
            return f"; {self.lacking}" if self.lacking else ""
        law = _static(fit)
        if not self._shows(law):
            return f"; the passes' differences do not tell {law.name}"
        needed = len(static_names(law)) + 1
        return f"; {self.points.speed.size} speeds were steady both ways, {law.name} needs {needed}"

    def _shows(self, law: Law) -> bool:
        loaded = self.points is not None and self.points.tells_load and law.name in TOLD_BY_LOADS
        return (not law.reads or loaded) and law.odd

    def by_slope(self, fit: LawFit) -> MapFit | None:
        """Return law (14) by the manipulator paper's own procedure, None where the fit's static part is another law."""
        if self.points is None or _static(fit) is not ARCTAN:
            return None
        try:
            return arctan_procedure(self.points, fit.problem.side, _ratio(fit))
        except LogError:
            return None


def _static(fit: LawFit) -> Law:
    return find_law(STATIC_SIBLING.get(fit.law.name, fit.law.name))


def _ratio(fit: LawFit) -> float:
    return fit.problem.gap.robot.table.joint[fit.problem.joint].actuator.gear_ratio
