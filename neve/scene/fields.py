"""Define the kinds of values that a scene is made of, and what every field must say about itself."""

from __future__ import annotations

import math
from typing import Annotated, Any, Literal

from pydantic import BaseModel, ConfigDict, Field, Strict
from pydantic_core import PydanticCustomError

Real = Annotated[float, Strict()]
Whole = Annotated[int, Strict()]
Switch = Annotated[bool, Strict()]
Fraction = Annotated[float, Strict(), Field(ge=0, le=1)]
Step = Annotated[float, Strict(), Field(gt=0, le=1)]

Length = Annotated[float, Strict(), Field(gt=0, le=1e6)]
Coordinate = Annotated[float, Strict(), Field(ge=-1e6, le=1e6)]
Rate = Annotated[float, Strict(), Field(ge=-1e4, le=1e4)]

Point2 = tuple[Coordinate, Coordinate]
Point3 = tuple[Coordinate, Coordinate, Coordinate]
Rate3 = tuple[Rate, Rate, Rate]
Angle3 = tuple[Coordinate, Coordinate, Coordinate]
Size2 = tuple[Length, Length]
Size3 = tuple[Length, Length, Length]
Color = tuple[Fraction, Fraction, Fraction]

CHOICE = "our choice"
"""The source of a value that Neve's authors chose."""


class Part(BaseModel):
    """Hold a part of a scene: frozen, no unknown keys, no infinite numbers."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False, validate_default=True)


def entry(default: Any, meaning: str, unit: str = "", source: str = CHOICE, **limits: Any) -> Any:
    """Make a field that knows its default, meaning, unit, source and legal range.

    `unit` is "1" for a pure number and "" for a word. `limits` are pydantic's: gt, ge, lt, le, min_length.
    """
    return Field(default, description=meaning, json_schema_extra={"unit": unit, "source": source}, **limits)


def wrong(key: str, message: str) -> PydanticCustomError:
    """Make the error of a check across fields; `message` completes the sentence that `key` starts."""
    return PydanticCustomError("scene", "{message}", {"key": key, "message": message})


def norm(vector: tuple[float, ...]) -> float:
    """Return the Euclidean length of `vector`."""
    return math.hypot(*vector)


class Overrides(Part):
    """Replace some properties of the scene's snow in one source; what is left out stays as in [snow]."""

    law: Literal["stomakhin2013"] | None = entry(None, "Constitutive law of this source.", "")
    rho0: Real | None = entry(None, "Density of this source.", "kg/m3", gt=0, le=2000)
    E0: Real | None = entry(None, "Young's modulus of this source.", "Pa", gt=0, le=1e12)
    nu: Real | None = entry(None, "Poisson's ratio of this source.", "1", ge=0, lt=0.5)
    xi: Real | None = entry(None, "Hardening coefficient of this source.", "1", ge=0, le=100)
    theta_c: Real | None = entry(None, "Critical compression of this source.", "1", ge=0, lt=1)
    theta_s: Real | None = entry(None, "Critical stretch of this source.", "1", ge=0, le=1)
    J_P_min: Real | None = entry(None, "Lower bound of J_P in this source's hardening.", "1", gt=0, lt=1)
    J_P_max: Real | None = entry(None, "Upper bound of J_P in this source's hardening.", "1", gt=1, le=1e6)
