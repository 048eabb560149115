"""The elements of a law as free numbers of a fit: springs that break away, or waves along the stroke."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

from mjfriction.laws.law import Law
from mjfriction.laws.rules import Values, array, scalar

TRAVEL = (1e-9, 1e3)  # rad or m
LEVEL = (1e-9, 1e9)  # N·m or N
RATIO = (1e-4, 1e4)  # of two levels: an element with a smaller one does not count
WAVENUMBER = (1e-6, 1e9)  # 1/rad or 1/m
LEAST_STIFFNESS = 1e-12  # least stiffness that a law allows
LEAST_WHOLE = 1e-9  # N·m or N, least level that shares are taken of
Bounds = tuple[float, float]


@dataclass(frozen=True)
class Elements(ABC):
    """``count`` elements of a law; their free numbers come after those of the law's single parameters."""

    count: int

    @property
    @abstractmethod
    def names(self) -> tuple[str, ...]:
        """The names of the free numbers; no law's parameter has the same."""

    @property
    @abstractmethod
    def logarithmic(self) -> tuple[bool, ...]:
        """Which of them are logarithms."""

    @property
    @abstractmethod
    def bounds(self) -> tuple[Bounds, ...]:
        """The lowest and the highest value of each."""

    @abstractmethod
    def numbers(self, values: Values) -> list[float]:
        """Return the free numbers for a law's values."""

    @abstractmethod
    def fewer(self, values: Values) -> tuple[Elements, dict[str, float | Sequence[float]]]:
        """Return one element less, leaving out the least needed one, and a law's values without it."""

    @abstractmethod
    def arrays(self, values: Mapping[str, float], numbers: Sequence[float]) -> dict[str, tuple[float, ...]]:
        """Return the elements' parameters for the law's single ``values`` and the free numbers."""


@dataclass(frozen=True)
class Springs(Elements):
    """Springs that each break away after a travel: logarithms of the travels, and of how the level is shared.

    ``whole`` names the parameter that their levels add up to, None where nothing does; ``shares`` says whether the law
    states the levels as shares of it.  With ``whole``, the first level is what the others leave.
    """

    whole: str | None = None
    shares: bool = False

    @property
    def names(self) -> tuple[str, ...]:
        """Travels, then levels; or, with ``whole``, ratios of the levels to the first one."""
        first = 2 if self.whole else 1
        return (
            *(f"travel {i + 1}" for i in range(self.count)),
            *(f"level {i}" for i in range(first, self.count + 1)),
        )

    @property
    def logarithmic(self) -> tuple[bool, ...]:
        """All of them are logarithms."""
        return (True,) * len(self.names)

    @property
    def bounds(self) -> tuple[Bounds, ...]:
        """The bounds of the travels, and of the levels or their ratios."""
        levels = (RATIO,) * (self.count - 1) if self.whole else (LEVEL,) * self.count
        return tuple((math.log(low), math.log(high)) for low, high in (TRAVEL,) * self.count + levels)

    def numbers(self, values: Values) -> list[float]:
        """Return ln uᵢ, then ln Wᵢ; or, with ``whole``, ln Wᵢ/W₁."""
        stiffness = array(values, "stiffness")
        level = array(values, "share" if self.shares else "level")
        size = scalar(values, self.whole) if self.whole and self.shares else 1.0
        travel = [max(size, LEAST_WHOLE) * own / k for own, k in zip(level, stiffness, strict=True)]
        first = level[0] if self.whole else 1.0
        numbers = [*travel, *(own / first for own in level[1 if self.whole else 0 :])]
        return [math.log(max(own, 1e-300)) for own in numbers]

    def fewer(self, values: Values) -> tuple[Elements, dict[str, float | Sequence[float]]]:
        """Return one spring less, and a law's values with the two of nearest travels merged into one."""
        name = "share" if self.shares else "level"
        stiffness, level = array(values, "stiffness"), array(values, name)
        travel = [own / k for own, k in zip(level, stiffness, strict=True)]
        first = min(range(self.count - 1), key=lambda i: travel[i + 1] / travel[i])
        both = slice(first, first + 2)
        for own in (stiffness, level):
            own[both] = [math.fsum(own[both])]
        return replace(self, count=self.count - 1), {**values, "stiffness": tuple(stiffness), name: tuple(level)}

    def arrays(self, values: Mapping[str, float], numbers: Sequence[float]) -> dict[str, tuple[float, ...]]:
        """Return stiffness and level (or share) of each, in the order in which they break away."""
        travel = [math.exp(own) for own in numbers[: self.count]]
        level = [*([1.0] if self.whole else []), *(math.exp(own) for own in numbers[self.count :])]
        if self.whole:
            size = max(values[self.whole], LEAST_WHOLE)
            level = [size * own / math.fsum(level) for own in level]
        pairs = sorted(zip(travel, level, strict=True))
        stiffness = tuple(max(own / reach, LEAST_STIFFNESS) for reach, own in pairs)
        if not self.shares:
            return {"stiffness": stiffness, "level": tuple(own for _, own in pairs)}
        return {"stiffness": stiffness, "share": tuple(own / math.fsum(level) for _, own in pairs)}


@dataclass(frozen=True)
class Waves(Elements):
    """Waves along the stroke: logarithms of the wavenumbers, and the amplitudes of cosines and sines."""

    @property
    def names(self) -> tuple[str, ...]:
        """Wavenumbers, then cosines, then sines."""
        return tuple(f"{name} {i + 1}" for name in ("wavenumber", "cosine", "sine") for i in range(self.count))

    @property
    def logarithmic(self) -> tuple[bool, ...]:
        """The wavenumbers are logarithms."""
        return (True,) * self.count + (False,) * (2 * self.count)

    @property
    def bounds(self) -> tuple[Bounds, ...]:
        """The bounds of the wavenumbers; amplitudes have none."""
        low, high = WAVENUMBER
        return ((math.log(low), math.log(high)),) * self.count + ((-math.inf, math.inf),) * (2 * self.count)

    def numbers(self, values: Values) -> list[float]:
        """Return ln k, a and b of each."""
        return [*(math.log(k) for k in array(values, "wavenumber")), *array(values, "cosine"), *array(values, "sine")]

    def fewer(self, values: Values) -> tuple[Elements, dict[str, float | Sequence[float]]]:
        """Return one wave less, and a law's values without the wave of least amplitude."""
        arrays = {name: array(values, name) for name in ("wavenumber", "cosine", "sine")}
        size = [math.hypot(a, b) for a, b in zip(arrays["cosine"], arrays["sine"], strict=True)]
        least = size.index(min(size))
        kept = {name: tuple(own[:least] + own[least + 1 :]) for name, own in arrays.items()}
        return replace(self, count=self.count - 1), {**values, **kept}

    def arrays(self, values: Mapping[str, float], numbers: Sequence[float]) -> dict[str, tuple[float, ...]]:
        """Return the wavenumber, cosine and sine of each; the single ``values`` have no influence."""
        del values
        n = self.count
        wavenumber = tuple(math.exp(own) for own in numbers[:n])
        return {"wavenumber": wavenumber, "cosine": tuple(numbers[n : 2 * n]), "sine": tuple(numbers[2 * n :])}


def elements_of_law(law: Law, count: int) -> Elements:
    """Return ``count`` elements of a law."""
    if "wavenumber" in [parameter.name for parameter in law.elements]:
        return Waves(count)
    names = [parameter.name for parameter in law.parameters]
    return Springs(count, "static" if "static" in names else None, law.elements[1].name == "share")
