"""What the callback does in every step: commit the bristles, predict the end of the step, apply the friction.

MuJoCo calls it when positions and velocities of a step are known and its forces are not.  All smooth forces of the step
are then computed, so the friction answers to this very step; what only the constraint solver knows (contacts, limits,
equalities) is taken as it was in the step before, found as the part of the last velocity change that was not
predicted.  The bristles move by the velocity that really came out, when the next step begins.
"""

from __future__ import annotations

import math

import numpy as np
from numba import carray

from mjfriction.laws.ambient import LOAD, POSITION, PRESSURE_HEAD, PRESSURE_ROD, ROOM_TEMPERATURE, TEMPERATURE
from mjfriction.laws.law import Floats, kernel
from mjfriction.sim import block as at
from mjfriction.sim.balance import balance
from mjfriction.sim.layout import Field
from mjfriction.sim.native import (
    apply_force,
    free_stack,
    fwd_actuation,
    mark_stack,
    offset_of,
    pointed,
    stack_numbers,
    warning,
    word_at,
)
from mjfriction.sim.rub import rub
from mjfriction.sim.solve import eliminate, restore

EULER, RUNGE_KUTTA = 0, 1
NO_EULER_DAMPING = 1 << 15  # mjDSBL_EULERDAMP, checked against MuJoCo by a test
NO_DAMPER = 1 << 6  # mjDSBL_DAMPER
AFFINE = 1  # mjBIAS_AFFINE
BIAS_SIZE = 10  # numbers a row of actuator_biasprm has
BAD_FORCE = 7  # mjWARN_BADCTRL: what the applied torque would have spoilt

F_NNUMERIC, F_TIMESTEP, F_INTEGRATOR, F_DISABLE = (
    int(Field.NNUMERIC),
    int(Field.TIMESTEP),
    int(Field.INTEGRATOR),
    int(Field.DISABLEFLAGS),
)
F_TIME, F_NUMERIC_ADR, F_NUMERIC_DATA = int(Field.TIME), int(Field.NUMERIC_ADR), int(Field.NUMERIC_DATA)
F_ROWNNZ, F_ROWADR, F_COLIND = int(Field.M_ROWNNZ), int(Field.M_ROWADR), int(Field.M_COLIND)
F_DAMPING, F_ARMATURE = int(Field.DOF_DAMPING), int(Field.DOF_ARMATURE)
F_BIASTYPE, F_BIASPRM = int(Field.ACTUATOR_BIASTYPE), int(Field.ACTUATOR_BIASPRM)
F_QPOS, F_QVEL, F_USERDATA, F_M = int(Field.QPOS), int(Field.QVEL), int(Field.USERDATA), int(Field.M)
F_PASSIVE, F_BIAS, F_APPLIED = int(Field.QFRC_PASSIVE), int(Field.QFRC_BIAS), int(Field.QFRC_APPLIED)
F_XFRC, F_ACTUATOR, F_XIPOS = int(Field.XFRC_APPLIED), int(Field.QFRC_ACTUATOR), int(Field.XIPOS)
F_MOMENT_ROWNNZ, F_MOMENT_ROWADR = int(Field.MOMENT_ROWNNZ), int(Field.MOMENT_ROWADR)
F_MOMENT_COLIND, F_MOMENT = int(Field.MOMENT_COLIND), int(Field.ACTUATOR_MOMENT)


@kernel
def numbers(struct: int, field: int, count: int) -> Floats:
    """Return a float64 array field of a struct as a view, (count,)."""
    return carray(pointed(word_at(struct + offset_of(field))), (count,), np.float64)


@kernel
def integers(struct: int, field: int, count: int) -> Floats:
    """Return an int32 array field of a struct as a view, (count,)."""
    return carray(pointed(word_at(struct + offset_of(field))), (count,), np.int32)


@kernel
def scalar(struct: int, field: int) -> float:
    """Return a float64 that stands in the struct itself."""
    return float(carray(pointed(struct + offset_of(field)), (1,), np.float64)[0])


