"""The combinations of inertial parameters that a motion identifies, each by itself.

Efforts are linear in the links' inertial parameters, but the columns depend on one another.  Pivoted QR takes as many
columns as are independent, and adds to each parameter the share that those left out have in it (Gautier, IEEE ICRA
1990; Khalil, Dombre, Modeling, Identification and Control of Robots, 2002, chapter 9).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.linalg import block_diag, qr, solve_triangular

from mjfriction.body.inertia import NAMES
from mjfriction.identify.fitted import Fitted
from mjfriction.record.log import Floats

SHOWN = 10.0  # deviations by which the rows must show a parameter that is off by its own size, for it to count
TERMS, LEAST = 3, 0.01  # how many of the left-out parameters are named at most, and from which share on
UNITS = ("kg", *["kg·m"] * 3, *["kg·m²"] * 6)


def base_parameters(
    links: Sequence[str],
    values: Floats,
    stated: Floats,
    weight: Floats,
    gram: Floats,
    covariance: Floats,
    quantile: float,
) -> list[Fitted]:
    """Return the base parameters of links with their intervals, those that show most first.

    ``values`` and ``stated`` (10·links,) are inertial parameters; ``weight`` (links, 10, 10) turns strengths into them.
    ``gram`` and ``covariance`` (10·links, 10·links) are those of the strengths, with rows weighted by their deviations.
    ``quantile`` is how many deviations an interval reaches to either side.
    """
    turned = block_diag(*weight)
    size = np.sqrt(np.sum(np.square(turned), axis=1))
    inverse = np.linalg.inv(turned) * size
    power, directions = np.linalg.eigh(inverse.T @ gram @ inverse)
    root = np.sqrt(np.maximum(power, 0.0))[:, None] * directions.T
    upper, order = qr(root, mode="r", pivoting=True)
    rank = int(np.sum(np.abs(np.diag(upper)) > SHOWN))
    if rank == 0:
        return []
    kept, dropped = order[:rank], order[rank:]
    share = solve_triangular(upper[:rank, :rank], upper[:rank, rank:])
    grouping = np.zeros((rank, values.size))
    grouping[np.arange(rank), kept] = 1.0
    grouping[:, dropped] = share * size[kept][:, None] / size[dropped]
    spread = grouping @ turned @ covariance @ turned.T @ grouping.T
    half = quantile * np.sqrt(np.maximum(np.diag(spread), 0.0))
    names = [f"{name}.{link}" for link in links for name in NAMES]
    out = []
    for i, k in enumerate(kept.tolist()):
        weighed = grouping[i] * size / size[k]
        value, own = float(grouping[i] @ values), float(half[i])
        meaning = _in_words(names, k, grouping[i], weighed)
        note = f"stated {float(grouping[i] @ stated):.4g}"
        out.append(Fitted(names[k], meaning, UNITS[k % len(UNITS)], value, value - own, value + own, note))
    return out


def _in_words(names: Sequence[str], own: int, weights: Floats, weighed: Floats) -> str:
    others = [k for k in np.argsort(-np.abs(weighed)).tolist() if k != own and abs(weighed[k]) > LEAST]
    if not others:
        return "by itself"
    listed = "".join(f" {'+' if weights[k] > 0 else '−'} {abs(weights[k]):.3g}·{names[k]}" for k in others[:TERMS])
    more = f" and {len(others) - TERMS} more" if len(others) > TERMS else ""
    return f"with{listed}{more}"
