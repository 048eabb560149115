"""Friction in a running simulation: torque, bristle states and inputs of every joint, as slices of its user data."""

from __future__ import annotations

from dataclasses import dataclass

import mujoco
import numpy as np
from numpy.typing import NDArray

from mjfriction.errors import SimulationError, suggestion
from mjfriction.laws.law import Floats
from mjfriction.sim import block as at
from mjfriction.sim.attach import numeric_slice, refuse_integrator

BROKEN = {
    mujoco.mjtWarning.mjWARN_BADQPOS: ("position", "jnt_qposadr"),
    mujoco.mjtWarning.mjWARN_BADQVEL: ("velocity", "jnt_dofadr"),
    mujoco.mjtWarning.mjWARN_BADQACC: ("acceleration", "jnt_dofadr"),
}


@dataclass(frozen=True)
class FrictionReader:
    """Where a model's friction is stored in ``mjData.userdata``; make one with :func:`read_friction`.

    ``joints`` (k) are the joints with friction in the order of their dofs.  The slices index the last axis of
    ``data.userdata``, of ``batch.userdata`` or of recorded user data: ``torque``, ``load`` (k numbers: N·m or N),
    ``warmth`` (kelvin above 25 °C), ``pressure_head``, ``pressure_rod`` (Pa; these three are inputs that may be
    written), ``rounds`` (one number: solver rounds of the last step, −1 where it found no balance).
    """

    joints: tuple[str, ...]
    torque: slice
    load: slice
    warmth: slice
    pressure_head: slice
    pressure_rod: slice
    rounds: slice
    states: dict[str, slice]

    def state(self, joint: str) -> slice:
        """Return the slice of a joint's states, law by law; raises :class:`SimulationError` for one without any."""
        if joint not in self.states:
            raise SimulationError(
                f"joint '{joint}' carries no friction{suggestion(joint, self.joints)} "
                f"These do: {', '.join(self.joints)}"
            )
        return self.states[joint]


def read_friction(model: mujoco.MjModel) -> FrictionReader:
    """Return where a model's friction is stored; raises :class:`SimulationError` for a model without friction.

    After a step, ``data.userdata[reader.torque]`` is the friction of that step and ``reader.state("elbow")`` the
    bristles at its beginning.
    """
    if not isinstance(model, mujoco.MjModel):
        raise SimulationError(f"where friction is stored is read from an MjModel, not from {type(model).__name__}")
    block = model.numeric_data[numeric_slice(model)]
    n, k = int(block[at.H_TOUCHED]), int(block[at.H_RUBBING])
    base = int(block[at.H_BASE])
    start = base + at.U_SCALARS + at.TOUCHED_ARRAYS * n

    def array(index: int) -> slice:
        return slice(start + index * k, start + (index + 1) * k)

    first = int(block[at.H_DOF_LIST]) + n - k
    dofs = block[first : first + k].astype(int)
    joints = tuple(model.joint(int(model.dof_jntid[dof])).name for dof in dofs)
    table, count = int(block[at.H_TERM_TABLE]), int(block[at.H_TERMS])
    rows = block[table : table + count * at.TERM_ROW].reshape(count, at.TERM_ROW).astype(int)
    origin = start + at.RUBBING_ARRAYS * k
    states = {}
    for i, joint in enumerate(joints):
        own = rows[rows[:, at.T_RUBBING] == i]
        begin, end = own[0, at.T_STATE], own[-1, at.T_STATE] + own[-1, at.T_STATES]
        states[joint] = slice(int(origin + begin), int(origin + end))
    return FrictionReader(
        joints=joints,
        torque=array(0),
        load=array(2),
        warmth=array(3),
        pressure_head=array(4),
        pressure_rod=array(5),
        rounds=slice(base + at.U_ROUNDS, base + at.U_ROUNDS + 1),
        states=states,
    )


def ensure_sound(model: mujoco.MjModel, data: mujoco.MjData) -> None:
    """Raise :class:`SimulationError` where the last step was made without friction, or where a NaN or an infinite
    number came up in the simulation, naming the joint.

    MuJoCo itself only counts a warning and, by default, restarts the simulation from its initial state.
    """
    reader = read_friction(model)
    refuse_integrator(model)
    base = int(model.numeric_data[numeric_slice(model)][at.H_BASE])
    failed = int(data.userdata[base + at.U_FAILED])
    if failed < 0:
        raise SimulationError("a step was made with integrator RK4, and without friction; start again without it")
    if failed:
        raise SimulationError(
            f"joint '{reader.joints[failed - 1]}': its friction came out NaN or infinite at t = {data.time:g} s; check "
            "the forces, controls and temperatures that reach it"
        )
    control = data.warning[mujoco.mjtWarning.mjWARN_BADCTRL]
    if control.number:
        actuator = model.actuator(control.lastinfo).name or control.lastinfo
        raise SimulationError(
            f"actuator '{actuator}': its control was NaN or infinite, and MuJoCo took all controls as zero "
            f"({control.number} times); check what sets it"
        )
    for kind, (what, addresses) in BROKEN.items():
        warning = data.warning[kind]
        if warning.number:
            joint = int(np.searchsorted(getattr(model, addresses), warning.lastinfo, side="right")) - 1
            raise SimulationError(
                f"joint '{model.joint(joint).name}' or one that moves with it: its {what} was NaN, infinite or huge, "
                f"and MuJoCo began again from the initial state ({warning.number} times); check forces and controls, "
                "or take a smaller step"
            )
    begun, step = (float(data.userdata[base + place]) for place in (at.U_TIME, at.U_STEP))
    if data.time > begun + 1.5 * max(step, model.opt.timestep):
        raise SimulationError(
            f"the step to t = {data.time:g} s was made without friction; step inside 'with friction_active():'"
        )


def torques(model: mujoco.MjModel, data: mujoco.MjData) -> dict[str, float]:
    """Return the friction of the last step by joint, N·m or N, as the drive has to supply it."""
    reader = read_friction(model)
    values: NDArray[np.float64] = data.userdata[reader.torque]
    return dict(zip(reader.joints, values.tolist(), strict=True))


def write_candidates(target: Floats, model: mujoco.MjModel, blocks: Floats) -> None:
    """Give every simulation of a batch its own friction: ``target`` is ``batch.expand("numeric_data")``.

    ``blocks`` (simulations, numbers) come from :func:`~mjfriction.sim.attach.candidate_blocks`.
    """
    target[:, numeric_slice(model)] = blocks
