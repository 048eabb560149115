"""A model under joint control, step by step: feedforward, PD and torque limits, with the drives' own torques beside."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import mujoco
import numpy as np

from mjfriction.errors import SimulationError
from mjfriction.laws.law import Floats
from mjfriction.sim.attach import Laws, attach, rewrite
from mjfriction.sim.callback import friction_active

GIVE = "{}_give"  # the joint behind a transmission's own: how far the link is ahead of its motor
STOP_TIME = 2.0  # time steps: the stiffest stop that MuJoCo's solver takes
SETTLING = 0.5  # s
GIVE_DAMPING = 0.1  # of critical, of the link on its compliant transmission


@dataclass(frozen=True)
class Gains:
    """Feedback of position (N·m/rad) and velocity (N·m·s/rad), and the drives' limits (N·m), each (joints,)."""

    stiffness: Floats
    damping: Floats
    limit: Floats


@dataclass(frozen=True)
class Course:
    """What the joints are to do at every step: position, velocity and the torque known beforehand, each (n, joints)."""

    position: Floats
    velocity: Floats
    feedforward: Floats


@dataclass(frozen=True)
class Played:
    """What they did: motor-side position and velocity, drive torque, and position of the links, each (n, joints)."""

    position: Floats
    velocity: Floats
    torque: Floats
    link_position: Floats


Passive = Callable[[Floats, Floats, Floats], Floats]
"""(position, velocity, drive torque) → torque that stands against the drives at the joints, (joints,)."""


def play(
    spec: mujoco.MjSpec,
    joints: tuple[str, ...],
    laws: Laws,
    course: Course,
    gains: Gains,
    step: float,
    *,
    passive: Passive | None = None,
    laws_at: Callable[[int], Laws | None] | None = None,
) -> Played:
    """Run a model along a course and return what happened at the beginning of every step.

    The torque of a step is held through it.  ``laws_at`` may give other laws (of the same kinds) for a step on.

    Raises :class:`SimulationError` when the run leaves what can be computed: the joint and the time.
    """
    spec.option.timestep = step
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    model = attach(spec, laws) if laws else spec.compile()
    data = mujoco.MjData(model)
    places = np.array([model.jnt_qposadr[model.joint(name).id] for name in joints])
    dofs = np.array([model.jnt_dofadr[model.joint(name).id] for name in joints])
    behind = {i: GIVE.format(name) for i, name in enumerate(joints)}
    known = {model.joint(i).name for i in range(model.njnt)}
    gives = {i: int(model.jnt_qposadr[model.joint(name).id]) for i, name in behind.items() if name in known}
    data.qpos[places] = course.position[0]
    data.qvel[dofs] = course.velocity[0]
    mujoco.mj_forward(model, data)
    settling = round(SETTLING / step) if gives else 0
    count = course.position.shape[0]
    out = Played(*(np.empty((count, len(joints))) for _ in range(4)))
    applied = np.zeros(model.nv)
    with friction_active():
        for step_number in range(-settling, count):
            k = max(step_number, 0)  # what gives first takes up its load, at the course's beginning
            position, velocity = data.qpos[places], data.qvel[dofs]
            torque = course.feedforward[k] + gains.stiffness * (course.position[k] - position)
            torque += gains.damping * (course.velocity[k] - velocity)
            torque = np.clip(torque, -gains.limit, gains.limit)
            out.position[k], out.velocity[k], out.torque[k] = position, velocity, torque
            out.link_position[k] = position
            for i, place in gives.items():
                out.link_position[k, i] += data.qpos[place]
            applied[dofs] = torque if passive is None else torque - passive(position, velocity, torque)
            data.qfrc_applied[:] = applied
            if laws_at is not None:
                changed = laws_at(k)
                if changed is not None:
                    rewrite(model, changed)
            mujoco.mj_step(model, data)
    bad = ~np.isfinite(out.position)
    faults = (mujoco.mjtWarning.mjWARN_BADQPOS, mujoco.mjtWarning.mjWARN_BADQVEL, mujoco.mjtWarning.mjWARN_BADQACC)
    if np.any(bad) or any(data.warning[int(fault)].number for fault in faults):
        row, joint = np.argwhere(bad)[0] if np.any(bad) else (0, 0)
        raise SimulationError(
            f"the run went out of bounds at joint '{joints[joint]}' near {row * step:.3g} s: lower the gains, shorten "
            "the step or slow the trajectory down"
        )
    return out


def split_transmission(spec: mujoco.MjSpec, joint: str, *, compliance: float, backlash: float, inertia: float) -> None:
    """Part a joint of a spec into the motor's turn and the give of its transmission, in place.

    The joint keeps its name and its rotor and becomes the motor's; a second one about the same axis, ``<joint>_give``,
    moves the link by what the transmission gives: a spring of 1/``compliance``, or stops ``backlash`` apart.
    ``inertia`` is what the link weighs, kg·m² or kg.
    """
    own = spec.joint(joint)
    degree = 180.0 / np.pi if spec.compiler.degree and own.type == mujoco.mjtJoint.mjJNT_HINGE else 1.0
    give = own.parent.add_joint(name=GIVE.format(joint), type=own.type, axis=own.axis, pos=own.pos)
    if compliance > 0.0:
        give.stiffness[0] = 1.0 / compliance
        give.damping[0] = 2.0 * GIVE_DAMPING * np.sqrt(inertia / compliance)
    if backlash > 0.0:
        # A stop as stiff as a rigid one behind half the play on either side; with compliance, the spring acts besides.
        give.limited = mujoco.mjtLimited.mjLIMITED_TRUE
        give.range = [-0.5 * backlash * degree, 0.5 * backlash * degree]
        give.solref_limit = [STOP_TIME * spec.option.timestep, 1.0]


def drop_actuators(spec: mujoco.MjSpec) -> None:
    """Take a model's own actuators out of a spec, in place: the drives act on the joints themselves."""
    for actuator in list(spec.actuators):
        spec.delete(actuator)


def couple_friction(spec: mujoco.MjSpec, joint: str, other: str, ratio: float, coulomb: float, viscous: float) -> None:
    """Let a drive that turns with joint + ratio·other rub, in place."""
    tendon = spec.add_tendon(name=f"{joint}_{other}_drive")
    tendon.wrap_joint(joint, 1.0)
    tendon.wrap_joint(other, ratio)
    tendon.frictionloss = coulomb
    tendon.damping[0] = viscous
    tendon.solref_friction = [STOP_TIME * spec.option.timestep, 1.0]
