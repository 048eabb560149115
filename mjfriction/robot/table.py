"""What all tables of robot.toml share: number types, and torques that vary along the stroke."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import BaseModel, ConfigDict, Field

Finite = Annotated[float, Field(allow_inf_nan=False, strict=True)]
Positive = Annotated[float, Field(gt=0.0, allow_inf_nan=False, strict=True)]
NonNegative = Annotated[float, Field(ge=0.0, allow_inf_nan=False, strict=True)]
Vector = tuple[Finite, Finite, Finite]


class Table(BaseModel):
    """A table of the file: unknown keys are rejected, and values are read-only."""

    model_config = ConfigDict(extra="forbid", frozen=True)


class Wave(Table):
    """A torque that repeats along the stroke: ``cosine`` · cos(k q) + ``sine`` · sin(k q), k being ``wavenumber``."""

    wavenumber: Positive
    cosine: Finite = 0.0
    sine: Finite = 0.0


class Spot(Table):
    """A torque at one place of the stroke: ``coulomb`` · exp(−½·((q − ``position``)/``width``)²)."""

    position: Finite
    width: Positive
    coulomb: Finite


class Edge(Table):
    """A torque on one ``side`` of a place of the stroke: ``coulomb`` · Φ(±(q − ``position``)/``width``), Φ being the
    normal distribution and the plus for the side above.
    """

    position: Finite
    width: Positive
    coulomb: Finite
    side: Literal["above", "below"] = "above"
