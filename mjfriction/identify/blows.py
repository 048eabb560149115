"""Blows: a link that lands at the end of its play, say.

For some milliseconds rotor and link exchange what neither the drive feels nor the position's filter can time, and
whatever shifts effort against motion seems to mend that.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import maximum_filter1d
from scipy.signal import sosfiltfilt

from mjfriction.body.inverse import motion_derivatives
from mjfriction.body.model import Body
from mjfriction.identify.rows import Chain
from mjfriction.record.log import Floats
from mjfriction.record.low_pass import butterworth
from mjfriction.record.motion import Motion

BLOW_BAND = 0.2  # of the position filter's cutoff: what is slower is motion
BLOW = 15.0  # times the usual, a quick acceleration that is a blow
REVERSAL = 4.0  # periods of the position filter's cutoff that a reversal of friction shakes a joint
TOUCHED = 0.02  # of a row's window that a blow may take


def blows(body: Body, motion: Motion, chain: Chain, doubt_speed: Floats) -> tuple[Floats, NDArray[np.bool_]]:
    """Return what blows may add to the rows, N·m or N, and which rows of a joint hold one of its own, (rows, joints).

    A blow is an acceleration of a joint that is :data:`BLOW` times as quick as usual and larger than the motion around
    it, while the joint moves: at a reversal friction itself is as quick.  All joints feel it, |M(q)|·|q̈|, as the
    inertia couples them.  ``doubt_speed`` (joints,) is the speed below which a joint rests.
    """
    quick = quick_accelerations(motion, doubt_speed)
    at = np.flatnonzero(np.any(quick != 0.0, axis=1))
    felt = np.zeros_like(quick)
    if at.size:
        inertia = motion_derivatives(body, motion.position[at], motion.velocity[at], motion.acceleration[at])[2]
        felt[at] = np.einsum("nij,nj->ni", np.abs(inertia), np.abs(quick[at]))
    own = np.column_stack([chain.touched(column != 0.0) > TOUCHED for column in quick.T])
    return np.column_stack([chain.averaged(column) for column in felt.T]), own


def quick_accelerations(motion: Motion, doubt_speed: Floats) -> Floats:
    """Return the acceleration of each joint's own blows, (n, joints), 0 elsewhere.

    ``doubt_speed`` (joints,) is the speed below which a joint rests.
    """
    return np.column_stack([_blows_of(motion, joint, slow) for joint, slow in enumerate(doubt_speed)])


def _blows_of(motion: Motion, joint: int, still: float) -> Floats:
    # The acceleration of a joint's blows, (n,), 0 elsewhere.
    slow = butterworth(2, BLOW_BAND * motion.cutoff, motion.rate)
    course, velocity = motion.acceleration[:, joint], motion.velocity[:, joint]
    wanted = np.concatenate([sosfiltfilt(slow.sections, course[own]) for own in motion.pieces])
    quick = course - wanted
    moving = np.abs(velocity) > still
    if not np.any(moving):
        return np.zeros_like(quick)
    # Where a motion begins to speed up, half of what it comes to is quick: a blow is more than the motion around it.
    around = maximum_filter1d(np.abs(wanted), 2 * int(motion.rate / (BLOW_BAND * motion.cutoff)) + 1)
    blow = moving & (np.abs(quick) > np.maximum(around, BLOW * np.median(np.abs(quick[moving]))))
    turns = np.flatnonzero(np.diff(np.sign(velocity)) != 0)
    reach = int(np.ceil(REVERSAL * motion.rate / motion.cutoff))
    for shift in range(-reach, reach + 1):
        blow[np.clip(turns + shift, 0, blow.size - 1)] = False
    return np.where(blow, quick, 0.0)
