"""Find the known word that a mistyped one was probably meant to be."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from difflib import get_close_matches

SIMILARITY = 0.55
"""Least ratio of similarity, as `difflib.SequenceMatcher` measures it, that counts as near [1]."""


def nearest(word: str, known: Iterable[str], synonyms: Mapping[str, str] | None = None) -> str | None:
    """Return the member of `known` that is spelled most like `word`, None if none is near.

    Case does not count. `synonyms` maps words that are used elsewhere to known ones; they win over spelling.
    """
    names = list(known)
    synonym = (synonyms or {}).get(word)
    if synonym in names:
        return synonym
    lower = {name.lower(): name for name in reversed(names)}
    match = get_close_matches(word.lower(), list(lower), n=1, cutoff=SIMILARITY)
    return lower[match[0]] if match else None


def hint(name: str | None, otherwise: str = "") -> str:
    """Return " (did you mean NAME?)", or `otherwise` in brackets if there is no name; nothing for neither."""
    text = f"did you mean {name}?" if name else otherwise
    return f" ({text})" if text else ""
