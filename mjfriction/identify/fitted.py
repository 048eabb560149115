"""A fitted quantity as a person reads it."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Fitted:
    """A fitted quantity with its unit and 95 % interval; ``note`` says where the data do not fix it."""

    name: str
    meaning: str
    unit: str
    value: float
    low: float
    high: float
    note: str = ""
