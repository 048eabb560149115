"""One compiled entry point to all laws, for code that learns only at run time which law a joint has.

A law's number is its place in :data:`mjfriction.laws.catalog.LAWS`; models store it, so it never changes.
"""

from __future__ import annotations

from mjfriction.laws import (
    arctan,
    arctan_load,
    asymmetric,
    asymmetric_curve,
    coulomb,
    coulomb_viscous,
    dahl,
    dwell_time,
    elasto_plastic,
    geared_load,
    gms,
    leuven,
    load_dependent,
    lorentzian,
    lugre,
    lugre_arctan,
    lugre_lorentzian,
    lugre_smooth,
    maxwell_slip,
    position_dependent,
    power_viscous,
    pressed_seals,
    pressure,
    quadratic_viscous,
    saturating_viscous,
    static_kinetic,
    stribeck,
    temperature_dependent,
)
from mjfriction.laws.ambient import AMBIENT_SIZE
from mjfriction.laws.law import Floats, routine
from mjfriction.laws.window import window_at


@routine
def steady_of(number: int, v: float, ambient: Floats, p: Floats) -> float:  # noqa: PLR0911, PLR0912
    """Return the steady friction of law ``number``; NaN for a number that no law has."""
    if number == 0:
        return coulomb.steady(v, ambient, p)
    if number == 1:
        return coulomb_viscous.steady(v, ambient, p)
    if number == 2:
        return static_kinetic.steady(v, ambient, p)
    if number == 3:
        return stribeck.steady(v, ambient, p)
    if number == 4:
        return lorentzian.steady(v, ambient, p)
    if number == 5:
        return quadratic_viscous.steady(v, ambient, p)
    if number == 6:
        return power_viscous.steady(v, ambient, p)
    if number == 7:
        return saturating_viscous.steady(v, ambient, p)
    if number == 8:
        return asymmetric.steady(v, ambient, p)
    if number == 9:
        return load_dependent.steady(v, ambient, p)
    if number == 10:
        return geared_load.steady(v, ambient, p)
    if number == 11:
        return temperature_dependent.steady(v, ambient, p)
    if number == 12:
        return position_dependent.steady(v, ambient, p)
    if number == 13:
        return arctan.steady(v, ambient, p)
    if number == 14:
        return arctan_load.steady(v, ambient, p)
    if number == 15:
        return pressure.steady(v, ambient, p)
    if number == 16:
        return dahl.steady(v, ambient, p)
    if number == 17:
        return lugre.steady(v, ambient, p)
    if number == 18:
        return lugre_lorentzian.steady(v, ambient, p)
    if number == 19:
        return lugre_arctan.steady(v, ambient, p)
    if number == 20:
        return lugre_smooth.steady(v, ambient, p)
    if number == 21:
        return elasto_plastic.steady(v, ambient, p)
    if number == 22:
        return maxwell_slip.steady(v, ambient, p)
    if number == 23:
        return leuven.steady(v, ambient, p)
    if number == 24:
        return gms.steady(v, ambient, p)
    if number == 25:
        return dwell_time.steady(v, ambient, p)
    if number == 26:
        return pressed_seals.steady(v, ambient, p)
    if number == 27:
        return asymmetric_curve.steady(v, ambient, p)
    return float("nan")


@routine
def advance_of(  # noqa: PLR0911, PLR0912
    number: int,
    v: float,
    ambient_at: int,
    z_at: int,
    states: int,
    h: float,
    p_at: int,
    count: int,
    z_next_at: int,
) -> tuple[float, float]:
    """Return (torque, slope) of law ``number`` and write its next state; NaN for a number that no law has.

    Arrays are passed as addresses: ``states`` numbers of state at ``z_at`` and ``z_next_at``, ``count`` parameters at
    ``p_at``.  Passing an array to a function that is not inlined costs as much as a whole step of a law.
    """
    ambient, p = window_at(ambient_at, AMBIENT_SIZE), window_at(p_at, count)
    z, z_next = window_at(z_at, states), window_at(z_next_at, states)
    if number == 0:
        return coulomb.advance(v, ambient, z, h, p, z_next)
    if number == 1:
        return coulomb_viscous.advance(v, ambient, z, h, p, z_next)
    if number == 2:
        return static_kinetic.advance(v, ambient, z, h, p, z_next)
    if number == 3:
        return stribeck.advance(v, ambient, z, h, p, z_next)
    if number == 4:
        return lorentzian.advance(v, ambient, z, h, p, z_next)
    if number == 5:
        return quadratic_viscous.advance(v, ambient, z, h, p, z_next)
    if number == 6:
        return power_viscous.advance(v, ambient, z, h, p, z_next)
    if number == 7:
        return saturating_viscous.advance(v, ambient, z, h, p, z_next)
    if number == 8:
        return asymmetric.advance(v, ambient, z, h, p, z_next)
    if number == 9:
        return load_dependent.advance(v, ambient, z, h, p, z_next)
    if number == 10:
        return geared_load.advance(v, ambient, z, h, p, z_next)
    if number == 11:
        return temperature_dependent.advance(v, ambient, z, h, p, z_next)
    if number == 12:
        return position_dependent.advance(v, ambient, z, h, p, z_next)
    if number == 13:
        return arctan.advance(v, ambient, z, h, p, z_next)
    if number == 14:
        return arctan_load.advance(v, ambient, z, h, p, z_next)
    if number == 15:
        return pressure.advance(v, ambient, z, h, p, z_next)
    if number == 16:
        return dahl.advance(v, ambient, z, h, p, z_next)
    if number == 17:
        return lugre.advance(v, ambient, z, h, p, z_next)
    if number == 18:
        return lugre_lorentzian.advance(v, ambient, z, h, p, z_next)
    if number == 19:
        return lugre_arctan.advance(v, ambient, z, h, p, z_next)
    if number == 20:
        return lugre_smooth.advance(v, ambient, z, h, p, z_next)
    if number == 21:
        return elasto_plastic.advance(v, ambient, z, h, p, z_next)
    if number == 22:
        return maxwell_slip.advance(v, ambient, z, h, p, z_next)
    if number == 23:
        return leuven.advance(v, ambient, z, h, p, z_next)
    if number == 24:
        return gms.advance(v, ambient, z, h, p, z_next)
    if number == 25:
        return dwell_time.advance(v, ambient, z, h, p, z_next)
    if number == 26:
        return pressed_seals.advance(v, ambient, z, h, p, z_next)
    if number == 27:
        return asymmetric_curve.advance(v, ambient, z, h, p, z_next)
    return float("nan"), 0.0
