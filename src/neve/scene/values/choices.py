"""What a scene can choose from: the laws, transfers and splines of the core, by their words.

The lists, their order and all that is said about each come from the core (`laws.hpp`, `transfers.hpp`,
`bspline.hpp`); the first of a list is its default.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Literal, TypeAlias

from neve import _core

LAWS: Mapping[str, _core.Law] = {law.name: law for law in _core.laws()}
TRANSFERS: Mapping[str, _core.Transfer] = {transfer.name: transfer for transfer in _core.transfers()}
SPLINES: Mapping[str, _core.Choice] = {spline.name: spline for spline in _core.splines()}

DEFAULT_LAW, DEFAULT_TRANSFER, DEFAULT_SPLINE = (next(iter(words)) for words in (LAWS, TRANSFERS, SPLINES))

if TYPE_CHECKING:
    LawWord: TypeAlias = str
    TransferWord: TypeAlias = str
    SplineWord: TypeAlias = str
else:
    LawWord, TransferWord, SplineWord = (Literal[tuple(words)] for words in (LAWS, TRANSFERS, SPLINES))


def meanings(choices: Mapping[str, _core.Choice]) -> str:
    """Return what each choice means, as `"word": meaning; ...`."""
    return "; ".join(f'"{name}": {choice.meaning}' for name, choice in choices.items())


def sources(choices: Mapping[str, _core.Choice]) -> str:
    """Return where each choice comes from, as `word: source; ...`."""
    return "; ".join(f"{name}: {choice.source}" for name, choice in choices.items())


def listed(words: Iterable[str], last: str = "and") -> str:
    """Join words as `a, b and c`."""
    *first, end = words
    return f"{', '.join(first)} {last} {end}" if first else end


def users(option: str) -> list[str]:
    """Return the transfers that read this key of [numerics]."""
    return [name for name, transfer in TRANSFERS.items() if option in transfer.options]
