"""The velocity at the end of a step for joints with stiff friction: dense algebra for a few joints, compiled."""

from __future__ import annotations

from mjfriction.laws.law import Floats, kernel

TINY = 1e-12


@kernel
def eliminate(a: Floats, f: Floats, first: int) -> None:
    """Eliminate the first ``first`` unknowns of the symmetric system a·x = f in place (LDLᵀ, lower triangle kept).

    What is left in the last rows of ``a`` (its lower triangle) and ``f`` is the system of the other unknowns alone.
    """
    n = f.shape[0]
    for i in range(first):
        for j in range(i + 1, n):
            factor = a[j, i] / a[i, i]
            if factor != 0.0:
                for c in range(i + 1, j + 1):
                    a[j, c] -= factor * a[c, i]
                f[j] -= factor * f[i]


@kernel
def restore(a: Floats, f: Floats, x: Floats, first: int) -> None:
    """Find the eliminated unknowns once the others in ``x`` (n,) are known."""
    for i in range(first - 1, -1, -1):
        value = f[i]
        for j in range(i + 1, x.shape[0]):
            value -= a[j, i] * x[j]
        x[i] = value / a[i, i]


@kernel
def solve_spd(a: Floats, x: Floats) -> None:
    """Solve a·y = x for a symmetric positive definite ``a`` (k, k; its lower triangle), overwriting both.

    A pivot that is not positive is replaced by a tiny one: the step is then long, and the caller checks the result.
    """
    k = x.shape[0]
    for i in range(k):
        for j in range(i):
            entry = a[i, j]
            for c in range(j):
                entry -= a[i, c] * a[j, c]
            a[i, j] = entry
        pivot, value = a[i, i], x[i]
        for j in range(i):
            factor = a[i, j] * a[j, j]
            pivot -= factor * a[i, j]
            value -= factor * x[j]
            a[i, j] = factor
        a[i, i], x[i] = 1.0 / max(pivot, TINY), value
    for i in range(k):
        x[i] *= a[i, i]
    for i in range(k - 1, -1, -1):
        for j in range(i):
            x[j] -= a[i, j] * x[i]
