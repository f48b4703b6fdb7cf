"""Write files so that a reader finds the old file or the new one, never a half of either."""

from __future__ import annotations

import contextlib
import os
import re
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, BinaryIO

from neve.io.errors import cannot_write

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

_TEMPORARY = re.compile(r"\..+\.\d+\.tmp")


@contextlib.contextmanager
def replacing(path: Path) -> Iterator[BinaryIO]:
    """Open a temporary file in the folder of `path` and move it to `path` when the block ends well.

    The bytes reach the disk (fsync) before the move, so a crash at any moment leaves `path` as it was or as
    it should be. If the block fails, the temporary file is removed and `path` is untouched.

    Errors: RunError, one sentence, when the system refuses (full disk, no permission, read-only disk).
    """
    temporary = path.with_name(f".{path.name}.{os.getpid()}.tmp")
    try:
        file = open(temporary, "wb")  # noqa: SIM115 (closed below, also when closing itself fails)
        try:
            yield file
            file.flush()
            os.fsync(file.fileno())
        except BaseException:
            with contextlib.suppress(OSError):  # closing flushes again, and a full disk refuses again
                file.close()
            raise
        file.close()
        os.replace(temporary, path)
    except OSError as error:
        _remove(temporary)
        raise cannot_write(path, error) from error
    except BaseException:
        _remove(temporary)
        raise


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


def sweep(folder: Path) -> None:
    """Remove the temporary files that a killed process left in `folder`."""
    for path in folder.iterdir():
        if _TEMPORARY.fullmatch(path.name):
            _remove(path)


def _remove(path: Path) -> None:
    with contextlib.suppress(OSError):
        path.unlink()
