"""Draw text as a picture that says where letters of snow are solid."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from neve.sampling.fonts import (
    NO_CHARACTER,
    is_shaped,
    opened,
    picture,
    plain,
    require_glyphs,
    spaced,
    unusable,
)
from neve.scene.errors import SceneError
from neve.scene.schema.file_shapes import Text

if TYPE_CHECKING:
    from PIL.ImageFont import FreeTypeFont

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

PIXELS_PER_SPACING = 8
"""Edges of letters are true to 1/16 of the distance between particles."""
LARGEST_PICTURE = 64e6
"""Pixels of the largest picture; longer texts are drawn coarser."""
LARGEST_MAP = 8e6
"""Pixels of the largest map of distances."""


@dataclass(frozen=True)
class Letters:
    """Hold a picture of text in the x-z plane, centred on the origin.

    Attributes:
        solid: whether a pixel is inside a letter, row 0 on top, (rows, columns)
        pixel: edge of a pixel [m]
    """

    solid: Mask
    pixel: float

    @property
    def width(self) -> float:
        """Return the extent along x [m]."""
        return float(self.solid.shape[1] * self.pixel)

    @property
    def height(self) -> float:
        """Return the extent along z [m]."""
        return float(self.solid.shape[0] * self.pixel)

    @property
    def area(self) -> float:
        """Return the area of the letters [m2]."""
        return float(self.solid.sum()) * self.pixel**2

    def covers(self, x: Array) -> Mask:
        """Return whether points `x` [m] (n, 3) within the picture's edges lie in a letter."""
        return np.asarray(self.solid[self._pixels(x)])

    def depth(self, x: Array) -> Array:
        """Return how far points `x` [m] (n, 3) of a letter lie from its outline [m] (n,), at least 0.

        True to two pixels; in a picture larger than LARGEST_MAP, to two pixels of a map so much coarser.
        """
        from scipy.ndimage import distance_transform_edt

        step = int(np.ceil(np.sqrt(self.solid.size / LARGEST_MAP)))
        distance = distance_transform_edt(np.pad(self.solid[::step, ::step], 1))[1:-1, 1:-1]
        i, j = self._pixels(x)  # between the middles of two pixels runs the outline, half a pixel from each
        return np.asarray(np.maximum(distance[i // step, j // step] - 0.5, 0.0) * (step * self.pixel))

    def _pixels(self, x: Array) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        rows, columns = self.solid.shape
        i = np.clip((0.5 * rows - x[:, 2] / self.pixel).astype(np.int64), 0, rows - 1)
        j = np.clip((x[:, 0] / self.pixel + 0.5 * columns).astype(np.int64), 0, columns - 1)
        return i, j


def letters(source: Text, spacing: float, name: str) -> Letters:
    """Draw the text of `source` with pixels fine enough for particles `spacing` [m] apart.

    Errors: SceneError if the font cannot be read or lacks a letter.

    `name`: used in messages.
    """
    try:
        return _drawn(source, spacing, name)
    except SceneError:
        raise
    except Exception:  # whatever a damaged font makes its reader stumble over
        raise unusable(source, name, "draws the text") from None


def _drawn(source: Text, spacing: float, name: str) -> Letters:
    from PIL import Image, ImageDraw

    text = plain(source.text)
    shaped = is_shaped(text)
    font = opened(source, 256.0, name, shaped)
    require_glyphs(source, text, font, name)
    text = spaced(text, font)
    left, top, right, bottom = _box(text, font)
    pixels = min(max(PIXELS_PER_SPACING * source.height / spacing, 48.0), 4096.0)
    scale = pixels / _capital(text, font)
    scale = min(scale, float(np.sqrt(LARGEST_PICTURE / ((right - left) * (bottom - top)))))
    font = opened(source, 256.0 * scale, name, shaped)
    left, top, right, bottom = _box(text, font)
    image = Image.new("L", (int(right - left) + 4, int(bottom - top) + 4))
    ImageDraw.Draw(image).multiline_text((2 - left, 2 - top), text, fill=255, font=font, align="center")
    solid = np.asarray(image) > 127
    rows, columns = np.flatnonzero(solid.any(axis=1)), np.flatnonzero(solid.any(axis=0))
    solid = solid[rows[0] : rows[-1] + 1, columns[0] : columns[-1] + 1]
    return Letters(solid, source.height / _capital(text, font))


def _box(text: str, font: FreeTypeFont) -> tuple[float, float, float, float]:
    from PIL import Image, ImageDraw

    draw = ImageDraw.Draw(Image.new("L", (1, 1)))
    return draw.multiline_textbbox((0, 0), text, font=font, align="center")


def _capital(text: str, font: FreeTypeFont) -> float:
    """Return the height of a capital H in pixels, or of the tallest glyph of `text` if the font has no H."""
    tall = "H" if picture("H", font) not in (None, picture(NO_CHARACTER, font)) else text
    boxes = [font.getbbox(c) for c in dict.fromkeys(tall) if not c.isspace()]
    return max(bottom - top for _, top, _, bottom in boxes)
