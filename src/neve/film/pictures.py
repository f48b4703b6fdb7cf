"""Pictures on the disk: PNG and OpenEXR that say what they were made from."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from neve.io.atomic import replacing, writing
from neve.io.errors import RunError, cannot_read
from neve.render.path_tracing.engine import mitsuba
from neve.system import disk

KEY = "neve-render"
"""Name of the text in a picture that says what it was made from."""
HEAD = 65536
"""Bytes at the beginning of a picture in which that text stands."""


def write_png(path: Path, image: NDArray[np.uint8], key: str) -> None:
    """Write an image (height, width, 3) made from what `key` stands for. Errors: RunError."""
    from PIL import Image
    from PIL.PngImagePlugin import PngInfo

    info = PngInfo()
    info.add_text(KEY, key)
    with replacing(path) as file:
        Image.fromarray(image).save(file, format="png", pnginfo=info)


def read_png(path: Path) -> NDArray[np.uint8]:
    """Return an image (height, width, 3). Errors: RunError."""
    from PIL import Image

    with writing(path), Image.open(path) as image:
        return np.asarray(image.convert("RGB"))


def png_key(path: Path) -> str | None:
    """Return what a PNG says it is made from; None for one that is missing, damaged or of another maker."""
    from PIL import Image

    try:
        with Image.open(path) as image:
            image.load()
            found = getattr(image, "text", {}).get(KEY)
    except (OSError, SyntaxError, ValueError):
        return None
    return found if isinstance(found, str) else None


def write_exr(path: Path, light: NDArray[np.float32], key: str) -> None:
    """Write linear light (height, width, 3) as OpenEXR, with `key` in its header. Errors: RunError."""
    bitmap = mitsuba().Bitmap(light)
    bitmap.metadata()[KEY] = key
    with writing(path), disk.made_by_library(path) as place:
        bitmap.write(str(place))


def exr_key(path: Path) -> str | None:
    """Return what the header of an OpenEXR says it is made from; None as of `png_key`.

    A header is a magic number, a version, and attributes: name, type, size and value of each.
    """
    try:
        head = disk.read_bytes(path, HEAD)
    except OSError:
        return None
    at = 8
    while head[:4] == b"\x76\x2f\x31\x01" and (end := head.find(b"\0", at)) > at:
        name, kind_end = head[at:end], head.find(b"\0", end + 1)
        size = int.from_bytes(head[kind_end + 1 : kind_end + 5], "little")
        if kind_end < 0:
            break
        at = kind_end + 5 + size
        if name == KEY.encode():
            return head[kind_end + 5 : at].decode("ascii", "replace")
    return None


def refuse_strangers(path: Path) -> None:
    """Refuse to write over a file that is no picture of ours. Errors: RunError."""
    try:
        head = disk.read_bytes(path, HEAD)
    except FileNotFoundError:
        return
    except OSError as error:
        raise cannot_read(path, error) from error
    if head and KEY.encode() not in head:
        raise RunError(f"{path} is no picture that neve render made: move it away, or choose another --out.")
