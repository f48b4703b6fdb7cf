"""Turn an error of pydantic into one sentence: key, value, what is allowed, nearest spelling."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from pydantic import BaseModel, ValidationError
from pydantic.fields import FieldInfo

from neve.scene.reading.paths import follow
from neve.scene.schema.outputs import OutputOptions
from neve.scene.schema.scene import Scene
from neve.scene.schema.tables import entry_models, table_of_list
from neve.scene.values.allowed import allowed, choices, part, words
from neve.spelling import hint, nearest

ALSO_CALLED = {
    "friction": "mu_c",
    "mu": "mu_c",
    "density": "rho0",
    "rho": "rho0",
    "E": "E0",
    "youngs_modulus": "E0",
    "poisson_ratio": "nu",
    "hardening": "xi",
    "alpha": "flip_alpha",
    "g": "gravity",
    "ppc": "particles_per_cell",
    "position": "center",
    "centre": "center",
    "omega": "spin",
    "angular_velocity": "spin",
    "type": "shape",
    "elevation": "sun_elevation",
    "azimuth": "sun_azimuth",
    "lookat": "target",
    "stiffness_noise": "variation",
    "amplitude": "stiffness",
    "depths": "at",
    "phi": "friction_angle",
    "c": "cohesion",
    "path": "file",
    "mesh": "file",
    "filename": "file",
    "units": "unit",
    "up_axis": "up",
    "resolution": "detail",
    "voxel_size": "detail",
}
"""Names of keys in other programs -> the key here."""


@dataclass(frozen=True)
class Problem:
    """Hold one problem: the `path` of the key in the scene, and the sentence about it."""

    path: tuple[str, ...]
    sentence: str


MOST_COUNTED = 1000
"""Problems at most that are looked at: a file that is no scene may have a million."""


def problems(error: ValidationError, data: dict[str, Any]) -> tuple[Problem, int]:
    """Return the first problem in `error`, found in `data`, and how many have one, up to MOST_COUNTED."""
    details = sorted(error.errors(include_url=False), key=lambda detail: detail["type"] != "trace")
    first = _problem(dict(details[0]), data)
    return first, len({_path(dict(detail)) for detail in details[:MOST_COUNTED]})


def _path(detail: dict[str, Any]) -> tuple[str, ...]:
    """Return the path of the key of a problem."""
    path, _, field = _walk(detail["loc"])
    if detail["type"] == "scene":
        return (*path, *detail["ctx"]["key"].split("."))
    if detail["type"] == "union_tag_invalid" and field:
        return (*path, entry_models(field.annotation)[0])
    return path


def nearest_key(word: str, known: Sequence[str]) -> str | None:
    """Return the member of `known` that `word` probably means: another name of a key, or a misspelling."""
    return nearest(word, known, ALSO_CALLED)


def shown(value: Any) -> str:
    """Write `value` as in a scene file, cut to one short line."""
    if isinstance(value, dict):
        return "a table"
    if isinstance(value, list) and any(isinstance(item, dict) for item in value):
        return "a list of tables"
    text = json.dumps(value, ensure_ascii=False, default=str).replace("NaN", "nan").replace("Infinity", "inf")
    return text if len(text) <= 60 else f"{text[:57]}..."


def _problem(detail: dict[str, Any], data: dict[str, Any]) -> Problem:
    path, owner, field = _walk(detail["loc"])
    kind = detail["type"]
    if kind == "extra_forbidden":
        return Problem(path, _unknown_key(path, owner))
    if kind == "scene":
        path = (*path, *detail["ctx"]["key"].split("."))
        message = detail["ctx"]["message"]
        value = _value(path, data)
        stated = "" if value is None or isinstance(value, dict) else f" = {shown(value)} is not allowed: it"
        return Problem(path, f"{'.'.join(path)}{stated} {message}")
    if kind == "trace":
        least = f"{detail['ctx']['least']:g}"
        stated = f"{'.'.join(path)} = {shown(_value(path, data))}"
        return Problem(path, f"{stated} is not allowed: a number is 0, or not nearer to it than {least}")
    tag, models = entry_models(field.annotation) if field else ("", {})
    known = list(models)
    if kind == "union_tag_not_found":
        return Problem(path, f"{'.'.join(path)} has no {tag}; add {tag} = {words(known)}")
    if kind == "union_tag_invalid":
        return _bad_word((*path, tag), data, words(known), known)
    if known:
        right = f"a table with {tag} = {words(known)}"
        if len(path) == 1:
            right = f"a list of tables, each headed [[{path[0]}]] and with a {tag}"
        return _bad_word(path, data, right, [])
    if field is None:
        return Problem(path, f"{'.'.join(path)} is not allowed: {detail['msg']}")
    return _bad_word(path, data, allowed(field), list(choices(field)))


def _bad_word(path: tuple[str, ...], data: dict[str, Any], right: str, known: list[str]) -> Problem:
    value = _value(path, data)
    near = nearest_key(value, known) if isinstance(value, str) else None
    meant = hint(near and f'"{near}"')
    return Problem(path, f"{'.'.join(path)} = {shown(value)} is not allowed{meant}: use {right}")


def _unknown_key(path: tuple[str, ...], owner: type[BaseModel]) -> str:
    key = path[-1]
    keys = sorted(owner.model_fields, key=lambda name: name not in ("shape", "kind"))
    kind = f" of a {owner.model_fields['shape'].default}" if "shape" in keys else ""
    if issubclass(owner, OutputOptions):
        kind = f" of the output {owner.model_fields['kind'].default}"
    near = nearest_key(key, keys)
    if near is None:
        near = next((f"{s}.{key}" for s, f in Scene.model_fields.items() if key in _keys(f.annotation)), None)
        near = near or next(
            (f"{s}.{n}" for s, f in Scene.model_fields.items() if (n := _elsewhere(key, f))), None
        )
    return f"{'.'.join(path)} is not a known key{kind}{hint(near)}: the keys here are {', '.join(keys)}"


def _elsewhere(key: str, field: FieldInfo) -> str | None:
    name = ALSO_CALLED.get(key)
    return name if name in _keys(field.annotation) else None


def _keys(annotation: Any) -> list[str]:
    inner = part(annotation)
    return list(inner.model_fields) if inner else []


def _walk(loc: Sequence[int | str]) -> tuple[tuple[str, ...], type[BaseModel], FieldInfo | None]:
    """Follow pydantic's location to a field and stop there: a component of a vector counts as the vector."""
    owner: type[BaseModel] = Scene
    field: FieldInfo | None = None
    path: tuple[str, ...] = ()
    rest = list(loc)
    while rest:
        key = str(rest.pop(0))
        path = (*path, key)
        field = owner.model_fields.get(key)
        if field is None:
            return path, owner, None
        inner = part(field.annotation)
        if inner:
            owner = inner
            continue
        (_, shaped), table = entry_models(field.annotation), table_of_list(field.annotation)
        if not rest or not (shaped or table):
            break
        path = (*path, str(rest.pop(0)))
        if shaped and not rest:
            break
        owner = table or shaped[str(rest.pop(0))]
    return path, owner, field


def _value(path: tuple[str, ...], data: Any) -> Any:
    try:
        return follow(data, path)
    except KeyError:
        return None
