"""The free numbers in which a law is fitted: logarithms of what must be above zero, excesses of what must be larger."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mjfriction.laws.law import Floats, Law
from mjfriction.laws.rules import Ordering
from mjfriction.parameter import Parameter

LARGEST = 1e15  # of a parameter above zero without an upper bound, SI units: stiffer than anything
STEP = 1e-6  # of a coordinate, for the slope of the values


@dataclass(frozen=True)
class Coordinates:
    """The parameters ``names`` of a law as a vector x; the others stay as in ``fixed``.

    A parameter whose lower bound is above zero stands as its logarithm; one that a rule of the law orders above another
    free one stands as its excess over that.
    """

    law: Law
    names: tuple[str, ...]
    fixed: Mapping[str, float]

    def vector(self, values: Mapping[str, float]) -> Floats:
        """Return the vector of named values."""
        return np.array([self._inward(name, values) for name in self.names])

    def values(self, x: Floats) -> dict[str, float]:
        """Return all values of the law at a vector."""
        out = dict(self.fixed)
        # What others are measured from comes first.
        pending = dict(zip(self.names, x, strict=True))
        while pending:
            name = next(name for name in pending if self._base(name) not in pending)
            own, base = float(pending.pop(name)), self._base(name)
            out[name] = math.exp(own) if self._logarithmic(name) else own + (out[base] if base else 0.0)
        return out

    def bounds(self) -> tuple[Floats, Floats]:
        """Return the lowest and the highest vector."""
        low, high = [], []
        for name in self.names:
            declared = self._declared(name)
            if self._logarithmic(name):
                low.append(math.log(declared.lower))
                high.append(math.log(min(declared.upper, LARGEST)))
            else:
                low.append(0.0 if self._base(name) else declared.lower)
                high.append(declared.upper)
        return np.array(low), np.array(high)

    @property
    def logarithmic(self) -> NDArray[np.bool_]:
        """Which coordinates are logarithms, (names,)."""
        return np.array([self._logarithmic(name) for name in self.names])

    def slopes(self, x: Floats) -> Floats:
        """Return ∂value/∂x of the free values, (names, names)."""
        out = np.empty((x.size, x.size))
        for k in range(x.size):
            step = np.zeros(x.size)
            step[k] = STEP * max(1.0, abs(float(x[k])))
            ends = [self.values(x + step), self.values(x - step)]
            out[:, k] = [(ends[0][name] - ends[1][name]) / (2.0 * step[k]) for name in self.names]
        return out

    def _declared(self, name: str) -> Parameter:
        return self.law.parameter(name)

    def _logarithmic(self, name: str) -> bool:
        return self._declared(name).lower > 0.0

    def _base(self, name: str) -> str | None:
        rules = [rule for rule in self.law.rules if isinstance(rule, Ordering)]
        return next((rule.smaller for rule in rules if rule.larger == name), None)

    def _inward(self, name: str, values: Mapping[str, float]) -> float:
        base = self._base(name)
        if self._logarithmic(name):
            return math.log(values[name])
        return values[name] - (values[base] if base else 0.0)
