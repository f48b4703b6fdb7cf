"""Find the scenes that come with Neve. What is here needs no compiled core: `neve list` works without one."""

from __future__ import annotations

import re
import tomllib
from collections import Counter
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from neve.scene.errors import SceneError
from neve.spelling import hint, nearest
from neve.system import disk

MOST_ENTRIES = 10_000
"""Entries of each list of a scene: sources, colliders, bodies and so on."""
MOST_BYTES = 16_000_000
"""Bytes of a scene file: 10,000 entries with all their keys take some 7 MB."""
_HEADING = re.compile(r"^[ \t]*\[\[[ \t]*([A-Za-z_]+)[ \t]*\]\]", re.MULTILINE)

PRESETS = Path(__file__).parents[1] / "presets"


def presets() -> list[str]:
    """Return the names of the scenes that come with Neve, in alphabetical order."""
    return sorted(path.stem for path in PRESETS.glob("*.toml"))


def preset_about(name: str) -> str:
    """Return the line that says what happens in the preset `name`.

    Errors: SceneError if there is no such preset.
    """
    if name not in presets():
        raise SceneError(no_such_scene(name))
    return str(read_toml(PRESETS / f"{name}.toml", f"preset {name}").get("about", ""))


def no_such_scene(name: str) -> str:
    """Return the sentence about a scene that is neither a preset nor a file."""
    near = nearest(name, presets())
    return f'no preset or file is called "{name}"{hint(near)}; the presets are {preset_names()}'


def preset_names() -> str:
    """Return the names of all presets in one line."""
    return ", ".join(presets())


def read_toml(path: Path, where: str) -> dict[str, Any]:
    """Return the tables of a TOML file; `where` names it in errors. Errors: SceneError, one sentence."""
    try:
        content = disk.read_bytes(path, MOST_BYTES + 1)
        if len(content) > MOST_BYTES:
            raise SceneError(
                f"{where}: a scene file has at most {MOST_BYTES / 1e6:g} MB, and this one has more"
            )
        text = content.decode("utf-8-sig").replace("\r\n", "\n").replace("\r", "\n")
        require_few(Counter(_HEADING.findall(text)), where)
        return tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        match = re.fullmatch(r"(.*) \(at (.*)\)", str(error), re.DOTALL)
        what, place = match.groups() if match else (str(error), "some line")
        raise SceneError(f"{where}, {place}: this is not valid TOML: {what[:1].lower()}{what[1:]}") from None
    except RecursionError:
        raise SceneError(f"{where}: this is not a scene: brackets are nested too deeply") from None
    except UnicodeDecodeError as error:
        raise SceneError(f"{where}: byte {error.start} is not UTF-8 text; save the file as UTF-8") from None
    except OSError as error:
        raise SceneError(f"{where}: the file cannot be read: {error.strerror}") from None


def require_few(entries: Mapping[str, int], where: str) -> None:
    """Refuse a scene with a list of more than MOST_ENTRIES entries. Errors: SceneError."""
    for name, count in entries.items():
        if count > MOST_ENTRIES:
            raise SceneError(
                f"{where}: {name} has {count:,} entries, more than {MOST_ENTRIES:,}: "
                "join what can be one mesh or one larger source"
            )
