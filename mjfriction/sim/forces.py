"""Inputs of the step other than friction: inertia, the integrator's implicit damping, and all other forces."""

from __future__ import annotations

from mjfriction.laws.law import Floats, kernel
from mjfriction.laws.window import address
from mjfriction.sim import memory as mem
from mjfriction.sim.memory import Block, Kept, flag, integers, numbers
from mjfriction.sim.native import apply_force, fwd_actuation, offset_of, word_at

EULER = 0
NO_EULER_DAMPING = 1 << 15  # mjDSBL_EULERDAMP, checked against MuJoCo by a test
NO_DAMPER = 1 << 6  # mjDSBL_DAMPER
AFFINE = 1  # mjBIAS_AFFINE
BIAS_SIZE = 10  # numbers in a row of actuator_biasprm


@kernel
def gather_inertia(model: int, data: int, dofs: Floats, local: Floats, a: Floats) -> None:
    """Write the inertia of the touched dofs into the lower triangle of ``a`` (n, n)."""
    nv = local.shape[0]
    count, begin = integers(model, mem.F_ROWNNZ, nv), integers(model, mem.F_ROWADR, nv)
    last = begin[nv - 1] + count[nv - 1]
    column, inertia = integers(model, mem.F_COLIND, last), numbers(data, mem.F_M, last)
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
    """Add to ``a`` the terms that the integrator treats implicitly, so that the prediction agrees with MuJoCo.

    Euler: joint damping.  Implicit integrators: also the velocity gain of actuators that drive a single joint.
    """
    integrator, disabled = flag(model, mem.F_INTEGRATOR), flag(model, mem.F_DISABLE)
    if disabled & NO_DAMPER or (integrator == EULER and disabled & NO_EULER_DAMPING):
        return
    damping = numbers(model, mem.F_DAMPING, local.shape[0])
    for p in range(dofs.shape[0]):
        a[p, p] += h * damping[int(dofs[p])]
    if integrator == EULER or actuators == 0:
        return
    kind, gains = integers(model, mem.F_BIASTYPE, actuators), numbers(model, mem.F_BIASPRM, actuators * BIAS_SIZE)
    count, begin = integers(data, mem.F_MOMENT_ROWNNZ, actuators), integers(data, mem.F_MOMENT_ROWADR, actuators)
    last = begin[actuators - 1] + count[actuators - 1]
    column, moment = integers(data, mem.F_MOMENT_COLIND, last), numbers(data, mem.F_MOMENT, last)
    for i in range(actuators):
        if kind[i] == AFFINE and count[i] == 1:
            p = int(local[column[begin[i]]])
            if p >= 0:
                a[p, p] -= h * gains[BIAS_SIZE * i + 2] * moment[begin[i]] ** 2


@kernel
def add_known_forces(model: int, data: int, block: Block, kept: Kept, full: Floats, f: Floats) -> None:
    """Write the step's known forces on the touched dofs into ``f`` (n,); ``full`` (nv,) is work space.

    Where MuJoCo skips its velocity stage, qfrc_passive still contains the friction of an earlier call in the same step.
    It is removed first.
    """
    nv, n, k = block.nv, block.touched, block.rubbing
    passive, bias, applied = (
        numbers(data, mem.F_PASSIVE, nv),
        numbers(data, mem.F_BIAS, nv),
        numbers(data, mem.F_APPLIED, nv),
    )
    for i in range(k):
        dof = int(block.dofs[n - k + i])
        if passive[dof] == kept.marked[i] and kept.torque[i] != 0.0:
            passive[dof] += kept.torque[i]
    for p in range(n):
        dof = int(block.dofs[p])
        f[p] = passive[dof] - bias[dof] + applied[dof]
    if block.driven:
        fwd_actuation(model, data)
        driven = numbers(data, mem.F_ACTUATOR, nv)
        for p in range(n):
            f[p] += driven[int(block.dofs[p])]
    if any_push(data, block.bodies):
        add_pushes(model, data, block, full, f)


@kernel
def any_push(data: int, bodies: int) -> bool:
    """Return whether an external force acts on any body."""
    pushes = numbers(data, mem.F_XFRC, 6 * bodies)
    found = False
    for i in range(6, 6 * bodies):
        found |= pushes[i] != 0.0
    return found


@kernel
def add_pushes(model: int, data: int, block: Block, full: Floats, f: Floats) -> None:
    """Add the external forces (xfrc_applied) to ``f`` (n,)."""
    for i in range(block.nv):
        full[i] = 0.0
    pushes, points = word_at(data + offset_of(mem.F_XFRC)), word_at(data + offset_of(mem.F_XIPOS))
    for i in range(1, block.bodies):
        apply_force(model, data, pushes + 48 * i, pushes + 48 * i + 24, points + 24 * i, i, address(full, 0))
    for p in range(block.touched):
        f[p] += full[int(block.dofs[p])]


@kernel
def symmetric(a: Floats, x: Floats, p: int) -> float:
    """Return row ``p`` of a symmetric matrix, stored in its lower triangle, times ``x``."""
    total = 0.0
    for q in range(x.shape[0]):
        total += (a[p, q] if q <= p else a[q, p]) * x[q]
    return total
