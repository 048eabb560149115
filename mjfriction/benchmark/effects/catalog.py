"""All hidden effects.  Seeds draw by index in this list, so new ones must be appended at its end."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from mjfriction.benchmark.effects.body import gravity_direction, link_inertia, payload, spring
from mjfriction.benchmark.effects.drive import (
    backlash,
    cogging,
    coupling,
    delay,
    elasticity,
    encoder_offset,
    offset,
    rotor_inertia,
    torque_constant,
)
from mjfriction.benchmark.effects.effect import Effect, Place
from mjfriction.benchmark.effects.friction import (
    asymmetry,
    coulomb_viscous,
    load,
    position,
    presliding,
    pressure,
    step,
    stribeck,
    temperature,
    viscous_nonlinear,
)

Draw = Callable[[np.random.Generator, Place], Effect]

EFFECTS: tuple[Draw, ...] = (
    coulomb_viscous,
    stribeck,
    viscous_nonlinear,
    asymmetry,
    load,
    presliding,
    position,
    temperature,
    cogging,
    torque_constant,
    offset,
    backlash,
    elasticity,
    rotor_inertia,
    coupling,
    payload,
    link_inertia,
    gravity_direction,
    spring,
    delay,
    encoder_offset,
    step,
    pressure,
)
