"""Join warnings that say the same of many parts of a scene into one."""

from __future__ import annotations

import contextlib
import re
import warnings
from collections.abc import Iterable, Iterator

from neve.scene.errors import SceneWarning

MOST_ALIKE = 3
"""Sentences that say the same of one part each; of more, the first stands for all."""
NAMED = 3
"""How many of the others are named."""
_PART = re.compile(r"\b(sources|colliders|bodies|robots|outputs)\.\d+")
_NUMBER = re.compile(r"[-+]?\d[\d.,]*(?:e[-+]?\d+)?")


def joined(sentences: Iterable[str]) -> list[str]:
    """Return `sentences` in order; where more than MOST_ALIKE differ in numbers alone, the first one with how
    many others there are and what the first of them are about.
    """
    alike: dict[str, list[str]] = {}
    for sentence in sentences:
        alike.setdefault(_NUMBER.sub("#", _PART.sub(r"\1.#", sentence)), []).append(sentence)
    found = []
    for group in alike.values():
        found += group if len(group) <= MOST_ALIKE else [_one(group)]
    return found


def _one(group: list[str]) -> str:
    others = [match[0] for sentence in group[1:] if (match := _PART.search(sentence))]
    named = ", ".join(others[:NAMED])
    rest = " and so on" if len(others) > NAMED else ""
    about = f": {named}{rest}" if others else ""
    return f"{group[0].rstrip('.')} (and likewise {len(group) - 1:,} others{about})"


@contextlib.contextmanager
def joined_warnings() -> Iterator[None]:
    """Hold back what the block warns of with SceneWarning, and warn of it `joined` at its end."""
    heard: list[warnings.WarningMessage] = []
    try:
        with warnings.catch_warnings(record=True) as heard:
            warnings.simplefilter("always", SceneWarning)
            yield
    finally:
        for one in heard:
            if not issubclass(one.category, SceneWarning):
                warnings.warn_explicit(one.message, one.category, one.filename, one.lineno)
        for sentence in joined(str(one.message) for one in heard if issubclass(one.category, SceneWarning)):
            warnings.warn(sentence, SceneWarning, stacklevel=4)
