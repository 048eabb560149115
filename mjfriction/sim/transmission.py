"""Transmissions between motor and link in MuJoCo: compliance, backlash, and drives that two joints share."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Mapping, Sequence
from typing import NamedTuple

import mujoco
import numpy as np

from mjfriction.laws.law import Floats
from mjfriction.sim.ringing import deflection

GIVE = "{}_give"  # name of the joint added to a motor's: its position is how far the link is ahead of the motor
STOP_TIME = 2.0  # time steps; time constant of the stiffest stop that MuJoCo's solver accepts
ASKEW = 1e-6  # rad; angle between the axes of a sliding joint and its give
SAG_ROUNDS = 4  # fixed-point rounds; each leaves a few percent of the change of load that the one before made
GIVE_DAMPING = 0.1  # damping ratio of the link on its compliant transmission, where none is stated


class DeadZone(NamedTuple):
    """A dead zone in a transmission: free within ``half`` the play on either side, with a damped spring beyond it.

    ``half`` is in rad or m, ``stiffness`` in N·m/rad or N/m, ``damping`` in N·m·s/rad or N·s/m, ``hardening`` in
    N·m/rad³ or N/m³.
    """

    half: float
    stiffness: float
    damping: float
    hardening: float = 0.0

    def force(self, give: float, speed: float) -> float:
        """Return the force on the link, N·m or N; it only pushes back towards the dead zone and never pulls."""
        beyond = give - min(max(give, -self.half), self.half)
        if beyond == 0.0:
            return 0.0
        force = -(self.stiffness + self.hardening * beyond**2) * beyond - self.damping * speed
        return force if force * beyond < 0.0 else 0.0


def give_places(model: mujoco.MjModel, joints: Sequence[str]) -> dict[int, int]:
    """Return the address in ``qpos`` of the give of each joint that was split, by the joint's index."""
    behind = {i: GIVE.format(name) for i, name in enumerate(joints)}
    known = {model.joint(i).name for i in range(model.njnt)}
    return {i: int(model.jnt_qposadr[model.joint(name).id]) for i, name in behind.items() if name in known}


def sag(model: mujoco.MjModel, data: mujoco.MjData, gives: Mapping[int, int], zones: Mapping[int, DeadZone]) -> None:
    """Compute the state of a pose in which transmissions on springs give by what they carry.

    ``gives`` are their places in ``qpos``, and ``zones`` their dead zones where they have any, by joint.  A link that
    started where its motor is would swing for as long as its damping lets it.
    """
    mujoco.mj_forward(model, data)
    held = {int(place): i for i, place in enumerate(model.jnt_qposadr)}
    # What a link carries changes a little as it gives.
    for _, (joint, place) in itertools.product(range(SAG_ROUNDS), gives.items()):
        give = held[place]
        load = float(data.qfrc_bias[model.jnt_dofadr[give]])
        spring, hardening = float(model.jnt_stiffness[give]), float(model.jnt_stiffnesspoly[give, 1])
        zone = zones.get(joint, DeadZone(0.0, spring, 0.0, hardening))
        if zone.stiffness > 0.0:
            beyond = deflection(np.array([load / zone.stiffness]), zone.hardening / zone.stiffness)
            data.qpos[place] = -(np.sign(load) * zone.half + float(beyond[0]))
        mujoco.mj_forward(model, data)


def behind_stops(model: mujoco.MjModel, zones: Mapping[str, DeadZone]) -> Callable[[mujoco.MjData], None]:
    """Return a function that applies the forces of dead zones, given by joint, to the gives in the data."""
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
    hardening: float = 0.0,
) -> DeadZone | None:
    """Split a joint of a spec into the motor's joint and the give of its transmission, in place.

    The joint keeps its name and its rotor and becomes the motor's.  A second joint about the same axis,
    ``<joint>_give``, moves the link relative to the motor: on a spring of torque give/``compliance`` +
    ``hardening``·give³, or between stops ``backlash`` apart.  With both, the spring acts beyond the play; it is
    returned as a dead zone for :func:`behind_stops` to apply.  ``inertia`` is that of the link, kg·m² or kg;
    ``damping_ratio`` is that of the link on the spring, relative to critical damping (:data:`GIVE_DAMPING` where it is
    not known).
    """
    own = spec.joint(joint)
    degree = 180.0 / np.pi if spec.compiler.degree and own.type == mujoco.mjtJoint.mjJNT_HINGE else 1.0
    axis = own.axis if own.type == mujoco.mjtJoint.mjJNT_HINGE else _askew(own.axis)
    give = own.parent.add_joint(name=GIVE.format(joint), type=own.type, axis=axis, pos=own.pos)
    damping = 2.0 * (damping_ratio or GIVE_DAMPING) * np.sqrt(inertia / compliance) if compliance > 0.0 else 0.0
    if compliance > 0.0 and backlash > 0.0:
        return DeadZone(0.5 * backlash, 1.0 / compliance, damping, hardening)
    if compliance > 0.0:
        give.stiffness, give.damping[0] = [1.0 / compliance, 0.0, hardening], damping
    if backlash > 0.0:
        # Stops at half the play on either side, as stiff as the solver accepts.
        give.limited = mujoco.mjtLimited.mjLIMITED_TRUE
        give.range = [-0.5 * backlash * degree, 0.5 * backlash * degree]
        give.solref_limit = [STOP_TIME * spec.option.timestep, 1.0]
    return None


def _askew(axis: Floats) -> Floats:
    # MuJoCo assumes that the axes of a body that only slides along x, y and z are orthogonal, so two slides along the
    # same axis would not be coupled.  With one axis turned by a millionth of a radian they are.
    across = np.eye(3)[int(np.argmin(np.abs(axis)))]
    return np.asarray(axis / np.linalg.norm(axis) + ASKEW * across)


def couple_drive(
    spec: mujoco.MjSpec, joint: str, other: str, ratio: float, *, coulomb: float, viscous: float, inertia: float
) -> None:
    """Add the friction and inertia of a drive that turns with joint + ratio·other, in place."""
    tendon = spec.add_tendon(name=f"{joint}_{other}_drive")
    tendon.wrap_joint(joint, 1.0)
    tendon.wrap_joint(other, ratio)
    tendon.frictionloss = coulomb
    tendon.damping[0] = viscous
    tendon.armature = inertia
    tendon.solref_friction = [STOP_TIME * spec.option.timestep, 1.0]
