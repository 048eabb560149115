"""How a model carries its friction: a block of numbers in the model, and a block in the simulation's user data.

The model's block is a custom numeric named ``mjfriction``; copies of the model, files and ``Batch.expand`` carry it.
Its header and the arrays behind it are laid out below, as are the simulation's arrays.
"""

from __future__ import annotations

MAGIC = 61221.5  # begins the block; exact in binary and in the six digits of a saved XML
VERSION = 3.0
NUMERIC_NAME = "mjfriction"

# Header of the model's block.
(
    H_MAGIC,
    H_VERSION,
    H_BASE,  # where the simulation's block begins in mjData.userdata
    H_DOFS,  # nv
    H_PLACES,  # nq
    H_BODIES,  # nbody
    H_TOUCHED,  # n: dofs of the kinematic trees that carry friction, the ones without friction first
    H_RUBBING,  # k: dofs with friction, the last k of the touched
    H_TERMS,
    H_STATES,
    H_LOAD,  # 1 where a law reads the load
    H_ACTUATORS,  # number of actuators with one output each, 0 where some have more
    H_DRIVEN,  # 1 where the model has actuators
    H_FORESEEN,  # 1 where only constraints can make a step end on other velocities than predicted
    H_DOF_LIST,  # offsets of the arrays that follow, counted from the block's beginning:
    H_LOCAL,  # place among the touched of every dof, −1 elsewhere
    H_POSITIONS,  # address in qpos of every rubbing dof
    H_TERM_TABLE,
    HEADER,
) = range(19)

# A row of the term table.
T_RUBBING, T_STATE, T_STATES, T_VALUES, T_SIZE, TERM_ROW = range(6)

# The simulation's block: scalars, then arrays over the touched (n) and the rubbing (k) dofs, then the
# states as they are and as they were predicted for the end of the step.
# U_FREE is 1 where the last call saw no active constraint.
U_TIME, U_STEP, U_FAILED, U_ROUNDS, U_FREE, U_SCALARS = range(6)
TOUCHED_ARRAYS = 4  # velocity at the last call, velocity predicted then, force not predicted, acceleration
RUBBING_ARRAYS = 6  # torque, qfrc_passive as left behind, load, temperature above room, head pressure, rod pressure


def room_needed(touched: int, rubbing: int, states: int) -> int:
    """Return how many numbers of user data the simulation's block takes."""
    return U_SCALARS + TOUCHED_ARRAYS * touched + RUBBING_ARRAYS * rubbing + 2 * states
