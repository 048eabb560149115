"""The error of a robot at one joint."""

from __future__ import annotations

from dataclasses import dataclass

from mjfriction.identify.gap import Gap
from mjfriction.identify.proof import gain_at
from mjfriction.record.log import Floats
from mjfriction.robot.effort import reported_unit


@dataclass(frozen=True)
class JointError:
    """The RMS error of one joint before and after, fitted and held-out, in the unit that its drive reports.

    ``reduction_ci95`` is the 95 % interval of 1 − after/before, held-out.
    """

    joint: str
    signal: str
    unit: str
    rms_before: float
    rms_after: float
    rms_heldout_before: float
    rms_heldout_after: float
    noise_floor: float
    reduction_ci95: tuple[float, float]


def joint_error(
    gap: Gap, joint: int, residual_after: Floats, heldout: Floats, seed: int = 0, stated: Floats | None = None
) -> JointError:
    """Return the errors of an examined joint, before and after.

    ``stated`` is the residual before, that of the gap's robot if not given.  ``residual_after`` and ``heldout`` are
    what another robot leaves of the same rows, fitted and held-out; all are (rows, joints).  ``seed`` sets the
    resampling behind the interval of the reduction.
    """
    stated = gap.residual if stated is None else stated
    gain = gain_at(gap, stated, heldout, joint, seed)
    unit = abs(float(gap.per_reported[joint]))
    quantity = gap.motion.quantity[joint]
    assert quantity is not None, "examined joints have a measurement"
    before = gap.rms(stated[:, joint], joint) / unit
    return JointError(
        joint=gap.robot.joints[joint],
        signal=quantity,
        unit=reported_unit(quantity, gap.body.sliding[joint]),
        rms_before=before,
        rms_after=gap.rms(residual_after[:, joint], joint) / unit,
        rms_heldout_before=before,
        rms_heldout_after=gap.rms(heldout[:, joint], joint) / unit,
        noise_floor=float(gap.noise_floor[joint]) / unit,
        reduction_ci95=(gain.low, gain.high),
    )
