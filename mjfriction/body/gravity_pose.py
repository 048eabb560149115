"""Which joints are loaded by gravity, and in which poses they are not.

A revolute joint feels no gravity while its axis is vertical, a sliding joint while its axis is horizontal.  Only the
joints before it set the direction of its axis, so such a pose stays free of gravity however the joint itself moves.
"""

from __future__ import annotations

import enum
from dataclasses import dataclass

import numpy as np
import pinocchio as pin
from scipy.optimize import minimize

from mjfriction.body.model import Body, configuration
from mjfriction.laws.law import Floats

FREE = 1e-3  # a pose is free of gravity for a joint that feels less than this fraction of it
DRAWS = 24  # random poses that are tried
WIDE = np.pi  # rad or m, a joint without limits is searched within ± this


class GravityClass(enum.Enum):
    """How gravity loads a joint; the value is the text shown to the user."""

    NEVER = "never loaded by gravity"
    BY_POSE = "free of gravity in some poses"
    ALWAYS = "loaded by gravity in every pose"


@dataclass(frozen=True)
class GravityPose:
    """A joint's gravity class, the pose (joints,) in rad or m in which it feels least gravity, and its share there."""

    kind: GravityClass
    pose: Floats
    share: float


def gravity_pose(body: Body, joint: int, *, seed: int = 0) -> GravityPose:
    """Return how gravity loads a joint, and the pose in which it does so least.

    ``share`` is the fraction of gravity perpendicular to the joint's axis (along it, for a sliding joint) in the
    returned pose.  Joints that do not matter stay in the middle of their range.
    """
    low = np.where(np.isfinite(body.lower), body.lower, -WIDE)
    high = np.where(np.isfinite(body.upper), body.upper, WIDE)
    middle = 0.5 * (low + high)
    draws = np.random.default_rng(seed).uniform(low, high, (DRAWS, low.size))
    felt = np.array([_felt(body, joint, pose) for pose in draws])
    if np.max(felt) < FREE:
        return GravityPose(GravityClass.NEVER, middle, float(np.max(felt)))
    before = [k for k in range(low.size) if _moves_axis(body, k, joint, draws[1], draws[0])]
    best, share = middle, _felt(body, joint, middle)
    for start in (middle, *draws[np.argsort(felt)[:4]]):
        pose = _freed(body, joint, before, start, low, high)
        own = _felt(body, joint, pose)
        if own < share - FREE:
            best, share = pose, own
        if share < FREE:
            break
    kind = GravityClass.BY_POSE if share < FREE else GravityClass.ALWAYS
    return GravityPose(kind, best, share)


def _freed(body: Body, joint: int, before: list[int], start: Floats, low: Floats, high: Floats) -> Floats:
    middle = 0.5 * (low + high)
    if not before:
        return middle

    def whole(part: Floats) -> Floats:
        pose = middle.copy()
        pose[before] = part
        return pose

    bounds = [(float(low[k]), float(high[k])) for k in before]
    found = minimize(
        lambda part: _felt(body, joint, whole(part)) ** 2, start[before], bounds=bounds, options={"ftol": 1e-14}
    )
    return whole(np.asarray(found.x))


def _moves_axis(body: Body, k: int, joint: int, pose: Floats, other: Floats) -> bool:
    moved = pose.copy()
    moved[k] = other[k]
    return k != joint and not np.allclose(_axis(body, joint, pose), _axis(body, joint, moved), atol=1e-9)


def _felt(body: Body, joint: int, pose: Floats) -> float:
    size = float(np.linalg.norm(body.gravity))
    if size == 0.0:
        return 0.0
    down = body.gravity / size
    along = float(_axis(body, joint, pose) @ down)
    return abs(along) if body.sliding[joint] else float(np.sqrt(max(0.0, 1.0 - along * along)))


def _axis(body: Body, joint: int, pose: Floats) -> Floats:
    # The unit axis of a joint in the world.
    data = body.model.createData()
    q = configuration(body, pose[None, :])[0]
    jacobian = pin.computeJointJacobians(body.model, data, q)
    number = body.model.getJointId(body.joints[joint])
    jacobian = pin.getJointJacobian(body.model, data, number, pin.LOCAL_WORLD_ALIGNED)
    column = np.reshape(jacobian, (6, body.model.nv))[:, body.columns[joint]]
    return np.asarray(column[:3] if body.sliding[joint] else column[3:])
