"""A span of time, from a moment on and up to another."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

Span = tuple[float, float]
EVER: Span = (-math.inf, math.inf)


def within(span: Span, time: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Return which of the moments (n,), s, lie in a span."""
    return (time >= span[0]) & (time < span[1])
