"""Requirements that a law puts on several of its parameters together."""

from __future__ import annotations

import itertools
import numbers
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Protocol, cast

Values = Mapping[str, float | Sequence[float]]


class Rule(Protocol):
    """A requirement on the values of a law."""

    def broken(self, values: Values) -> str | None:
        """Return what is wrong and what is allowed, or None where the requirement holds."""
        ...


def scalar(values: Values, name: str) -> float:
    """Return a value as one number; for an array, its first element."""
    value = values[name]
    return float(value) if isinstance(value, numbers.Real) else float(cast(Sequence[float], value)[0])


def array(values: Values, name: str) -> list[float]:
    """Return a value as a list of numbers."""
    value = values[name]
    return [float(value)] if isinstance(value, numbers.Real) else [float(x) for x in cast(Sequence[float], value)]


@dataclass(frozen=True, slots=True)
class Ordering:
    """``larger`` ≥ ``smaller``."""

    larger: str
    smaller: str

    def broken(self, values: Values) -> str | None:
        """Return a message with the two values if they are in the wrong order."""
        larger, smaller = scalar(values, self.larger), scalar(values, self.smaller)
        if larger >= smaller:
            return None
        return (
            f"'{self.larger}' = {larger:g} is smaller than '{self.smaller}' = {smaller:g}; it must be at least as large"
        )


@dataclass(frozen=True, slots=True)
class BreakawayOrder:
    """Elements are sorted by breakaway displacement: ``level`` / ``stiffness`` never falls.

    The order does not affect the torque; it makes the representation unique, so that two fits can be compared.
    """

    level: str
    stiffness: str

    def broken(self, values: Values) -> str | None:
        """Return a message with the first two elements in the wrong order."""
        slack = 1.0 - 1e-9  # equal displacements are allowed, up to rounding
        pairs = zip(array(values, self.level), array(values, self.stiffness), strict=True)
        travel = [level / stiffness for level, stiffness in pairs]
        for i, (first, second) in enumerate(itertools.pairwise(travel)):
            if second < first * slack:
                return (
                    f"element {i + 2} breaks away after {second:g}, before element {i + 1} after {first:g} "
                    f"('{self.level}' / '{self.stiffness}'); sort the elements by that displacement"
                )
        return None


@dataclass(frozen=True, slots=True)
class SumReaches:
    """The sum of the elements' levels is at least ``floor``."""

    level: str
    floor: str

    def broken(self, values: Values) -> str | None:
        """Return a message with the sum if it is too small."""
        total, floor = sum(array(values, self.level)), scalar(values, self.floor)
        if total >= floor * (1.0 - 1e-9):
            return None
        return f"the sum of '{self.level}' is {total:g}, below '{self.floor}' = {floor:g}; it must reach it"


@dataclass(frozen=True, slots=True)
class SumIsOne:
    """The elements' shares add up to one."""

    share: str

    def broken(self, values: Values) -> str | None:
        """Return a message with the sum if it is not one."""
        total = sum(array(values, self.share))
        if abs(total - 1.0) <= 1e-6:
            return None
        return f"the sum of '{self.share}' is {total:g}; it must be 1"
