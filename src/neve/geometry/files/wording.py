"""What the readers of mesh files share: how they refuse, and text in any encoding as bytes of one kind."""

from __future__ import annotations

import codecs
import warnings
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Faces = NDArray[np.int64]
Surface = tuple[Array, Faces]

UTF32 = (codecs.BOM_UTF32_LE, codecs.BOM_UTF32_BE)
UTF16 = (codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)
GUESSED = 256
"""Bytes by which UTF-16 without a mark is known: every other one is zero."""


class Unreadable(ValueError):
    """Say why a mesh file cannot be read: the part of a sentence behind "cannot be read: "."""


def plain(data: bytes) -> bytes:
    """Return text in ASCII, Latin-1, UTF-8, -16 or -32 with ASCII as ASCII, and without a byte-order mark.

    What is not ASCII stands only in names and comments, which nothing depends on.
    """
    if data.startswith(codecs.BOM_UTF8):
        return data[len(codecs.BOM_UTF8) :]
    encoding = ""
    if data.startswith(UTF32):  # before UTF-16, whose mark begins that of UTF-32
        encoding = "utf-32"
    elif data.startswith(UTF16):
        encoding = "utf-16"
    else:
        head = np.frombuffer(data[: min(GUESSED, len(data) // 2 * 2)], np.uint8)
        if len(head) >= 4:
            zeros = [float(np.mean(head[k::2] == 0)) for k in (0, 1)]
            if zeros[0] < 0.1 and zeros[1] > 0.9:
                encoding = "utf-16-le"
            elif zeros[0] > 0.9 and zeros[1] < 0.1:
                encoding = "utf-16-be"
    return data.decode(encoding, "replace").encode() if encoding else data


def shown(token: bytes) -> str:
    """Return a word of a file as a message may show it."""
    text = token[:40].decode("ascii", "replace")
    return '"' + "".join(c if c.isprintable() and c != '"' else "?" for c in text) + '"'


def parsed(text: bytes, kind: type[np.float64] | type[np.int64]) -> NDArray[Any]:
    """Return the numbers of a text with spaces between them, quickly; as many as there are before a word."""
    with warnings.catch_warnings():
        warnings.simplefilter("error", DeprecationWarning)
        try:
            return np.fromstring(text.decode("ascii", "replace"), kind, sep=" ")
        except (DeprecationWarning, ValueError, OverflowError):
            return np.zeros(0, kind)


def numbers(tokens: list[bytes], what: str) -> Array:
    """Return `tokens` as numbers (n,). Errors: Unreadable, which names the first that is none."""
    together = parsed(b" ".join(tokens), np.float64)
    if len(together) == len(tokens):
        return np.asarray(together)
    found = np.zeros(len(tokens))
    for i, token in enumerate(tokens):
        try:
            found[i] = float(token)
        except ValueError:
            raise Unreadable(f"{what} has {shown(token)} where a number belongs") from None
    return found


def require_corners(faces: Faces, count: int, what: str = "a face") -> None:
    """Refuse a face of a corner that is not there. Errors: Unreadable."""
    if len(faces) and not (faces.min() >= 0 and faces.max() < count):
        wrong = int(faces.max()) if faces.max() >= count else int(faces.min())
        raise Unreadable(f"{what} names corner {wrong}, and there are {count} (counted from 0)")
