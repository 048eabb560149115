"""A line plot in a terminal, drawn in Braille dots."""

from __future__ import annotations

import numpy as np

from mjfriction.record.log import Floats

DOTS = np.array([[0x01, 0x08], [0x02, 0x10], [0x04, 0x20], [0x40, 0x80]])  # bits of one character's dots, (row, column)
BLANK = 0x2800


def line_plot(x: Floats, y: Floats, *, width: int = 60, height: int = 12, title: str, across: str, up: str) -> str:
    """Return a plot of ``y`` against ``x``, each (n,), as lines of text; ``width`` by ``height`` characters inside."""
    low, high = float(np.min(y)), float(np.max(y))
    left, right = float(np.min(x)), float(np.max(x))
    tall, wide = 4 * height - 1, 2 * width - 1
    # Interpolate between samples so densely that every dot of the line is set, also on steep flanks.
    where = np.linspace(0.0, x.size - 1.0, 40 * wide)
    columns = np.rint((np.interp(where, np.arange(x.size), x) - left) / max(right - left, 1e-300) * wide).astype(int)
    rows = np.rint((high - np.interp(where, np.arange(y.size), y)) / max(high - low, 1e-300) * tall).astype(int)
    cells = np.full((height, width), BLANK)
    np.bitwise_or.at(cells, (rows // 4, columns // 2), DOTS[rows % 4, columns % 2])
    marks = {0: f"{high:.3g}", height - 1: f"{low:.3g}"}
    margin = max(len(mark) for mark in marks.values())
    body = [f"{marks.get(i, ''):>{margin}} │{''.join(map(chr, row)).rstrip(chr(BLANK))}" for i, row in enumerate(cells)]
    ends = f"{left:.3g}", f"{right:.3g}"
    ruler = f"{'':>{margin}} └{ends[0]}{across:^{width - len(ends[0]) - len(ends[1])}}{ends[1]}"
    return "\n".join([f"{title} ({up})", *body, ruler])
