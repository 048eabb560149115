"""The friction laws there are, by name."""

from __future__ import annotations

from mjfriction.errors import LawError, suggestion
from mjfriction.laws.asymmetric import ASYMMETRIC
from mjfriction.laws.coulomb_viscous import COULOMB_VISCOUS
from mjfriction.laws.law import Law
from mjfriction.laws.load_dependent import LOAD_DEPENDENT
from mjfriction.laws.quadratic_viscous import QUADRATIC_VISCOUS
from mjfriction.laws.stribeck import STRIBECK

LAWS: dict[str, Law] = {
    law.name: law for law in (COULOMB_VISCOUS, STRIBECK, QUADRATIC_VISCOUS, ASYMMETRIC, LOAD_DEPENDENT)
}


def find_law(name: str) -> Law:
    """Return the law of that name; :class:`~mjfriction.errors.LawError` names the nearest one when there is none."""
    if name not in LAWS:
        raise LawError(f"unknown friction law '{name}'{suggestion(name, LAWS)} Known: {', '.join(LAWS)}")
    return LAWS[name]
