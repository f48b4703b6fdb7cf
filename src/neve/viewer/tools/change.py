"""Change a value of a scene as a page asks."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from neve.registry import METHODS
from neve.scene.errors import SceneError
from neve.scene.reading.files import KEYS as FILE_KEYS
from neve.scene.reading.files import OWN
from neve.scene.reading.load import scene_from
from neve.scene.reading.paths import follow
from neve.scene.schema.scene import Scene
from neve.solver import Solver


def changed(scene: Scene, path: str, value: Any) -> Scene:
    """Return the scene with `value` at `path` ("snow.xi", "colliders.0.mu_c").

    A new kind or law of snow brings its own constants. Errors: SceneError, one sentence.
    """
    tables = scene.model_dump(mode="json", exclude_none=True)
    keys = path.split(".")
    if keys[-1] in FILE_KEYS and not (isinstance(value, str) and value.startswith(OWN)):
        raise SceneError(f"{path}: only files that come with Neve can be named here, such as {OWN}rock")
    if path in ("snow.kind", "snow.law"):
        tables["snow"] = {keys[1]: value}
    else:
        _put(tables, keys, value, path)
    return checked(tables)


def checked(tables: Mapping[str, Any]) -> Scene:
    """Return the scene of `tables`. Errors: SceneError, whose sentence begins with the key."""
    try:
        return scene_from(tables, where="")
    except SceneError as error:
        raise SceneError(str(error).removeprefix(": ")) from None


def is_live(scene: Scene, path: str) -> bool:
    """Return whether a change of the value at `path` acts on a run of `scene` that goes on."""
    first, _, rest = path.partition(".")
    if first == "numerics":
        solver: type[Solver] = METHODS.get(scene.numerics.method)
        return rest not in solver.fixed
    return first not in ("sources", "run") or path.split(".")[2:3] == ["snow"]


def _put(tables: dict[str, Any], keys: list[str], value: Any, path: str) -> None:
    place = below(tables, keys[:-1], path, make=True)
    if not isinstance(place, dict):
        raise SceneError(f"{path} is not a single value")
    if value is None:
        place.pop(keys[-1], None)
    else:
        place[keys[-1]] = value


def below(tables: Any, keys: Sequence[str], path: str, make: bool = False) -> Any:
    """Return what lies at `keys` in `tables`; `make` makes the last table if it is left out.

    Errors: SceneError, which says that `path` is not there.
    """
    try:
        above = follow(tables, keys[:-1])
        if make and keys and isinstance(above, dict):
            above.setdefault(keys[-1], {})
        place = follow(tables, keys)
    except KeyError:
        place = None
    if not isinstance(place, dict | list):
        raise SceneError(f"{path} is not in this scene")
    return place
