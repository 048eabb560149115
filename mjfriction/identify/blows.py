"""Blows: impacts such as that of a link that lands at the end of its play.

For some milliseconds, rotor and link exchange forces that the drive does not feel and the position filter cannot time.
Anything that shifts effort against motion then seems to improve the fit.
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

BLOW_BAND = 0.2  # of the position filter's cutoff; slower acceleration is part of the motion
BLOW = 15.0  # times the median of the quick accelerations, above which one is a blow
REVERSAL = 4.0  # periods of the position filter's cutoff for which a reversal of friction shakes a joint
TOUCHED = 0.02  # share of a row's window that a blow may take before the row counts as holding it


def blows(body: Body, motion: Motion, chain: Chain, doubt_speed: Floats) -> tuple[Floats, NDArray[np.bool_]]:
    """Return what blows may add to the rows, N·m or N, and which rows of a joint hold one of its own, (rows, joints).

    A blow is an acceleration of a joint that is :data:`BLOW` times as large as its usual quick accelerations and larger
    than the motion around it, while the joint moves.  Reversals are left out, because there friction itself is as
    quick.  All joints feel a blow through the coupling of the inertia, as |M(q)|·|q̈|.  ``doubt_speed`` (joints,) is
    the speed below which a joint rests.
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
    """Return the acceleration during each joint's own blows, (n, joints), 0 elsewhere.

    ``doubt_speed`` (joints,) is the speed below which a joint rests.
    """
    return np.column_stack([_blows_of(motion, joint, slow) for joint, slow in enumerate(doubt_speed)])


def _blows_of(motion: Motion, joint: int, still: float) -> Floats:
    # The acceleration during a joint's blows, (n,), 0 elsewhere.
    slow = butterworth(2, BLOW_BAND * motion.cutoff, motion.rate)
    course, velocity = motion.acceleration[:, joint], motion.velocity[:, joint]
    wanted = np.concatenate([sosfiltfilt(slow.sections, course[own]) for own in motion.pieces])
    quick = course - wanted
    moving = np.abs(velocity) > still
    if not np.any(moving):
        return np.zeros_like(quick)
    # Where a motion starts to speed up, half of its acceleration is quick, so a blow must exceed the motion around it.
    around = maximum_filter1d(np.abs(wanted), 2 * int(motion.rate / (BLOW_BAND * motion.cutoff)) + 1)
    blow = moving & (np.abs(quick) > np.maximum(around, BLOW * np.median(np.abs(quick[moving]))))
    turns = np.flatnonzero(np.diff(np.sign(velocity)) != 0)
    reach = int(np.ceil(REVERSAL * motion.rate / motion.cutoff))
    for shift in range(-reach, reach + 1):
        blow[np.clip(turns + shift, 0, blow.size - 1)] = False
    return np.where(blow, quick, 0.0)
