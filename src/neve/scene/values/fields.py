"""Define the kinds of values that a scene is made of, and what every field must state."""

from __future__ import annotations

import math
from collections.abc import Sequence
from decimal import ROUND_CEILING, ROUND_FLOOR, Decimal
from itertools import pairwise
from typing import Annotated, Any, Literal, Protocol

from pydantic import AfterValidator, BaseModel, BeforeValidator, ConfigDict, Field, Strict
from pydantic_core import PydanticCustomError

from neve.registry import DEVICES, METHODS
from neve.scene.values.allowed import words
from neve.scene.values.kinds import OneOf

LEAST = 1e-30
"""Numbers nearer to 0 are refused: squares and products of them are no longer numbers of full precision."""
SHORTEST = 1e-9
"""Least length [m] and least duration [s] of anything."""


def _no_trace(value: float) -> float:
    """Refuse a number so near to 0 that it can only be a mistake."""
    if 0.0 < abs(value) < LEAST:
        raise PydanticCustomError("trace", "nearer to 0 than {least}", {"least": LEAST})
    return value


NoTrace = AfterValidator(_no_trace)

Real = Annotated[float, Strict(), NoTrace]
Whole = Annotated[int, Strict()]
Switch = Annotated[bool, Strict()]
Fraction = Annotated[float, Strict(), Field(ge=0, le=1), NoTrace]
Step = Annotated[float, Strict(), Field(ge=SHORTEST, le=1)]

Factor = Annotated[float, Strict(), Field(ge=1e-6, le=100)]
Distance = Annotated[float, Strict(), Field(ge=0, le=1e6), NoTrace]


def _no_switch(value: object) -> object:
    """Refuse true and false where a number is one of a few: Python takes them for 1 and 0."""
    if isinstance(value, bool):
        raise ValueError("true and false are not numbers")
    return value


Modes = Annotated[Literal[1, 4, 8, 27], BeforeValidator(_no_switch)]
Damping = Annotated[float, Strict(), Field(ge=0, le=1e6), NoTrace]

Method = Annotated[str, OneOf(METHODS)]
Device = Annotated[str, OneOf(DEVICES)]

MOST_DEVICES = 64
DeviceNumbers = Annotated[
    tuple[Annotated[int, Strict(), Field(ge=0, lt=MOST_DEVICES)], ...],
    Field(min_length=1, max_length=MOST_DEVICES),
]

Length = Annotated[float, Strict(), Field(ge=SHORTEST, le=1e6)]
Coordinate = Annotated[float, Strict(), Field(ge=-1e6, le=1e6), NoTrace]
FarCoordinate = Annotated[float, Strict(), Field(ge=-1e12, le=1e12), NoTrace]
Rate = Annotated[float, Strict(), Field(ge=-1e4, le=1e4), NoTrace]

Point2 = tuple[Coordinate, Coordinate]
Point3 = tuple[Coordinate, Coordinate, Coordinate]
FarPoint3 = tuple[FarCoordinate, FarCoordinate, FarCoordinate]
Rate3 = tuple[Rate, Rate, Rate]
Angle3 = tuple[Coordinate, Coordinate, Coordinate]
Size2 = tuple[Length, Length]
Size3 = tuple[Length, Length, Length]
Color = tuple[Fraction, Fraction, Fraction]
Finish = Literal["paint", "metal", "rubber", "wood", "stone"]

CURVES = (
    "Between them values follow monotone cubic curves, without overshoot; they rest before the first and "
    "after the last."
)
"""What keyframes do between their times."""
FRITSCH = "Fritsch and Butland 1984 (from memory)"
CHOICE = "our choice"
"""The source of a value that Neve's authors chose."""
CONTACT = "Stomakhin et al. 2013, collisions (as quoted in public codes)"
MODES = (
    '"separate": snow may leave the surface, and slides with friction; "slip": snow stays on the surface '
    '(with friction, within 0.3 cells) and slides with friction; "sticky": snow moves with the surface.'
)
ZERO = (0.0, 0.0, 0.0)


class Part(BaseModel):
    """Hold a part of a scene: frozen, no unknown keys, no infinite numbers."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False, validate_default=True)


def entry(default: Any, meaning: str, unit: str = "", source: str = CHOICE, **limits: Any) -> Any:
    """Make a field that knows its default, meaning, unit, source and legal range.

    `unit` is "1" for a pure number and "" for a word. `limits` are pydantic's: gt, ge, lt, le, min_length.
    """
    return Field(default, description=meaning, json_schema_extra={"unit": unit, "source": source}, **limits)


def file_entry(meaning: str, suffixes: tuple[str, ...], folder: str = "") -> Any:
    """Make a field that names a file: none at first, `suffixes` are what it may end in.

    `folder` of Neve's own assets has files that are called "neve:NAME" (see `neve.scene.reading.files`).
    """
    known: dict[str, Any] = {"unit": "", "source": CHOICE, "suffixes": list(suffixes), "folder": folder}
    return Field("", description=meaning, json_schema_extra=known)


def check_file(name: str, suffixes: tuple[str, ...], what: str) -> None:
    """Refuse a `file` that is left out or ends in none of `suffixes`.

    Errors: PydanticCustomError.
    """
    if not name:
        raise wrong("file", f"must name {what}: a file that ends in {words(suffixes)}")
    if not name.startswith("neve:") and not name.lower().endswith(suffixes):
        raise wrong("file", f"must end in {words(suffixes)}")


def wrong(key: str, message: str) -> PydanticCustomError:
    """Make the error of a check across fields; `message` completes the sentence that `key` starts."""
    return PydanticCustomError("scene", "{message}", {"key": key, "message": message})


class Timed(Protocol):
    """Something that holds at one moment."""

    @property
    def t(self) -> float:
        """The moment [s]."""


def check_times(keyframes: Sequence[Timed], name: str = "keyframes") -> None:
    """Refuse keyframes, the list `name`, that do not come one after another.

    Errors: PydanticCustomError.
    """
    for i, (a, b) in enumerate(pairwise(keyframes)):
        if b.t <= a.t:
            raise wrong(
                f"{name}.{i + 1}.t", f"must be later than the keyframe before it, greater than {a.t:g} [s]"
            )


def norm(vector: tuple[float, ...]) -> float:
    """Return the Euclidean length of `vector`."""
    return math.hypot(*vector)


def rounded_down(value: float) -> str:
    """Write a positive `value` with three digits, none too large; "0" for others."""
    return _rounded(value, ROUND_FLOOR, 1 + 1e-12)


def rounded_up(value: float) -> str:
    """Write a positive `value` with three digits, none too small; "0" for others."""
    return _rounded(value, ROUND_CEILING, 1 - 1e-12)


def _rounded(value: float, cut: str, slack: float) -> str:
    if value <= 0:
        return "0"
    exact = Decimal(value) * Decimal(slack)
    return f"{float(exact.quantize(Decimal(1).scaleb(exact.adjusted() - 2), rounding=cut)):.3g}"
