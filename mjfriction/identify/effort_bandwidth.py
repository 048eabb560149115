"""Bandwidths of drives that low-pass the efforts they report: those that bring a robot's prediction nearest to them."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from scipy.optimize import minimize_scalar

from mjfriction.identify.gap import Gap
from mjfriction.record.log import Floats
from mjfriction.robot.effort import predict_effort
from mjfriction.robot.robot import Robot

WORTH = 0.95  # a low-pass is stated where it leaves at most this share of the squared error
WIDEST = 4.0  # factor up and down by which the search goes beyond the frequency above which an effort's steps are gone


def find_bandwidths(gap: Gap, robot: Robot) -> dict[str, float]:
    """Return the bandwidths (Hz) of drives, by joint, where a gap's log shows a low-pass that a robot does not state.

    ``robot`` is the identified one: the sharper its prediction, the better the low-pass is known.
    """
    found = gap.filtered
    sensors = [joint.effort_sensor for joint in robot.table.joint]
    unstated = [j for j in gap.examined if np.isfinite(found[j]) and sensors[j].bandwidth is None]
    if not unstated:
        return {}
    reported = gap.motion.torque * gap.per_reported
    predicted = predict_effort(robot, robot.body(), gap.motion).reported
    nearest = {j: _nearest(gap, j, reported[:, j], predicted[:, j]) for j in unstated}
    return {robot.joints[j]: bandwidth for j, bandwidth in nearest.items() if bandwidth is not None}


def with_bandwidths(robot: Robot, bandwidths: Mapping[str, float]) -> Robot:
    """Return a robot that states the bandwidths (Hz) of drives, by joint."""
    for name, bandwidth in bandwidths.items():
        joint = robot.joint(name)
        sensor = joint.effort_sensor.model_copy(update={"bandwidth": bandwidth})
        robot = robot.with_joint(joint.model_copy(update={"effort_sensor": sensor}))
    return robot


def _nearest(gap: Gap, joint: int, reported: Floats, predicted: Floats) -> float | None:
    # Compared where the joint surely moves.  At rest its friction is what its drive gives, which may turn over as
    # slowly as if it were filtered; what a filter makes of a reversal lasts longer than that.
    motion, first = gap.motion, float(gap.filtered[joint])
    known = motion.settled & (np.abs(motion.velocity[:, joint]) > gap.doubt_speed[joint])

    def missed(logarithm: float) -> float:
        left = reported - motion.low_passed(predicted, float(np.exp(logarithm)))
        return float(np.mean(np.square(left[known])))

    reach = float(np.log(WIDEST))
    bounds = (np.log(first) - reach, np.log(first) + reach)
    found = minimize_scalar(missed, bounds=bounds, method="bounded", options={"xatol": 0.01})
    sharp = float(np.mean(np.square((reported - predicted)[known])))
    return float(np.exp(found.x)) if found.fun < WORTH * sharp else None
