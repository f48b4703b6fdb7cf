"""The card of a run, `run.json`: what makes a folder a run, and which files in it are the run's own."""

from __future__ import annotations

import json
import zlib
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NoReturn

from neve.io.atomic import write_text
from neve.io.errors import RunError, cannot_read
from neve.system import disk

FORMAT = 2
"""Version of the layout of a run folder."""

_MOST_BYTES = 2**24
"""No card is as large."""


@dataclass(frozen=True)
class Card:
    """What `run.json` says.

    Attributes:
        format: version of the folder's layout
        neve: version of Neve that made the run
        files: names of the files of the run's outputs, each in the run folder itself
        begun: whether the first frame was written; else nothing is lost if the run starts anew
    """

    format: int
    neve: str
    files: tuple[str, ...] = ()
    begun: bool = True


def write_card(path: Path, card: Card) -> None:
    """Write `run.json`, with a checksum of all that it says. Errors: RunError if the disk refuses."""
    files = sorted({*card.files})
    content = {"run_format": card.format, "neve": card.neve, "files": files, "begun": card.begun}
    write_text(path, json.dumps({**content, "crc32": _sum(content)}) + "\n")


def read_card(path: Path) -> Card:
    """Read `run.json`. Errors: RunError if it is missing, damaged, or altered."""
    try:
        if path.stat().st_size > _MOST_BYTES:
            raise ValueError
        content: Any = json.loads(disk.read_bytes(path), parse_constant=_refuse)
        mark = content.pop("crc32", None)
        version = content["run_format"]
        if type(version) is not int or mark not in (None, _sum(content)):
            raise ValueError
        return Card(version, str(content.get("neve", "")), _plain(content.get("files")), _begun(content))
    except OSError as error:
        raise cannot_read(path, error) from error
    except (ValueError, KeyError, TypeError, AttributeError, RecursionError) as error:
        raise RunError(
            f"{path} is damaged (cut short or altered); start over with --force or choose another --out."
        ) from error


def _begun(content: dict[str, Any]) -> bool:
    return content.get("begun", True) is not False


def _sum(content: dict[str, Any]) -> int:
    return zlib.crc32(json.dumps(content, sort_keys=True).encode())


def _plain(names: object) -> tuple[str, ...]:
    """Return those of `names` that name a file in the folder itself."""
    given = names if isinstance(names, list | tuple | set) else ()
    return tuple(name for name in given if isinstance(name, str) and name and _is_plain(name))


def _is_plain(name: str) -> bool:
    return Path(name).name == name and name not in (".", "..") and "\0" not in name


def _refuse(word: str) -> NoReturn:
    raise ValueError(word)
