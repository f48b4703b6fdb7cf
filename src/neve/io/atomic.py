"""Write files so that a reader finds the old file or the new one; every refusal is one sentence."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, BinaryIO

from neve.io.errors import cannot_write
from neve.system import disk

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray


@contextlib.contextmanager
def replacing(path: Path) -> Iterator[BinaryIO]:
    """Open a file that takes the place of `path` when the block ends well (see `neve.system.disk.replacing`).

    Errors: RunError, one sentence, when the system refuses (full disk, no permission, read-only disk).
    """
    with writing(path), disk.replacing(path) as file:
        yield file


@contextlib.contextmanager
def writing(path: Path) -> Iterator[None]:
    """Turn what the system refuses in the block into one sentence about `path`. Errors: RunError."""
    try:
        yield
    except OSError as error:
        raise cannot_write(path, error) from error


def write_bytes(path: Path, data: bytes) -> None:
    """Put `data` in the file `path`, whole or not at all."""
    with replacing(path) as file:
        file.write(data)


def write_text(path: Path, text: str) -> None:
    """Put `text` in the file `path` as UTF-8, whole or not at all."""
    write_bytes(path, text.encode())


def write_png(path: Path, image: NDArray[np.uint8]) -> None:
    """Put `image` (height, width, 3), top row first, in the file `path` as PNG, whole or not at all."""
    from PIL import Image

    with replacing(path) as file:
        Image.fromarray(image).save(file, format="png")
