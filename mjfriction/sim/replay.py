"""Replay of measured efforts in a model, stretch by stretch, without control that holds the joints on their path."""

from __future__ import annotations

from collections.abc import Sequence

import mujoco
import mujoco.rollout
import numpy as np

from mjfriction.laws.law import Floats
from mjfriction.sim.callback import friction_active
from mjfriction.sim.messages import messages_dropped


def replay(
    models: Sequence[mujoco.MjModel], joints: Sequence[str], position: Floats, velocity: Floats, effort: Floats
) -> Floats:
    """Run every model freely over every stretch and return the joint positions, (models, stretches, steps, joints).

    ``position`` and ``velocity`` (stretches, joints) are the initial state of each stretch; its bristles start relaxed.
    ``effort`` (models, stretches, steps, joints) acts on the joints, held constant over each step.  The first returned
    position is the initial one; the position after the last step is left out.  Controls of actuators stay at zero.
    """
    first = models[0]
    places = np.array([first.jnt_qposadr[first.joint(name).id] for name in joints])
    dofs = np.array([first.jnt_dofadr[first.joint(name).id] for name in joints])
    count, stretches, steps, _ = effort.shape
    data = mujoco.MjData(first)
    kind = mujoco.mjtState.mjSTATE_FULLPHYSICS
    initial = np.empty((stretches, mujoco.mj_stateSize(first, kind)))
    force = np.zeros((count * stretches, steps, first.nv))
    force[:, :, dofs] = effort.reshape(count * stretches, steps, -1)
    for k in range(stretches):
        mujoco.mj_resetData(first, data)
        data.qpos[places], data.qvel[dofs] = position[k], velocity[k]
        mujoco.mj_getState(first, data, initial[k], kind)
    every = [model for model in models for _ in range(stretches)]
    for model in models:  # with auto-reset, a run that diverged would restart from its initial state and look sound
        model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_AUTORESET
    with friction_active(), messages_dropped():
        states, _ = mujoco.rollout.rollout(
            every,
            [mujoco.MjData(first) for _ in range(2)],
            np.tile(initial, (count, 1)),
            force,
            control_spec=int(mujoco.mjtState.mjSTATE_QFRC_APPLIED),
        )
    # A full state begins with the time; a rollout gives the state after each step.
    moved = states[:, :-1, 1 + places].reshape(count, stretches, steps - 1, len(places))
    begin = np.broadcast_to(position[None, :, None, :], (count, stretches, 1, len(places)))
    return np.concatenate([begin, moved], axis=2)
