"""Which values the runs of a sweep have: what keys may take, and the designs that combine them."""

from __future__ import annotations

import itertools
import math
import tomllib
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import tomli_w

from neve.io.errors import RunError

Point = dict[str, Any]
"""The values of one run, by the key of the scene."""
MOST = 100_000
"""Runs of a sweep."""
EXAMPLE = (
    "write KEY=VALUE,VALUE, KEY=LOW..HIGH:COUNT or, for --design latin, KEY=LOW..HIGH; add :log for steps by"
    " factors"
)


@dataclass(frozen=True)
class Vary:
    """Hold what a key may take: `values`, or all that lies between `low` and `high`.

    is_log: whether the range is even in the logarithm. steps: how many values a grid takes of the range.
    """

    key: str
    values: tuple[Any, ...] = ()
    low: float = math.nan
    high: float = math.nan
    steps: int | None = None
    is_log: bool = False

    @property
    def is_range(self) -> bool:
        """Whether the key takes a range of numbers."""
        return not self.values

    def at(self, share: float) -> float:
        """Return the number that lies at `share` of the range, from 0 to 1."""
        if self.is_log:
            return float(self.low * (self.high / self.low) ** share)
        return float(self.low + (self.high - self.low) * share)

    def listed(self) -> tuple[Any, ...]:
        """Return the values of a grid: whole numbers where all of them are. Errors: RunError."""
        if not self.is_range:
            return self.values
        if self.steps is None:
            raise RunError(
                f"--vary {self.key}: a range needs a count, such as {self.key}={self.low:g}..{self.high:g}:5,"
                " or --design latin with --samples."
            )
        inner = [self.at(k / (self.steps - 1)) for k in range(1, self.steps - 1)]
        values = [self.low, *inner, self.high]
        return tuple(map(int, values)) if all(value.is_integer() for value in values) else tuple(values)


def read_vary(text: str) -> Vary:
    """Return what the text of `--vary` says. Errors: RunError, one sentence.

    Such as "snow.xi=5,10" (values), "snow.E0=1e5..1e6:4:log" (four of a range, by equal factors) and
    "snow.nu=0.1..0.3" (a range, for Latin hypercubes).
    """
    key, equals, words = (part.strip() for part in text.partition("="))
    if not equals or not words or not all(key.split(".")):
        raise RunError(f"--vary {text}: {EXAMPLE}.")
    if ".." in words and not words.startswith(("[", '"', "'", "{")):
        return _range(key, words, text)
    return of_values(key, _values(words, text), f"--vary {text}")


def of_values(key: str, values: Sequence[Any], where: str) -> Vary:
    """Return a key with its values. Errors: RunError if one stands there twice."""
    shown = [toml_of(value) for value in values]
    if twice := sorted({word for word in shown if shown.count(word) > 1}):
        raise RunError(f"{where}: the value {twice[0]} is there twice.")
    return Vary(key, tuple(values))


def of_range(
    key: str, low: float, high: float, steps: int | None = None, is_log: bool = False, where: str = ""
) -> Vary:
    """Return a key with a range. Errors: RunError, one sentence that begins with `where`."""
    if not (math.isfinite(low) and math.isfinite(high) and low < high):
        raise RunError(f"{where}: a range goes from a finite number to a greater one.")
    if is_log and low <= 0:
        raise RunError(f"{where}: a logarithmic range begins above 0.")
    if steps is not None and not 2 <= steps <= MOST:
        raise RunError(f"{where}: a range has 2 to {MOST:,} values.")
    return Vary(key, (), low, high, steps, is_log)


def _range(key: str, words: str, text: str) -> Vary:
    ends, *more = words.split(":")
    is_log = more[-1:] == ["log"]
    counts = more[:-1] if is_log else more
    try:
        low, high = (float(word) for word in ends.split(".."))
        steps = int(counts[0]) if counts else None
    except ValueError:
        raise RunError(f"--vary {text}: {EXAMPLE}.") from None
    if len(counts) > 1:
        raise RunError(f"--vary {text}: {EXAMPLE}.")
    return of_range(key, low, high, steps, is_log, f"--vary {text}")


def _values(words: str, text: str) -> list[Any]:
    """Return values between commas as TOML; a bare word counts as text."""
    try:
        table = tomllib.loads(f"v = [{words}]")
        if list(table) == ["v"]:
            return list(table["v"])
    except tomllib.TOMLDecodeError:
        if any(bracket in words for bracket in "[{\"'"):
            raise RunError(f"--vary {text}: the values are not valid TOML; {EXAMPLE}.") from None
    parts = [word.strip() for word in words.split(",")]
    if not all(parts):
        raise RunError(f"--vary {text}: {EXAMPLE}.")
    return [_value(word) for word in parts]


def _value(word: str) -> Any:
    try:
        return tomllib.loads(f"v = {word}")["v"]
    except (tomllib.TOMLDecodeError, KeyError):
        return word


def toml_of(value: Any) -> str:
    """Return a value as TOML on one line; a float so that it reads back as the same number."""
    text = tomli_w.dumps({"v": value}).strip()
    if text.startswith("v = "):
        return " ".join(text.removeprefix("v = ").split())
    inner = ", ".join(f"{key} = {toml_of(item)}" for key, item in value.items())
    return f"{{ {inner} }}"


def changes_of(point: Point) -> list[str]:
    """Return a point as changes of a scene, such as "snow.xi=5"."""
    return [f"{key}={toml_of(value)}" for key, value in point.items()]


def grid(varied: Sequence[Vary]) -> list[Point]:
    """Return all combinations; the last key changes fastest. Errors: RunError."""
    _require_few(math.prod(len(vary.listed()) for vary in varied))
    return _points(varied, itertools.product(*(vary.listed() for vary in varied)))


def together(varied: Sequence[Vary]) -> list[Point]:
    """Return the first values of all keys, then the second ones, and so on. Errors: RunError."""
    counts = {vary.key: len(vary.listed()) for vary in varied}
    if len(set(counts.values())) > 1:
        said = ", ".join(f"{key} has {count}" for key, count in counts.items())
        raise RunError(f"--design together needs as many values of each key: {said}.")
    return _points(varied, zip(*(vary.listed() for vary in varied), strict=True))


def latin(varied: Sequence[Vary], samples: int, seed: int = 0) -> list[Point]:
    """Return a Latin hypercube of so many points: each key has one value in each of as many equal parts.

    The parts are of the range, or of the list of values, in which each value then comes equally often up to
    one. The same seed gives the same points. Errors: RunError.

    Source: McKay, Beckman and Conover 1979.
    """
    _require_few(samples)
    random = np.random.default_rng(seed)
    columns: list[list[Any]] = []
    for vary in varied:
        share = (random.permutation(samples) + random.random(samples)) / samples
        if vary.is_range:
            columns.append([vary.at(float(part)) for part in share])
        else:
            columns.append([vary.values[int(part * len(vary.values))] for part in share])
    return _points(varied, zip(*columns, strict=True))


def _points(varied: Sequence[Vary], rows: Any) -> list[Point]:
    keys = [vary.key for vary in varied]
    if twice := sorted({key for key in keys if keys.count(key) > 1}):
        raise RunError(f"--vary {twice[0]}: the key is varied twice.")
    return [dict(zip(keys, row, strict=True)) for row in rows]


def _require_few(count: int) -> None:
    if not 1 <= count <= MOST:
        raise RunError(f"this sweep has {count:,} runs: 1 to {MOST:,} are allowed.")
