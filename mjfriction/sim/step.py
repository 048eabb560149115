"""What the callback does in every step: commit the bristles, predict the end of the step, apply the friction.

MuJoCo calls it when the positions and velocities of a step are known but its forces are not.  The callback computes all
smooth forces of the step, so the friction responds to this very step.  Forces that only the constraint solver knows
(contacts, limits, equalities) are taken from the step before: they are the part of the last velocity change that was
not predicted.  Where no constraint was active there is no such force, and any other velocity than the predicted one was
set by the user.  The load that a law reads takes gravity and velocity from this step and accelerations from the last
one.  The torque that accelerates a joint's armature, which is its drive's rotor, is kept apart.  The bristles advance
with the velocity that actually came out, when the next step begins.
"""

from __future__ import annotations

import math

from mjfriction.laws.ambient import (
    LOAD,
    POSITION,
    PRESSURE_HEAD,
    PRESSURE_ROD,
    ROOM_TEMPERATURE,
    ROTOR,
    SLIDING,
    TEMPERATURE,
)
from mjfriction.laws.law import Floats, kernel, routine
from mjfriction.laws.window import address, window, window_at
from mjfriction.sim import block as at
from mjfriction.sim import memory as mem
from mjfriction.sim.balance import balance
from mjfriction.sim.forces import add_implicit_damping, add_known_forces, gather_inertia, symmetric
from mjfriction.sim.memory import (
    Block,
    Desk,
    Kept,
    find_block,
    flag,
    has_room,
    numbers,
    open_block,
    open_desk,
    open_kept,
    scalar,
)
from mjfriction.sim.native import free_stack, mark_stack, warning
from mjfriction.sim.rub import rub
from mjfriction.sim.solve import eliminate, restore

# Relative and absolute (rad/s or m/s) difference up to which a velocity counts as the predicted one.
SAME, STILL = 1e-9, 1e-13
RUNGE_KUTTA = 1  # mjINT_RK4
BAD_FORCE = 6  # mjWARN_BADCTRL, the warning for a number that would have corrupted the forces; checked by a test


@kernel
def look_back(block: Block, kept: Kept, a: Floats, now: Floats, time: float, free: bool, missed: Floats) -> bool:
    """Find out what happened since the last call, and return whether a step was made.

    After a step, the accelerations follow from the change of velocity.  The constraint force of that step is the
    assumed one plus the part that the unpredicted velocity change shows.  A step from a state without constraints ended
    as predicted: a velocity that is another was set since.  In a state that is ``free`` of constraints there is no such
    force.  After a jump in time both are reset to zero.  ``now`` (n,) are the velocities of the touched dofs;
    ``missed`` (n,) is work space.
    """
    then, step = kept.stamp[at.U_TIME], kept.stamp[at.U_STEP]
    if time == then:
        return False
    if time != then + step:
        for p in range(block.touched):
            kept.moved[p] = kept.unknown[p] = 0.0
        if time < then:  # restarted, e.g. by a rollout, which does not reset user data
            for i in range(block.states):
                kept.z[i] = 0.0
        return False
    as_predicted, was_free, per_step = True, kept.stamp[at.U_FREE] > 0.0, 1.0 / step
    for p in range(block.touched):
        reached = kept.predicted[p] if was_free else now[p]
        missed[p] = reached - kept.predicted[p]
        kept.moved[p] = (reached - kept.before[p]) * per_step
        as_predicted &= abs(missed[p]) <= SAME * abs(now[p]) + STILL
    if free:
        for p in range(block.touched):
            kept.unknown[p] = 0.0
    elif not as_predicted:
        for p in range(block.touched):
            kept.unknown[p] += symmetric(a, missed, p) * per_step
    return True


@kernel
def look_around(model: int, data: int, block: Block, kept: Kept, a: Floats, around: Floats) -> None:
    """Write the surroundings of the joints with friction into ``around`` (k, 7)."""
    first = block.touched - block.rubbing
    for i in range(block.rubbing):
        around[i, ROTOR] = 0.0
    if block.reads_load:
        bias, armature = numbers(data, mem.F_BIAS, block.nv), numbers(model, mem.F_ARMATURE, block.nv)
        for i in range(block.rubbing):
            p = first + i
            dof = int(block.dofs[p])
            around[i, ROTOR] = armature[dof] * kept.moved[p]
            kept.load[i] = bias[dof] + symmetric(a, kept.moved, p) - kept.unknown[p] - around[i, ROTOR]
    place = numbers(data, mem.F_QPOS, block.nq)
    for i in range(block.rubbing):
        around[i, LOAD] = kept.load[i]
        around[i, POSITION] = place[int(block.positions[i])]
        around[i, TEMPERATURE] = ROOM_TEMPERATURE + kept.warmth[i]
        around[i, PRESSURE_HEAD] = kept.pressure_head[i]
        around[i, PRESSURE_ROD] = kept.pressure_rod[i]
        around[i, SLIDING] = kept.before[first + i]  # of the step to commit; that of the present step is set later


@kernel
def guess(block: Block, kept: Kept, h: float, desk: Desk) -> None:
    """Write a first guess of the end velocities of the step: each joint keeps its acceleration, but stops at rest."""
    first = block.touched - block.rubbing
    for i in range(block.rubbing):
        desk.v[i] = desk.start[i] + h * kept.moved[first + i]
        if desk.v[i] * desk.start[i] <= 0.0:
            desk.v[i] = 0.0


