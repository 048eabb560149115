"""The coordinates in which a law is fitted: logarithms of positive parameters, and excesses over smaller ones."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mjfriction.identify.elements import Elements
from mjfriction.laws.law import Floats, Law
from mjfriction.laws.rules import Ordering, Values, scalar
from mjfriction.parameter import Parameter

LARGEST = 1e15  # SI units, of a positive parameter without an upper bound: stiffer than anything real
STEP = 1e-6  # step for the slopes of the values, as a share of a coordinate


@dataclass(frozen=True)
class Coordinates:
    """The parameters ``single`` of a law, and its ``elements``, as a vector x; the others stay as in ``fixed``.

    A parameter whose lower bound is above zero is represented by its logarithm.  One that a rule of the law requires to
    exceed another is represented by its excess over that.
    """

    law: Law
    single: tuple[str, ...]
    fixed: Mapping[str, float]
    elements: Elements | None = None

    @property
    def names(self) -> tuple[str, ...]:
        """The name of each entry of the vector."""
        return (*self.single, *(self.elements.names if self.elements else ()))

    def vector(self, values: Values) -> Floats:
        """Return the vector for named values."""
        beside = self.elements.numbers(values) if self.elements else []
        return np.array([*(self._inward(name, values) for name in self.single), *beside])

    def values(self, x: Floats) -> dict[str, float | Sequence[float]]:
        """Return all values of the law for a vector."""
        out = self._single(x)
        arrays = self.elements.arrays(out, x[len(self.single) :].tolist()) if self.elements else {}
        return {**out, **arrays}

    def told(self, x: Floats) -> dict[str, float]:
        """Return the free values as reported, one number each; an element's has its number, as in ``level[2]``."""
        values = self.values(x)
        out = {name: scalar(values, name) for name in self.single}
        for declared in self.law.elements if self.elements else ():
            own = values[declared.name]
            assert isinstance(own, Sequence)
            out |= {f"{declared.name}[{i + 1}]": value for i, value in enumerate(own)}
        return out

    def _single(self, x: Floats) -> dict[str, float]:
        out = dict(self.fixed)
        # Take the parameters first from which others are measured.
        pending = dict(zip(self.single, x.tolist(), strict=False))
        while pending:
            name = next(name for name in pending if self._base(name) not in pending)
            own, base = float(pending.pop(name)), self._base(name)
            out[name] = math.exp(own) if self._logarithmic(name) else own + (out[base] if base else 0.0)
        return out

    def bounds(self) -> tuple[Floats, Floats]:
        """Return the lower and the upper bounds of the vector."""
        low, high = [], []
        for name in self.single:
            declared = self._declared(name)
            if self._logarithmic(name):
                low.append(math.log(declared.lower))
                high.append(math.log(min(declared.upper, LARGEST)))
            else:
                low.append(0.0 if self._base(name) else declared.lower)
                high.append(declared.upper)
        for lowest, highest in self.elements.bounds if self.elements else ():
            low.append(lowest)
            high.append(highest)
        return np.array(low), np.array(high)

    @property
    def logarithmic(self) -> NDArray[np.bool_]:
        """Which coordinates are logarithms, (names,)."""
        return np.array(
            [*(self._logarithmic(name) for name in self.single), *(self.elements.logarithmic if self.elements else ())]
        )

    def slopes(self, x: Floats) -> Floats:
        """Return ∂value/∂x of the values that :meth:`told` returns, (told, names)."""
        out = np.empty((len(self.told(x)), x.size))
        for k in range(x.size):
            step = np.zeros(x.size)
            step[k] = STEP * max(1.0, abs(float(x[k])))
            ends = [np.array(list(self.told(at).values())) for at in (x + step, x - step)]
            out[:, k] = (ends[0] - ends[1]) / (2.0 * step[k])
        return out

    def _declared(self, name: str) -> Parameter:
        return self.law.parameter(name)

    def _logarithmic(self, name: str) -> bool:
        return self._declared(name).lower > 0.0

    def _base(self, name: str) -> str | None:
        rules = [rule for rule in self.law.rules if isinstance(rule, Ordering)]
        return next((rule.smaller for rule in rules if rule.larger == name), None)

    def _inward(self, name: str, values: Values) -> float:
        base, own = self._base(name), scalar(values, name)
        return math.log(own) if self._logarithmic(name) else own - (scalar(values, base) if base else 0.0)
