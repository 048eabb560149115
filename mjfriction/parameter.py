"""A physical parameter, declared once: checks, documentation and test draws follow from it."""

from __future__ import annotations

import math
from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Parameter:
    """One named physical quantity.

    ``unit`` may contain ``{force}`` and ``{length}``, which become N·m and rad on a revolute joint, N and m on a
    sliding joint.  ``lower`` and ``upper`` are inclusive bounds; ``typical`` is the range seen on real machines, from
    which tests draw.  ``default`` is used where a user gives no value; None means that the parameter is required.
    """

    name: str
    unit: str
    meaning: str
    lower: float = -math.inf
    upper: float = math.inf
    typical: tuple[float, float] = (0.0, 1.0)
    default: float | None = None

    def unit_for(self, *, sliding: bool) -> str:
        """Return the unit for a sliding (N, m) or a revolute (N·m, rad) joint."""
        force, length = ("N", "m") if sliding else ("N·m", "rad")
        return self.unit.format(force=force, length=length)

    def allows(self, value: float) -> bool:
        """Return whether ``value`` is finite and within the bounds."""
        return math.isfinite(value) and self.lower <= value <= self.upper

    @property
    def allowed(self) -> str:
        """The bounds in words, for messages."""
        if math.isinf(self.lower) and math.isinf(self.upper):
            return "any finite number"
        if math.isinf(self.upper):
            return f"at least {self.lower:g}"
        if math.isinf(self.lower):
            return f"at most {self.upper:g}"
        return f"{self.lower:g} to {self.upper:g}"
