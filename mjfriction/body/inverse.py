"""Inverse dynamics: the torque that a motion needs, its derivatives, and the mass matrix."""

from __future__ import annotations

import numpy as np
import pinocchio as pin

from mjfriction.body.model import Body, configuration, in_model_order
from mjfriction.laws.law import Floats


def inverse_dynamics(body: Body, position: Floats, velocity: Floats, acceleration: Floats) -> Floats:
    """Return M(q)q̈ + c(q, q̇) + g(q), rotor inertia included, by the recursive Newton-Euler algorithm.

    All arguments and the result have shape (n, joints), in the order of ``body.joints``.
    """
    model = body.model
    q = configuration(body, position)
    v, a = in_model_order(body, velocity), in_model_order(body, acceleration)
    out = np.empty((model.nv, q.shape[0]), order="F")
    if q.size:
        pin.rneaInParallel(1, pin.ModelPool(model, 1), q.T, v.T, a.T, out)
    return out.T[:, list(body.columns)]


def motion_derivatives(body: Body, position: Floats, velocity: Floats, acceleration: Floats) -> tuple[Floats, ...]:
    """Return the derivatives of the links' torques by position, velocity and acceleration, each (n, joints, joints).

    Entry (t, i, k) is the derivative of joint i's torque with respect to joint k.  Rotors are left out.  In memory, the
    time course of each entry is contiguous.
    """
    model, data = body.model, body.model.createData()
    q = configuration(body, position)
    v, a = in_model_order(body, velocity), in_model_order(body, acceleration)
    out = np.empty((3, q.shape[0], model.nv, model.nv))
    for i in range(q.shape[0]):
        pin.computeRNEADerivatives(model, data, q[i], v[i], a[i])
        out[0, i], out[1, i], out[2, i] = data.dtau_dq, data.dtau_dv, data.M
    out[2] -= np.diag(np.array(model.armature))
    order = np.array(body.columns)
    courses = np.ascontiguousarray(np.moveaxis(out, 1, -1)[:, order[:, None], order])
    return tuple(np.moveaxis(courses, -1, 1))


def inertia_along(body: Body, position: Floats) -> Floats:
    """Return the mass matrix's diagonal without rotors along a motion, (n, joints): the links' inertia per joint."""
    model, data = body.model, body.model.createData()
    q = configuration(body, position)
    out = np.empty((q.shape[0], model.nv))
    for i in range(q.shape[0]):
        out[i] = pin.crba(model, data, q[i]).diagonal()
    return np.asarray((out - np.array(model.armature))[:, list(body.columns)])


def mass_matrix_at(body: Body, position: Floats) -> Floats:
    """Return the mass matrix at one pose, shape (joints, joints): kg·m², or kg on sliding joints."""
    model, data = body.model, body.model.createData()
    upper = np.triu(pin.crba(model, data, configuration(body, position[None, :])[0]))
    own = np.ix_(body.columns, body.columns)
    return np.asarray((upper + np.triu(upper, 1).T)[own])


def inertia_at(body: Body, position: Floats) -> Floats:
    """Return the diagonal of the mass matrix at one pose, shape (joints,): kg·m², or kg on sliding joints."""
    return np.diag(mass_matrix_at(body, position)).copy()
