"""All friction laws by name.

Models store a law by its place in this list (:mod:`mjfriction.laws.dispatch`), so new laws are added at its end.
"""

from __future__ import annotations

from mjfriction.errors import LawError, suggestion
from mjfriction.laws.arctan import ARCTAN
from mjfriction.laws.arctan_load import ARCTAN_LOAD
from mjfriction.laws.asymmetric import ASYMMETRIC
from mjfriction.laws.asymmetric_curve import ASYMMETRIC_CURVE
from mjfriction.laws.coulomb import COULOMB
from mjfriction.laws.coulomb_viscous import COULOMB_VISCOUS
from mjfriction.laws.dahl import DAHL
from mjfriction.laws.dwell_time import DWELL_TIME
from mjfriction.laws.elasto_plastic import ELASTO_PLASTIC
from mjfriction.laws.geared_load import GEARED_LOAD
from mjfriction.laws.gms import GMS
from mjfriction.laws.law import Law
from mjfriction.laws.leuven import LEUVEN
from mjfriction.laws.load_dependent import LOAD_DEPENDENT
from mjfriction.laws.lorentzian import LORENTZIAN
from mjfriction.laws.lugre import LUGRE
from mjfriction.laws.lugre_arctan import LUGRE_ARCTAN
from mjfriction.laws.lugre_lorentzian import LUGRE_LORENTZIAN
from mjfriction.laws.lugre_smooth import LUGRE_SMOOTH
from mjfriction.laws.maxwell_slip import MAXWELL_SLIP
from mjfriction.laws.position_dependent import POSITION_DEPENDENT
from mjfriction.laws.power_viscous import POWER_VISCOUS
from mjfriction.laws.pressed_seals import PRESSED_SEALS
from mjfriction.laws.pressure import PRESSURE
from mjfriction.laws.quadratic_viscous import QUADRATIC_VISCOUS
from mjfriction.laws.saturating_viscous import SATURATING_VISCOUS
from mjfriction.laws.static_kinetic import STATIC_KINETIC
from mjfriction.laws.stribeck import STRIBECK
from mjfriction.laws.temperature_dependent import TEMPERATURE_DEPENDENT

LAWS: dict[str, Law] = {
    law.name: law
    for law in (
        COULOMB,
        COULOMB_VISCOUS,
        STATIC_KINETIC,
        STRIBECK,
        LORENTZIAN,
        QUADRATIC_VISCOUS,
        POWER_VISCOUS,
        SATURATING_VISCOUS,
        ASYMMETRIC,
        LOAD_DEPENDENT,
        GEARED_LOAD,
        TEMPERATURE_DEPENDENT,
        POSITION_DEPENDENT,
        ARCTAN,
        ARCTAN_LOAD,
        PRESSURE,
        DAHL,
        LUGRE,
        LUGRE_LORENTZIAN,
        LUGRE_ARCTAN,
        LUGRE_SMOOTH,
        ELASTO_PLASTIC,
        MAXWELL_SLIP,
        LEUVEN,
        GMS,
        DWELL_TIME,
        PRESSED_SEALS,
        ASYMMETRIC_CURVE,
    )
}


def find_law(name: str) -> Law:
    """Return the law of that name; :class:`~mjfriction.errors.LawError` suggests the nearest one if there is none."""
    if name not in LAWS:
        raise LawError(f"unknown friction law '{name}'{suggestion(name, LAWS)} Known: {', '.join(LAWS)}")
    return LAWS[name]