@kernel
def commit(block: Block, kept: Kept, step: float, desk: Desk) -> None:
    """Advance the states with the velocity that actually came out of the last step.

    Where that is the predicted velocity, as it is without constraints, the states predicted with it are taken.
    """
    first, as_predicted = block.touched - block.rubbing, kept.stamp[at.U_ROUNDS] > 0.0
    for i in range(block.rubbing):
        missed = abs(desk.start[i] - kept.predicted[first + i])
        if not (kept.stamp[at.U_FREE] > 0.0 or missed <= SAME * abs(desk.start[i]) + STILL):
            as_predicted = False
    if not as_predicted:
        rub(
            block.address, block.terms, block.term_count, 0, block.rubbing, address(desk.start, 0),
            address(desk.around, 0), address(kept.z, 0), step, address(kept.z_next, 0), address(desk.near, 0),
            address(desk.trial, 0), address(desk.slope, 0),
        )  # fmt: skip
    for i in range(block.states):
        kept.z[i] = kept.z_next[i]


@kernel
def apply(data: int, block: Block, kept: Kept, h: float, desk: Desk) -> None:
    """Subtract the friction from qfrc_passive: the laws' torque plus the force that the balance still lacks.

    So MuJoCo reaches the velocity that was found, to rounding, even in the rare step without a balance.
    """
    passive = numbers(data, mem.F_PASSIVE, block.nv)
    first, per_step = block.touched - block.rubbing, 1.0 / h
    for i in range(block.rubbing):
        force = desk.trial[i] + desk.change[i] * per_step
        if not math.isfinite(force):
            kept.stamp[at.U_FAILED] = i + 1
            warning(data, BAD_FORCE, i)
            force = 0.0
        dof = int(block.dofs[first + i])
        kept.torque[i] = force
        passive[dof] -= force
        kept.marked[i] = passive[dof]
        desk.end_velocity[first + i] = desk.v[i] - desk.start[i]


@routine
def friction_step(model: int, data: int) -> None:
    """Apply the friction of this step to qfrc_passive; do nothing for a model without friction."""
    where = find_block(model)
    if where == 0:
        return
    head = window_at(where, at.HEADER)
    nv, n, k = int(head[at.H_DOFS]), int(head[at.H_TOUCHED]), int(head[at.H_RUBBING])
    if nv == 6 and n == 6 and k == 6:
        step_of_size(model, data, where, 6, 6, 6)  # the usual arm: constant loop lengths unroll and save a fifth
    else:
        step_of_size(model, data, where, nv, n, k)


@kernel
def step_of_size(model: int, data: int, where: int, nv: int, n: int, k: int) -> None:
    """Step a model of ``nv`` dofs, of which ``n`` are touched and ``k`` have friction."""
    block = open_block(where, nv, n, k)
    if not has_room(model, block):
        warning(data, BAD_FORCE, 0)
        return
    kept = open_kept(data, block)
    if flag(model, mem.F_INTEGRATOR) == RUNGE_KUTTA:
        kept.stamp[at.U_FAILED] = -1.0  # set after attaching, which refuses it; ensure_sound raises
        return
    mark_stack(data)
    desk = open_desk(data, block)
    time, h = scalar(data, mem.F_TIME), scalar(model, mem.F_TIMESTEP)
    velocity = numbers(data, mem.F_QVEL, block.nv)

    for p in range(block.touched):
        desk.now[p] = velocity[int(block.dofs[p])]
    gather_inertia(model, data, block.dofs, block.local, desk.a)
    free = block.foreseen and flag(data, mem.F_NEFC) == 0
    stepped = look_back(block, kept, desk.a, desk.now, time, free, desk.end_velocity)
    look_around(model, data, block, kept, desk.a, desk.around)
    guess(block, kept, h, desk)
    if stepped:
        commit(block, kept, kept.stamp[at.U_STEP], desk)
    for i in range(block.rubbing):
        desk.around[i, SLIDING] = desk.start[i]
    kept.stamp[at.U_TIME], kept.stamp[at.U_STEP], kept.stamp[at.U_FREE] = time, h, 1.0 if free else 0.0

    add_known_forces(model, data, block, kept, desk.full, desk.f)
    add_implicit_damping(model, data, h, block.actuators, block.dofs, block.local, desk.a)
    for p in range(block.touched):
        desk.f[p] = h * (desk.f[p] + kept.unknown[p])
    first = block.touched - block.rubbing
    eliminate(desk.a, desk.f, first)
    for i in range(block.rubbing):
        for j in range(i + 1):
            desk.s[i, j] = desk.s[j, i] = desk.a[first + i, first + j]
    b = window(desk.f, first, block.rubbing)
    rounds = balance(
        desk.s, b, desk.start, block.address, block.terms, block.term_count, address(desk.around, 0),
        address(kept.z, 0), h, address(kept.z_next, 0), address(desk.near, 0), desk.v, desk.change, desk.j, desk.trial,
        desk.slope, desk.v_before, desk.torque_before,
    )  # fmt: skip
    kept.stamp[at.U_ROUNDS] = rounds
    apply(data, block, kept, h, desk)
    restore(desk.a, desk.f, desk.end_velocity, first)
    for p in range(block.touched):
        kept.before[p] = desk.now[p]
        kept.predicted[p] = desk.now[p] + desk.end_velocity[p]
    free_stack(data)
