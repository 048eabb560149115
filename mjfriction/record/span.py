"""A time span: from its first moment on, up to but excluding its last."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

Span = tuple[float, float]
EVER: Span = (-math.inf, math.inf)


def within(span: Span, time: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Return which moments (n,), in s, lie in a span."""
    return (time >= span[0]) & (time < span[1])
