"""Read heights from a PNG picture of one channel."""

from __future__ import annotations

import warnings
from pathlib import Path

import numpy as np

from neve.geometry.maps.found import Map, full_range, require_size, unreadable
from neve.scene.errors import SceneError

ONE_CHANNEL = "a height map has one channel, of 8 or 16 bits or of reals"


def read_picture(path: Path, key: str) -> Map:
    """Read a picture of one channel, seen from above: x to the right, y upward.

    `key`: begin of sentences.

    Errors: SceneError, one sentence.
    """
    from PIL import Image

    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            with Image.open(path, formats=["PNG"]) as image:
                mode, pixels = image.mode, image.width * image.height
                require_size(pixels, "pixels", key)
                rows = np.asarray(image)
    except SceneError:
        raise
    except Exception as error:  # whatever a damaged file makes its reader stumble over
        raise unreadable(key, error) from None
    if mode == "LA":
        raise SceneError(f"{key} is a picture with a channel of transparency: {ONE_CHANNEL}")
    if mode not in ("L", "I") and not mode.startswith("I;16"):
        raise SceneError(f"{key} is a picture in colours, or of black and white alone: {ONE_CHANNEL}")
    return Map(rows[::-1].T.astype(np.float64), full_range(8 if mode == "L" else 16))
