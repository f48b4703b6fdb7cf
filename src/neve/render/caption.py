"""Write a line of text into a picture: what a film must say of itself."""

from __future__ import annotations

from functools import cache
from importlib.resources import files
from typing import Any

import numpy as np
from numpy.typing import NDArray

FONT = "FredokaOne-Regular.ttf"
SIZE = 0.032
"""Height of the letters over that of the picture [1]."""
EDGE = 0.03
"""Distance from the lower left corner over the height of the picture [1]."""


def captioned(image: NDArray[np.uint8], text: str, top: bool = False) -> NDArray[np.uint8]:
    """Return the picture `image` (height, width, 3) with `text` in its lower left corner, if there is any.

    top: in its upper left one.
    """
    if not text:
        return image
    from PIL import Image, ImageDraw

    picture = Image.fromarray(image)
    draw = ImageDraw.Draw(picture)
    height = image.shape[0]
    font = _font(max(8, round(SIZE * height)))
    place = (EDGE * height, height * (EDGE if top else 1.0 - EDGE))
    width = max(1, round(0.08 * SIZE * height))
    draw.text(
        place,
        text,
        fill=(255, 255, 255),
        font=font,
        anchor="la" if top else "ls",
        stroke_width=width,
        stroke_fill=(40, 50, 64),
    )
    return np.array(picture)


@cache
def _font(size: int) -> Any:
    from PIL import ImageFont

    return ImageFont.truetype(str(files("neve") / "assets" / FONT), size)
