"""What one evaluation of each law costs: states, parameters, memory, counted operations, nanoseconds.

Operations are counted by running the kernel's own source on numbers that count; time is measured in a compiled loop
around one kernel, one joint, along a walk of velocities through rest.
"""

from __future__ import annotations

import math
import sys
import time
import types
from collections import Counter
from dataclasses import dataclass
from typing import Any, ClassVar

import numba
import numpy as np

from mjfriction.laws.ambient import ambient
from mjfriction.laws.catalog import LAWS
from mjfriction.laws.law import Law
from mjfriction.laws.portrait import typical_values

ELEMENTS = 10
STEP = 1e-3
LOOPS = 400_000
REPEATS = 5


class Counting(float):
    """A number that counts the operations done with it."""

    counts: ClassVar[Counter[str]] = Counter()

    @staticmethod
    def of(kind: str, value: Any) -> Any:
        """Note one operation of a kind and return its result."""
        Counting.counts[kind] += 1
        return Counting(value)


def _operator(name: str, kind: str) -> None:
    def operate(self: Counting, *others: Any) -> Any:
        return Counting.of(kind, getattr(float, name)(float(self), *map(float, others)))

    setattr(Counting, name, operate)


for operation, group in {"add": "+", "radd": "+", "sub": "+", "rsub": "+", "mul": "×", "rmul": "×"}.items():
    _operator(f"__{operation}__", group)
for operation, group in {"truediv": "÷", "rtruediv": "÷", "pow": "pow", "rpow": "pow"}.items():
    _operator(f"__{operation}__", group)
_operator("__neg__", "sign")
_operator("__abs__", "sign")


class CountingMath:
    """The functions of ``math`` that kernels use, counted."""

    pi, inf = math.pi, math.inf

    def __getattr__(self, name: str) -> Any:
        kind = name if name in {"exp", "expm1", "atan", "cos", "sin"} else "sign"
        return lambda *values: Counting.of(kind, getattr(math, name)(*map(float, values)))


def plain(law: Law, name: str, **replaced: Any) -> Any:
    """Return a kernel of a law as plain Python, with every kernel it calls; ``replaced`` overrides their globals."""

    def opened(function: Any) -> Any:
        scope = dict(vars(sys.modules[function.__module__]))
        for key in function.__code__.co_names:
            if hasattr(scope.get(key), "py_func"):
                scope[key] = opened(scope[key].py_func)
        return types.FunctionType(function.__code__, {**scope, **replaced}, function.__name__)

    return opened(getattr(law, name).py_func)


def counted(law: Law, packed: np.ndarray, velocities: np.ndarray) -> Counter[str]:
    """Return the operations of one ``advance``, averaged over a walk of velocities."""
    advance = plain(law, "advance", math=CountingMath())
    wrap = np.vectorize(Counting, otypes=[object])
    p = wrap(packed)
    z = np.array([Counting(0.0)] * law.state_count(packed), dtype=object)
    around = wrap(ambient(1, load=3.0)[0])
    Counting.counts = Counter()
    for v in velocities:
        z_next = z.copy()
        advance(Counting(v), around, z, Counting(STEP), p, z_next)
        z = z_next
    return Counter({kind: round(count / velocities.size) for kind, count in Counting.counts.items()})


def nanoseconds(law: Law, packed: np.ndarray, velocities: np.ndarray) -> float:
    """Return the time of one ``advance``, the fastest of several runs."""
    advance = law.advance

    @numba.njit
    def run(loops: int, v: Any, around: Any, p: Any, z: Any, z_next: Any) -> float:
        total = 0.0
        for i in range(loops):
            torque, slope = advance(v[i % v.shape[0]], around, z, STEP, p, z_next)
            total += torque + slope
            for j in range(z.shape[0]):
                z[j] = z_next[j]
        return total

    around = ambient(1, load=3.0)[0]
    z = np.zeros(law.state_count(packed))
    run(10, velocities, around, packed, z, z.copy())
    best = math.inf
    for _ in range(REPEATS):
        start = time.perf_counter()
        run(LOOPS, velocities, around, packed, z, z.copy())
        best = min(best, time.perf_counter() - start)
    return best / LOOPS * 1e9


@dataclass(frozen=True)
class Cost:
    """One row of the table; ``memory`` counts numbers of parameters and states."""

    law: str
    states: int
    parameters: int
    memory: int
    operations: Counter[str]
    nanoseconds: float


def cost(law: Law, exponent: float = 2.0) -> Cost:
    """Measure one law; exponents 1 and 2 of the falling level need no power."""
    values = typical_values(law, ELEMENTS)
    if "stribeck_exponent" in values:
        values["stribeck_exponent"] = exponent
    packed = law.pack(values)
    walk = np.cumsum(np.random.default_rng(0).normal(0.0, 0.02, 1024))
    states = law.state_count(packed)
    operations = counted(law, packed, walk)
    name = f"`{law.name}`" if exponent == 2.0 else f"`{law.name}`, exponent {exponent:g}"
    return Cost(name, states, packed.size, states + packed.size, operations, nanoseconds(law, packed, walk))


def table() -> str:
    """Return the table of all laws in Markdown."""
    kinds = ("+", "×", "÷", "exp", "expm1", "pow", "atan", "cos", "sin")
    lines = [
        f"| law | states | parameters | memory | {' | '.join(kinds)} | ns |",
        f"|---|{'---:|' * (len(kinds) + 4)}",
    ]
    for own in (*map(cost, LAWS.values()), cost(LAWS["lugre"], exponent=1.3)):
        counts = " | ".join(str(own.operations[kind] or "") for kind in kinds)
        lines.append(
            f"| {own.law} | {own.states} | {own.parameters} | {own.memory} | {counts} | {own.nanoseconds:.0f} |"
        )
    return "\n".join(lines)


if __name__ == "__main__":
    print(table())
