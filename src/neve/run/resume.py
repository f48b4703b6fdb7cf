"""Whether a run may be resumed with a scene: nothing that moves snow may have changed."""

from __future__ import annotations

import tomllib
from collections.abc import Iterator, Mapping
from pathlib import Path

from neve.io.assets import same_content
from neve.io.errors import RunError

FREE = (
    "about",
    "camera",
    "light",
    "numerics.deterministic",
    "numerics.device",
    "numerics.devices",
    "run.duration",
    "run.film",
    "run.fragments",
    "run.frames",
)
"""Keys whose values may differ between the scene of a run and the scene that it is resumed with."""


def check_same(path: Path, before: str, now: str) -> None:
    """Refuse to go on from the checkpoint `path` with another scene: the frames would belong to neither.

    before: the scene of the checkpoint as TOML. now: that of the run. Errors: RunError.
    """
    new = dict(_flatten(tomllib.loads(now)))
    try:
        old = dict(_flatten(tomllib.loads(before)))
    except (ValueError, RecursionError) as error:
        raise RunError(f"{path} is damaged (it holds no scene); start over with --force.") from error
    for key in sorted(old.keys() | new.keys()):
        free = any(key == name or key.startswith(f"{name}.") for name in FREE)
        if not free and old.get(key) != new.get(key) and not same_content(old.get(key), new.get(key)):
            was, new_value = (repr(table[key]) if key in table else "absent" for table in (old, new))
            raise RunError(
                f"{path} was made with another scene ({key} is {was} there and {new_value} now):"
                " resume it unchanged, start over with --force, or choose another --out."
            )


def is_drawn_alike(before: str, now: str) -> bool:
    """Return whether two scenes, as TOML, have the same camera and light."""
    first, second = tomllib.loads(before), tomllib.loads(now)
    return all(first.get(key) == second.get(key) for key in ("camera", "light"))


def _flatten(value: object, path: str = "") -> Iterator[tuple[str, object]]:
    """Yield every leaf of nested tables and lists of tables with its dotted path."""
    if isinstance(value, Mapping):
        items: list[tuple[str, object]] = [(str(key), inner) for key, inner in value.items()]
    elif isinstance(value, list) and any(isinstance(inner, Mapping) for inner in value):
        items = [(str(index), inner) for index, inner in enumerate(value)]
    else:
        yield path, value
        return
    for key, inner in items:
        yield from _flatten(inner, f"{path}.{key}" if path else key)
