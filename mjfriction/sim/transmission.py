"""What lies between a motor and its link in MuJoCo: give, play, and drives that two joints share."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import NamedTuple

import mujoco
import numpy as np

from mjfriction.laws.law import Floats

GIVE = "{}_give"  # the joint behind a transmission's own: how far the link is ahead of its motor
STOP_TIME = 2.0  # time steps: the stiffest stop that MuJoCo's solver takes
ASKEW = 1e-6  # rad that a sliding joint's give is turned against it
GIVE_DAMPING = 0.1  # of critical, of the link on its compliant transmission


class DeadZone(NamedTuple):
    """A give that is free within half a play on either side, m or rad, and a damped spring beyond it: N·m/rad and
    N·m·s/rad, or N/m and N·s/m.
    """

    half: float
    stiffness: float
    damping: float

    def force(self, give: float, speed: float) -> float:
        """Return what it pushes the link with; it never pulls."""
        beyond = give - min(max(give, -self.half), self.half)
        if beyond == 0.0:
            return 0.0
        force = -self.stiffness * beyond - self.damping * speed
        return force if force * beyond < 0.0 else 0.0


def give_places(model: mujoco.MjModel, joints: Sequence[str]) -> dict[int, int]:
    """Return where in ``qpos`` the give of each joint stands that was split, by the joint's index."""
    behind = {i: GIVE.format(name) for i, name in enumerate(joints)}
    known = {model.joint(i).name for i in range(model.njnt)}
    return {i: int(model.jnt_qposadr[model.joint(name).id]) for i, name in behind.items() if name in known}


def behind_stops(model: mujoco.MjModel, zones: Mapping[str, DeadZone]) -> Callable[[mujoco.MjData], None]:
    """Return what lets dead zones, by joint, act on data as forces applied to the gives."""
    gives = [(zone, model.joint(GIVE.format(name))) for name, zone in zones.items()]
    places = [(zone, int(give.qposadr[0]), int(give.dofadr[0])) for zone, give in gives]

    def press(data: mujoco.MjData) -> None:
        for zone, place, dof in places:
            data.qfrc_applied[dof] = zone.force(float(data.qpos[place]), float(data.qvel[dof]))

    return press


def split_transmission(
    spec: mujoco.MjSpec,
    joint: str,
    *,
    compliance: float,
    backlash: float,
    inertia: float,
    damping_ratio: float | None = None,
) -> DeadZone | None:
    """Part a joint of a spec into the motor's turn and the give of its transmission, in place.

    The joint keeps its name and its rotor and becomes the motor's; a second one about the same axis, ``<joint>_give``,
    moves the link by what the transmission gives: a spring of 1/``compliance``, or stops ``backlash`` apart.  Where
    there are both, the spring stands behind the stops, and is returned for :func:`behind_stops` to let act.
    ``inertia`` is what the link weighs, kg·m² or kg; ``damping_ratio`` that of the link on the spring, over the
    critical one (:data:`GIVE_DAMPING` where it is not known).
    """
    own = spec.joint(joint)
    degree = 180.0 / np.pi if spec.compiler.degree and own.type == mujoco.mjtJoint.mjJNT_HINGE else 1.0
    axis = own.axis if own.type == mujoco.mjtJoint.mjJNT_HINGE else _askew(own.axis)
    give = own.parent.add_joint(name=GIVE.format(joint), type=own.type, axis=axis, pos=own.pos)
    damping = 2.0 * (damping_ratio or GIVE_DAMPING) * np.sqrt(inertia / compliance) if compliance > 0.0 else 0.0
    if compliance > 0.0 and backlash > 0.0:
        return DeadZone(0.5 * backlash, 1.0 / compliance, damping)
    if compliance > 0.0:
        give.stiffness[0], give.damping[0] = 1.0 / compliance, damping
    if backlash > 0.0:
        # A stop as stiff as a rigid one behind half the play on either side.
        give.limited = mujoco.mjtLimited.mjLIMITED_TRUE
        give.range = [-0.5 * backlash * degree, 0.5 * backlash * degree]
        give.solref_limit = [STOP_TIME * spec.option.timestep, 1.0]
    return None


def _askew(axis: Floats) -> Floats:
    # MuJoCo takes the axes of a body that only slides along x, y and z to be at right angles, and so would not let two
    # that share one move each other.  Along an axis turned by a millionth it does.
    across = np.eye(3)[int(np.argmin(np.abs(axis)))]
    return np.asarray(axis / np.linalg.norm(axis) + ASKEW * across)


def couple_drive(
    spec: mujoco.MjSpec, joint: str, other: str, ratio: float, *, coulomb: float, viscous: float, inertia: float
) -> None:
    """Let a drive that turns with joint + ratio·other rub and weigh, in place."""
    tendon = spec.add_tendon(name=f"{joint}_{other}_drive")
    tendon.wrap_joint(joint, 1.0)
    tendon.wrap_joint(other, ratio)
    tendon.frictionloss = coulomb
    tendon.damping[0] = viscous
    tendon.armature = inertia
    tendon.solref_friction = [STOP_TIME * spec.option.timestep, 1.0]