@kernel
def flag(struct: int, field: int) -> int:
    """Return an int32 that stands in the struct itself."""
    return int(carray(pointed(struct + offset_of(field)), (1,), np.int32)[0])


@kernel
def find_block(model: int) -> int:
    """Return the address of the model's friction block, 0 where it has none."""
    count = word_at(model + offset_of(F_NNUMERIC))
    if count == 0:
        return 0
    places = integers(model, F_NUMERIC_ADR, count)
    start = word_at(model + offset_of(F_NUMERIC_DATA))
    for i in range(count):
        where = start + 8 * int(places[i])
        if carray(pointed(where), (1,), np.float64)[0] == at.MAGIC:
            return int(where)
    return 0


@kernel
def gather_inertia(model: int, data: int, dofs: Floats, local: Floats, a: Floats) -> None:
    """Write the inertia of the touched dofs into the lower triangle of ``a`` (n, n)."""
    nv = local.shape[0]
    count, begin = integers(model, F_ROWNNZ, nv), integers(model, F_ROWADR, nv)
    last = begin[nv - 1] + count[nv - 1]
    column, inertia = integers(model, F_COLIND, last), numbers(data, F_M, last)
    n = dofs.shape[0]
    for p in range(n):
        for q in range(p + 1):
            a[p, q] = 0.0
    for p in range(n):
        dof = int(dofs[p])
        for e in range(begin[dof], begin[dof] + count[dof]):
            q = int(local[column[e]])
            if p >= q:
                a[p, q] = inertia[e]
            else:
                a[q, p] = inertia[e]


@kernel
def add_implicit_damping(
    model: int, data: int, h: float, actuators: int, dofs: Floats, local: Floats, a: Floats
) -> None:
    """Add to ``a`` what the integrator treats implicitly, so that the prediction lands where MuJoCo does.

    Euler: joint damping.  The implicit family: also the velocity gain of actuators that drive a single joint.
    """
    integrator, disabled = flag(model, F_INTEGRATOR), flag(model, F_DISABLE)
    if disabled & NO_DAMPER or (integrator == EULER and disabled & NO_EULER_DAMPING):
        return
    damping = numbers(model, F_DAMPING, local.shape[0])
    for p in range(dofs.shape[0]):
        a[p, p] += h * damping[int(dofs[p])]
    if integrator == EULER or actuators == 0:
        return
    kind, gains = integers(model, F_BIASTYPE, actuators), numbers(model, F_BIASPRM, actuators * BIAS_SIZE)
    count, begin = integers(data, F_MOMENT_ROWNNZ, actuators), integers(data, F_MOMENT_ROWADR, actuators)
    last = begin[actuators - 1] + count[actuators - 1]
    column, moment = integers(data, F_MOMENT_COLIND, last), numbers(data, F_MOMENT, last)
    for i in range(actuators):
        if kind[i] == AFFINE and count[i] == 1:
            p = int(local[column[begin[i]]])
            if p >= 0:
                a[p, p] -= h * gains[BIAS_SIZE * i + 2] * moment[begin[i]] ** 2


