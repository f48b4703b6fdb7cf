"""Check what callers hand over: one sentence that names the argument, its value and what it should be."""

from __future__ import annotations

import math
import numbers
import operator
from typing import Any


def require(value: Any, kinds: type | tuple[type, ...], name: str, wanted: str) -> None:
    """Refuse a `value` of the argument `name` that is none of `kinds`; `wanted` says what is.

    Errors: TypeError, one sentence.
    """
    if not isinstance(value, kinds):
        raise TypeError(f"{name} = {shown(value)} is not {wanted}")


def real(value: Any, name: str, wanted: str = "a finite number") -> float:
    """Return a finite number as a float.

    Errors: TypeError for another type, ValueError for NaN and infinity; one sentence.
    """
    if isinstance(value, bool) or not isinstance(value, numbers.Real):
        raise TypeError(f"{name} = {shown(value)} is not {wanted}")
    try:
        found = float(value)
    except OverflowError:
        found = math.inf
    if not math.isfinite(found):
        raise ValueError(f"{name} = {shown(value)} is not {wanted}")
    return found


def whole(value: Any, name: str, wanted: str = "a whole number") -> int:
    """Return a whole number as an int. Errors: TypeError for another type, one sentence."""
    try:
        if isinstance(value, bool):
            raise TypeError
        return operator.index(value)
    except TypeError:
        raise TypeError(f"{name} = {shown(value)} is not {wanted}") from None


def shown(value: Any) -> str:
    """Return a value in one short line."""
    text = " ".join(repr(value).split())
    return text if len(text) <= 60 else f"{text[:57]}..."
