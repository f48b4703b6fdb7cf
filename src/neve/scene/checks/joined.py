"""Join warnings that say the same of many parts of a scene into one."""

from __future__ import annotations

import contextlib
import re
import warnings
from collections import Counter
from collections.abc import Iterable, Iterator

from neve.scene.errors import SceneWarning

MOST_ALIKE = 3
"""Sentences that say the same of one part each; of more, the first stands for all."""
NAMED = 3
"""How many of the others are named."""
_PART = re.compile(r"\b(sources|colliders|bodies|robots|outputs)\.\d+")
_FILE = re.compile(r'\b(file|font|mask) = "(?:[^"\\]|\\.)*"')
_NUMBER = re.compile(r"[-+]?\d[\d.,]*(?:e[-+]?\d+)?")


def kind_of(sentence: str) -> str:
    """Return what a sentence says, without which part, file and numbers it says it of."""
    return _NUMBER.sub("#", _FILE.sub(r'\1 = "#"', _PART.sub(r"\1.#", sentence)))


def joined(sentences: Iterable[str]) -> list[str]:
    """Return `sentences` in order; where more than MOST_ALIKE differ in parts, files and numbers alone, the
    first one with how many others there are and what the first of them are about. Equal ones are said once,
    with their number.
    """
    alike: dict[str, list[str]] = {}
    for sentence in sentences:
        alike.setdefault(kind_of(sentence), []).append(sentence)
    found = []
    for group in alike.values():
        times = Counter(group)
        found += [_one(group)] if len(times) > MOST_ALIKE else [_counted(*pair) for pair in times.items()]
    return found


def _counted(sentence: str, times: int) -> str:
    return sentence if times == 1 else f"{sentence.rstrip('.')} ({times:,} times)"


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
