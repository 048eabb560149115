"""Regressors: joint torques as linear functions of a tip mass, the links' inertial parameters, and gravity."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pinocchio as pin

from mjfriction.body.inverse import inverse_dynamics
from mjfriction.body.model import Body, configuration, in_model_order
from mjfriction.laws.law import Floats

LOWER = np.tril_indices(3)  # Ixx, Ixy, Iyy, Ixz, Iyz, Izz, in Pinocchio's order
SHIFT = 1e-4  # m, step of the difference quotient by a centre of mass
CHUNK = 512  # samples whose regressors are in memory at once


def tip_link(body: Body) -> str:
    """Return the name of the link that the last joint of the tree moves: where an arm holds its payload."""
    last = body.model.njoints - 1
    names = [frame.name for frame in body.model.frames if frame.type == pin.BODY and frame.parentJoint == last]
    return str(names[0]) if names else str(body.model.names[last])


def tip_mass(body: Body) -> tuple[float, Floats]:
    """Return the mass that the last joint moves, kg, and its centre (3,) in the tip link's frame, m."""
    frame = body.model.frames[body.model.getFrameId(tip_link(body), pin.FrameType.BODY)]
    inertia = body.model.inertias[frame.parentJoint]
    return float(inertia.mass), np.asarray(frame.placement.actInv(inertia.lever))


def tip_mass_torques(
    body: Body, position: Floats, velocity: Floats, acceleration: Floats, *, about: Floats | None = None
) -> Floats:
    """Return joint torques per kg and per kg·m of first moment (x, y, z) at the tip link's frame.

    The result has shape (n, joints, 4).  The torque of a point mass m with its centre at c is this times (m, m·c), up
    to its moment of inertia about c₀, by default the centre of the tip link's own mass, else ``about`` (3,), which is
    of second order in c − c₀.  The error comes from linearising the second moment about the joint: near x₀,
    m·x·xᵀ = w·wᵀ/m with w = m·x is −m·x₀·x₀ᵀ + x₀·wᵀ + w·x₀ᵀ.
    """
    frame = body.model.frames[body.model.getFrameId(tip_link(body), pin.FrameType.BODY)]
    origin, turned = frame.placement.translation, frame.placement.rotation
    near = origin + turned @ (tip_mass(body)[1] if about is None else about)
    # A mass of 1 kg at the frame's origin, and the same with a first moment of 1 kg·m along each axis.
    torques = []
    for moment in np.vstack([np.zeros(3), np.eye(3)]):
        centre = origin + turned @ moment
        second = np.outer(near, centre) + np.outer(centre, near) - np.outer(near, near)
        inertia = np.trace(second) * np.eye(3) - second
        parameters = np.concatenate([[1.0], centre, inertia[LOWER]])
        alone = _holding_nothing_but(body, frame.parentJoint, pin.Inertia.FromDynamicParameters(parameters))
        torques.append(inverse_dynamics(alone, position, velocity, acceleration))
    mass = torques[0]
    return np.stack([mass, *(own - mass for own in torques[1:])], axis=2)


def _holding_nothing_but(body: Body, joint: int, inertia: pin.Inertia) -> Body:
    alone = body.weightless()
    alone.model.inertias[joint] = inertia
    return alone


def link_torques(body: Body, position: Floats, velocity: Floats, acceleration: Floats) -> Floats:
    """Return every link's contribution to the inverse dynamics, shape (n, joints, links).

    Summed over the links it is the inverse dynamics without the rotors.  A scale on a link's mass and inertia
    multiplies its contribution.
    """
    return weighed_links(body, position, velocity, acceleration, _own_parameters(body))[:, :, :, 0]


def _own_parameters(body: Body) -> Floats:
    return np.array([inertia.toDynamicParameters() for inertia in list(body.model.inertias)[1:]])[:, :, None]


def link_change_torques(body: Body, position: Floats, velocity: Floats, acceleration: Floats) -> Floats:
    """Return joint torques of every link, (n, joints, links, 1 + 3 + 1), in one pass.

    The first entry is that of :func:`link_torques`.  The next three are the changes in torque per metre of shift of
    the link's centre of mass along each axis of its frame, to first order.  The shift also changes the inertia about
    the frame.  The last is the share of the link's moments of inertia about its own centre: a factor on them alone
    multiplies it.
    """
    parts = [_own_parameters(body), _moment_tangents(body), _own_moments(body)]
    weight = np.concatenate(parts, axis=2)
    return weighed_links(body, position, velocity, acceleration, weight)


def _own_moments(body: Body) -> Floats:
    parameters = np.zeros((body.model.njoints - 1, 10, 1))
    for k, inertia in enumerate(list(body.model.inertias)[1:]):
        parameters[k, 4:, 0] = inertia.inertia[LOWER]
    return parameters


def _moment_tangents(body: Body) -> Floats:
    inertias = list(body.model.inertias)[1:]
    # Derivatives of the parameters (m, m·c, I about the frame) by c, with the inertia about the centre held constant.
    tangents = []
    for inertia in inertias:
        whole = np.zeros((10, 3))
        for axis in range(3):
            ends = []
            for side in (1.0, -1.0):
                moved = inertia.lever + side * SHIFT * np.eye(3)[axis]
                ends.append(pin.Inertia(inertia.mass, moved, inertia.inertia).toDynamicParameters())
            whole[:, axis] = (ends[0] - ends[1]) / (2.0 * SHIFT)
        tangents.append(whole)
    return np.stack(tangents)


def weighed_links(body: Body, position: Floats, velocity: Floats, acceleration: Floats, weight: Floats) -> Floats:
    """Return every link's torque regressor times ``weight`` (links, 10, k): (n, joints, links, k)."""
    model, data = body.model, body.model.createData()
    links = weight.shape[0]
    q = configuration(body, position)
    v, a = in_model_order(body, velocity), in_model_order(body, acceleration)
    out = np.empty((q.shape[0], model.nv, links, weight.shape[2]))
    regressors = np.empty((CHUNK, model.nv, 10 * links))
    for start in range(0, q.shape[0], CHUNK):
        stop = min(start + CHUNK, q.shape[0])
        for i in range(start, stop):
            regressors[i - start] = pin.computeJointTorqueRegressor(model, data, q[i], v[i], a[i])
        # Put the link axis first, so that each link takes one matrix product.
        parts = regressors[: stop - start].reshape(-1, links, 10).transpose(1, 0, 2) @ weight
        out[start:stop] = parts.transpose(1, 0, 2).reshape(stop - start, model.nv, links, -1)
    return out[:, list(body.columns)]


def gravity_torques(body: Body, position: Floats, directions: Floats) -> Floats:
    """Return joint torques per m/s² of gravity along each of ``directions`` (k, 3), shape (n, joints, k)."""
    still = np.zeros_like(position)
    torques = []
    for direction in directions:
        model = body.model.copy()
        model.gravity.linear = direction
        torques.append(inverse_dynamics(replace(body, model=model), position, still, still))
    return np.stack(torques, axis=2)
