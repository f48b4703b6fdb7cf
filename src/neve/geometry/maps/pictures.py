"""Read heights, or the grey of a mask, from a PNG picture."""

from __future__ import annotations

import warnings
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from neve.geometry.maps.found import Map, full_range, require_size, unreadable
from neve.scene.errors import SceneError

ONE_CHANNEL = "a map has one channel, of 8 or 16 bits or of reals"


def read_picture(path: Path, key: str) -> Map:
    """Read a picture of one channel, seen from above: x to the right, y upward.

    `key`: begin of sentences.

    Errors: SceneError, one sentence.
    """
    mode, rows = _read(path, key, False)
    if mode == "LA":
        raise SceneError(f"{key} is a picture with a channel of transparency: {ONE_CHANNEL}")
    if mode not in ("L", "I") and not mode.startswith("I;16"):
        raise SceneError(f"{key} is a picture in colours, or of black and white alone: {ONE_CHANNEL}")
    return _seen_from_above(mode, rows)


def read_grey(path: Path, key: str) -> Map:
    """Read how bright a picture of any kind is, seen from above; what is transparent is black.

    `key`: begin of sentences.

    Errors: SceneError, one sentence.
    """
    return _seen_from_above(*_read(path, key, True))


def _seen_from_above(mode: str, rows: NDArray[Any]) -> Map:
    return Map(rows[::-1].T.astype(np.float64), full_range(8 if mode == "L" else 16))


def _read(path: Path, key: str, is_grey: bool) -> tuple[str, NDArray[Any]]:
    """Return the mode of Pillow and the numbers, rows from the top; those of its brightness if `is_grey`."""
    from PIL import Image

    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            with Image.open(path, formats=["PNG"]) as image:
                require_size(image.width * image.height, "pixels", key)
                if not is_grey or image.mode in ("L", "I") or image.mode.startswith("I;16"):
                    return image.mode, np.asarray(image)
                whole = image.convert("RGBA")
                grey, alpha = (
                    np.asarray(part, np.float64) for part in (whole.convert("L"), whole.split()[3])
                )
                return "L", grey * alpha / 255.0
    except SceneError:
        raise
    except Exception as error:  # whatever a damaged file makes its reader stumble over
        raise unreadable(key, error) from None
