"""How much of a residual is structure at all, and along which covariate, before any cause is assumed."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mjfriction.identify.gap import Gap
from mjfriction.identify.regression import Rows, System
from mjfriction.record.log import Floats

KNOTS = 14
# Least distance of knots, as a share of the covariate's range: many rows of a joint at rest have the same value to the
# last digit.
CLOSEST = 1e-6
COVARIATES = ("velocity", "position", "acceleration", "effort", "load", "time")


@dataclass(frozen=True)
class Structure:
    """The share of a joint's residual variance that a smooth curve over one covariate predicts on held-out motion.

    It is cross-validated, so that noise gives 0 or a little less, never more.  The covariate may also be none that is
    known: the share is then what stands above the noise in the residual's spectrum.
    """

    joint: str
    covariate: str
    share: float


def find_structure(gap: Gap, residual: Floats) -> list[Structure]:
    """Return the structured share of a residual (rows, joints) for every examined joint and covariate."""
    out = []
    for joint in gap.examined:
        for covariate in COVARIATES:
            values = covariate_rows(gap, joint, covariate)
            if np.ptp(values) > 0.0:
                share = curve_share(gap, joint, values, residual)
                out.append(Structure(gap.robot.joints[joint], covariate, share))
    return out


def covariate_rows(gap: Gap, joint: int, covariate: str) -> Floats:
    """Return a covariate of a joint at the rows, (rows,)."""
    motion = gap.motion
    sources = {
        "velocity": motion.velocity[:, joint],
        "position": motion.position[:, joint],
        "acceleration": motion.acceleration[:, joint],
        "effort": gap.effort.rigid[:, joint],
        "load": np.abs(gap.effort.load[:, joint]) * gap.forward(joint),  # signed as friction that grows with the load
    }
    return gap.chain.time if covariate == "time" else gap.chain.rows(sources[covariate])


def curve_share(gap: Gap, joint: int, values: Floats, residual: Floats) -> float:
    """Return the share of a joint's squared residual that a smooth curve over ``values`` (rows,) predicts held-out.

    ``residual`` has shape (rows, joints); noise gives 0 or a little less.  Only clear rows count: a joint at rest holds
    one friction value for each rest, which may follow time or position in any way.
    """
    noise = gap.rms(residual[:, joint], joint)
    if noise == 0.0:
        return 0.0
    clear = gap.clear[:, [joint]]
    weight = clear / np.sqrt(noise**2 + np.square(gap.doubt[:, [joint]]))
    knots = np.quantile(values, np.linspace(0.0, 1.0, KNOTS))
    knots = knots[np.diff(knots, prepend=-np.inf) > CLOSEST * np.ptp(values)]
    hats = np.column_stack([np.interp(values, knots, row) for row in np.eye(knots.size)])
    precision = np.full(knots.size, 1e-2 / noise**2)
    normal = System(Rows(residual[:, [joint]], weight, gap.blocks.row), [{0: hats}], [precision]).normal
    left = float(normal.heldout_errors(gap.blocks.folds).sum())
    return 1.0 - left / max(float(normal.power.sum()), 1e-300)
