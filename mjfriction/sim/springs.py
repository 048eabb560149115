"""Springs along a joint's stroke in MuJoCo's own elements."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import mujoco
import numpy as np
from numpy.polynomial import Polynomial

from mjfriction.laws.law import Floats

REAL = 1e-9  # a root counts as real where its imaginary part is at most this fraction of its size
SLIGHT = 1e-5  # of a torque that is the same everywhere, what it changes by from the zero to the end of the stroke
NEAR = 2.0  # multiple of a joint's reach within which its spring is written about its rest
UNLIMITED = 2.0 * np.pi  # rad or m, how far a joint without limits is taken to go


def add_springs(spec: mujoco.MjSpec, springs: Mapping[str, Sequence[float] | Floats]) -> None:
    """Add springs to joints: torques that the drive works against, each a cubic in position, in place.

    ``springs`` gives the coefficients by joint, (4,), the constant first, in N·m or N over powers of rad or m.  Springs
    in MuJoCo have no constant term, so each cubic is rewritten about a position where its torque is zero.  For one that
    pushes one way all along the stroke (a constant, say), a tendon ``spring_<joint>``, stretched from so far away that
    its pull changes by ``SLIGHT`` at most, adds the constant to what the joint's own spring is about zero.
    """
    for name, added in springs.items():
        if not np.any(added):
            continue
        joint = spec.joint(name)
        in_degrees = spec.compiler.degree and joint.type == mujoco.mjtJoint.mjJNT_HINGE
        unit = 180.0 / np.pi if in_degrees else 1.0
        displacement = Polynomial([-float(joint.springref) / unit, 1.0])
        torque = Polynomial([0.0, *joint.stiffness])(displacement) + Polynomial(added)
        reach = _reach(joint, unit)
        rest = _rest(torque, reach)
        if rest is None:
            rest = 0.0
            _pull(spec, joint, float(torque(0.0)), reach)
        joint.springref = unit * rest
        about_rest = torque(Polynomial([rest, 1.0])).coef[1:]
        joint.stiffness = np.pad(about_rest, (0, joint.stiffness.size - about_rest.size))


def _rest(torque: Polynomial, reach: float) -> float | None:
    # Where the joint rests. Written about a place far outside the stroke, a bent spring's terms cancel, and an XML file
    # has too few digits of them.
    if torque(0.0) == 0.0:
        return 0.0
    roots = torque.trim().roots()
    real = roots[np.abs(roots.imag) <= REAL * np.abs(roots)].real
    nearest = min(np.abs(real), default=np.inf)
    return float(real[np.argmin(np.abs(real))]) if nearest <= NEAR * reach else None


def _pull(spec: mujoco.MjSpec, joint: mujoco.MjsJoint, torque: float, reach: float) -> None:
    # A torque that the drive works against wherever the joint is.
    tendon = spec.add_tendon(name=f"spring_{joint.name}")
    tendon.wrap_joint(joint.name, 1.0)
    stiffness = SLIGHT * abs(torque) / reach
    tendon.stiffness[0] = stiffness
    tendon.springlength = [-torque / stiffness] * 2


def _reach(joint: mujoco.MjsJoint, unit: float) -> float:
    # How far a joint goes from its zero, rad or m.
    limited = joint.range[0] < joint.range[1]
    return float(np.max(np.abs(joint.range))) / unit if limited else UNLIMITED
