"""All friction of a model at trial velocities: the terms of every joint, added up."""

from __future__ import annotations

from mjfriction.laws.law import Floats, kernel
from mjfriction.laws.wrapped import advance_wrapped
from mjfriction.sim.block import T_RUBBING, T_SIZE, T_STATE, T_STATES, T_VALUES


@kernel
def rub(
    block: Floats, terms: Floats, v: Floats, around: Floats, z: Floats, h: float, z_next: Floats, near: Floats,
    torque: Floats, slope: Floats,
) -> None:  # fmt: skip
    """Write torque and slope (k,) of the rubbing joints at velocities ``v`` (k,), and the states then.

    ``block`` is the model's block, ``terms`` (terms, 6) its term table, ``around`` (k, 5) what surrounds the joints.
    """
    for i in range(v.shape[0]):
        torque[i] = 0.0
        slope[i] = 0.0
    for t in range(terms.shape[0]):
        i, state, states = int(terms[t, T_RUBBING]), int(terms[t, T_STATE]), int(terms[t, T_STATES])
        values = int(terms[t, T_VALUES])
        own, steepness = advance_wrapped(
            v[i],
            around[i],
            z[state : state + states],
            h,
            block[values : values + int(terms[t, T_SIZE])],
            z_next[state : state + states],
            near,
        )
        torque[i] += own
        slope[i] += steepness


@kernel
def rub_one(
    block: Floats,
    terms: Floats,
    which: int,
    v: float,
    around: Floats,
    z: Floats,
    h: float,
    z_next: Floats,
    near: Floats,
) -> float:
    """Return the torque of one rubbing joint at velocity ``v``."""
    torque = 0.0
    for t in range(terms.shape[0]):
        if int(terms[t, T_RUBBING]) == which:
            state, states, values = int(terms[t, T_STATE]), int(terms[t, T_STATES]), int(terms[t, T_VALUES])
            own, _ = advance_wrapped(
                v,
                around[which],
                z[state : state + states],
                h,
                block[values : values + int(terms[t, T_SIZE])],
                z_next[state : state + states],
                near,
            )
            torque += own
    return torque
