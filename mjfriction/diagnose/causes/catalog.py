"""The causes that compete, by name."""

from __future__ import annotations

from mjfriction.diagnose.causes.asymmetry import Asymmetry
from mjfriction.diagnose.causes.cause import Cause
from mjfriction.diagnose.causes.coulomb_viscous import CoulombViscous
from mjfriction.diagnose.causes.offset import Offset
from mjfriction.diagnose.causes.rotor_inertia import RotorInertia
from mjfriction.diagnose.causes.stribeck import Stribeck
from mjfriction.diagnose.causes.torque_constant import TorqueConstant
from mjfriction.diagnose.causes.viscous_nonlinear import ViscousNonlinear

STATED_LEVELS = CoulombViscous()

STRUCTURAL: tuple[Cause, ...] = (
    Stribeck(),
    ViscousNonlinear(),
    Asymmetry(),
    Offset(),
    RotorInertia(),
    TorqueConstant(),
)

CAUSES: dict[str, Cause] = {cause.name: cause for cause in (STATED_LEVELS, *STRUCTURAL)}
