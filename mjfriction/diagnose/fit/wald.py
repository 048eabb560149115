"""Wald's test of strengths against zero."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.stats import f as fisher

from mjfriction.record.log import Floats


@dataclass(frozen=True)
class Wald:
    """``statistic`` is θᵀC⁻¹θ/k of k = ``count`` strengths θ, whose covariance C has ``spare`` degrees of freedom."""

    statistic: float
    count: int
    spare: int

    @property
    def chance(self) -> float:
        """The probability of strengths so far from zero if there is no such effect (F test)."""
        return float(fisher.sf(self.statistic, *self._freedoms))

    def reached(self, chance: float) -> float:
        """Return the factor on these strengths at which they are just beyond a ``chance``."""
        return float(np.sqrt(fisher.isf(chance, *self._freedoms) / max(self.statistic, 1e-300)))

    @property
    def _freedoms(self) -> tuple[int, int]:
        return self.count, max(1, self.spare - self.count + 1)


def wald(strengths: Floats, covariances: Sequence[Floats], count: int, spare: int) -> Wald:
    """Test strengths (k,), ``count`` of which the motion excites, against the least favourable of several covariances
    (k, k), each with ``spare`` degrees of freedom.
    """
    statistics = [strengths @ np.linalg.pinv(own) @ strengths for own in covariances]
    return Wald(float(min(statistics)) / count, count, spare)