@kernel
def add_known_forces(
    model: int, data: int, block: Floats, dofs: Floats, added: Floats, marked: Floats, full: Floats, f: Floats
) -> None:
    """Write the step's known forces on the touched dofs into ``f`` (n,); ``full`` (nv,) is room to work in.

    ``added`` and ``marked`` (k,) tell the friction of an earlier call in the same step, still in qfrc_passive when MuJoCo
    skips its velocity stage: it is taken out there first.
    """
    nv, n, k = full.shape[0], f.shape[0], added.shape[0]
    passive, bias = numbers(data, F_PASSIVE, nv), numbers(data, F_BIAS, nv)
    applied = numbers(data, F_APPLIED, nv)
    for i in range(k):
        dof = int(dofs[n - k + i])
        if passive[dof] == marked[i] and added[i] != 0.0:
            passive[dof] += added[i]
    if block[at.H_DRIVEN] > 0.0:
        fwd_actuation(model, data)
        driven = numbers(data, F_ACTUATOR, nv)
        for p in range(n):
            f[p] = driven[int(dofs[p])]
    else:
        for p in range(n):
            f[p] = 0.0
    bodies = int(block[at.H_BODIES])
    pushed = numbers(data, F_XFRC, 6 * bodies)
    outside = False
    for i in range(6, 6 * bodies):
        if pushed[i] != 0.0:
            outside = True
    for p in range(n):
        dof = int(dofs[p])
        f[p] += passive[dof] - bias[dof] + applied[dof]
    if outside:
        for i in range(nv):
            full[i] = 0.0
        pushes, points = word_at(data + offset_of(F_XFRC)), word_at(data + offset_of(F_XIPOS))
        for i in range(1, bodies):
            apply_force(model, data, pushes + 48 * i, pushes + 48 * i + 24, points + 24 * i, i, full.ctypes.data)
        for p in range(n):
            f[p] += full[int(dofs[p])]


@kernel
def symmetric(a: Floats, x: Floats, p: int) -> float:
    """Return row ``p`` of a symmetric matrix, kept in its lower triangle, times ``x``."""
    total = 0.0
    for q in range(x.shape[0]):
        total += (a[p, q] if q <= p else a[q, p]) * x[q]
    return total


