"""Values of a law drawn from its declared typical ranges, in keeping with its rules."""

from __future__ import annotations

import numpy as np

from mjfriction.laws.law import Law
from mjfriction.laws.rules import BreakawayOrder, Ordering, SumIsOne, SumReaches

Named = dict[str, float | list[float]]


def named(law: Law, seed: int, elements: int = 4) -> Named:
    rng = np.random.default_rng(seed)
    values: Named = {p.name: float(rng.uniform(*p.typical)) for p in law.parameters}
    arrays = {p.name: rng.uniform(*p.typical, elements) for p in law.elements}
    for rule in law.rules:
        if isinstance(rule, Ordering):
            values[rule.larger] = max(values[rule.larger], values[rule.smaller])
        if isinstance(rule, SumIsOne):
            arrays[rule.share] /= arrays[rule.share].sum()
        if isinstance(rule, SumReaches):
            arrays[rule.level] *= max(1.0, 1.001 * values[rule.floor] / arrays[rule.level].sum())
    for rule in law.rules:
        if isinstance(rule, BreakawayOrder):
            order = np.argsort(arrays[rule.level] / arrays[rule.stiffness])
            arrays = {name: own[order] for name, own in arrays.items()}
    return values | {name: own.tolist() for name, own in arrays.items()}


def draw(law: Law, seed: int, elements: int = 4) -> np.ndarray:
    return law.pack(named(law, seed, elements))
