"""A fitted quantity as a person reads it."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Fitted:
    """A fitted quantity with its unit and 95 % interval; ``note`` is a remark, such as that no data determine it."""

    name: str
    meaning: str
    unit: str
    value: float
    low: float
    high: float
    note: str = ""