@kernel
def friction_step(model: int, data: int) -> None:
    """Add the friction of this step to qfrc_passive; nothing for a model without friction."""
    address = find_block(model)
    if address == 0:
        return
    head = carray(pointed(address), (at.HEADER,), np.float64)
    n, k = int(head[at.H_TOUCHED]), int(head[at.H_RUBBING])
    nv, term_count, states = int(head[at.H_DOFS]), int(head[at.H_TERMS]), int(head[at.H_STATES])
    table = int(head[at.H_TERM_TABLE])
    rows = carray(pointed(address + 8 * table), (term_count, at.TERM_ROW), np.float64)
    end = int(rows[term_count - 1, at.T_VALUES] + rows[term_count - 1, at.T_SIZE])
    block = carray(pointed(address), (end,), np.float64)
    dofs = block[int(head[at.H_DOF_LIST]) : int(head[at.H_DOF_LIST]) + n]
    local = block[int(head[at.H_LOCAL]) : int(head[at.H_LOCAL]) + nv]
    positions = block[int(head[at.H_POSITIONS]) : int(head[at.H_POSITIONS]) + k]

    base = int(head[at.H_BASE])
    room = at.U_SCALARS + at.TOUCHED_ARRAYS * n + at.RUBBING_ARRAYS * k + states
    user = numbers(data, F_USERDATA, base + room)[base:]
    u = at.U_SCALARS
    before, predicted, unknown, moved = (
        user[u : u + n],
        user[u + n : u + 2 * n],
        user[u + 2 * n : u + 3 * n],
        user[u + 3 * n : u + 4 * n],
    )
    u += at.TOUCHED_ARRAYS * n
    torque, marked, load = user[u : u + k], user[u + k : u + 2 * k], user[u + 2 * k : u + 3 * k]
    warmth, head_pressure, rod_pressure = (
        user[u + 3 * k : u + 4 * k],
        user[u + 4 * k : u + 5 * k],
        user[u + 5 * k : u + 6 * k],
    )
    z = user[u + at.RUBBING_ARRAYS * k :]

    time, h = scalar(data, F_TIME), scalar(model, F_TIMESTEP)
    velocity = numbers(data, F_QVEL, nv)

    mark_stack(data)
    size = n * n + k * k + 2 * n + 12 * k + nv + states + 8
    work = carray(pointed(stack_numbers(data, size)), (size,), np.float64)
    a = work[: n * n].reshape((n, n))
    o = n * n
    j = work[o : o + k * k].reshape((k, k))
    o += k * k
    f, end_velocity = work[o : o + n], work[o + n : o + 2 * n]
    o += 2 * n
    v, change, trial, slope = (
        work[o : o + k],
        work[o + k : o + 2 * k],
        work[o + 2 * k : o + 3 * k],
        work[o + 3 * k : o + 4 * k],
    )
    jumps, start = work[o + 4 * k : o + 5 * k], work[o + 5 * k : o + 6 * k]
    around = work[o + 6 * k : o + 11 * k].reshape((k, 5))
    o += 12 * k
    full, z_next, near = work[o : o + nv], work[o + nv : o + nv + states], work[o + nv + states : o + nv + states + 5]

    gather_inertia(model, data, dofs, local, a)
    commits = time != user[at.U_TIME] and time == user[at.U_TIME] + user[at.U_STEP]
    if commits:
        # The inertia alone, not yet with damping, turns the part of the motion that was not predicted into a force.
        for p in range(n):
            end_velocity[p] = velocity[int(dofs[p])] - predicted[p]
            moved[p] = (velocity[int(dofs[p])] - before[p]) / user[at.U_STEP]
        for p in range(n):
            unknown[p] = symmetric(a, end_velocity, p) / user[at.U_STEP]
    elif time != user[at.U_TIME]:
        for p in range(n):
            unknown[p] = moved[p] = 0.0

    if head[at.H_LOAD] > 0.0:
        bias, armature = numbers(data, F_BIAS, nv), numbers(model, F_ARMATURE, nv)
        for i in range(k):
            p = n - k + i
            dof = int(dofs[p])
            load[i] = bias[dof] + symmetric(a, moved, p) - armature[dof] * moved[p] - unknown[p]
    place = numbers(data, F_QPOS, int(np.max(positions)) + 1)
    for i in range(k):
        p = n - k + i
        around[i, LOAD] = load[i]
        around[i, POSITION] = place[int(positions[i])]
        around[i, TEMPERATURE] = ROOM_TEMPERATURE + warmth[i]
        around[i, PRESSURE_HEAD] = head_pressure[i]
        around[i, PRESSURE_ROD] = rod_pressure[i]
        start[i] = velocity[int(dofs[p])]
        v[i] = start[i]
        jumps[i] = 0.0
    for t in range(term_count):
        if rows[t, at.T_JUMPS] > 0.0:
            jumps[int(rows[t, at.T_RUBBING])] = 1.0
    if commits:
        rub(block, rows, start, around, z, user[at.U_STEP], z_next, near, trial, slope)
        for i in range(states):
            z[i] = z_next[i]
    user[at.U_TIME], user[at.U_STEP] = time, h

    add_known_forces(model, data, block, dofs, torque, marked, full, f)
    add_implicit_damping(model, data, h, int(head[at.H_ACTUATORS]), dofs, local, a)
    for p in range(n):
        f[p] = h * (f[p] + unknown[p])
    first = n - k
    eliminate(a, f, first)
    s, b = a[first:, first:], f[first:]
    rounds = balance(s, b, start, block, rows, jumps, around, z, h, v, change, j, trial, slope, z_next, near)
    user[at.U_ROUNDS] = rounds
    for i in range(k):
        change[i] = v[i] - start[i]
    passive = numbers(data, F_PASSIVE, nv)
    for i in range(k):
        dof = int(dofs[first + i])
        # The balance itself, not the law once more: MuJoCo then lands on v to rounding.
        force = (b[i] - symmetric(s, change, i)) / h if rounds > 0 else trial[i]
        if not math.isfinite(force):
            user[at.U_FAILED] = i + 1
            warning(data, BAD_FORCE, i)
            force = 0.0
        torque[i] = force
        passive[dof] -= force
        marked[i] = passive[dof]
        end_velocity[first + i] = change[i]
    restore(a, f, end_velocity, first)
    for p in range(n):
        before[p] = velocity[int(dofs[p])]
        predicted[p] = before[p] + end_velocity[p]
    free_stack(data)
