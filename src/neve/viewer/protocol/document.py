"""Write commands and messages as types of the page: `python -m neve.viewer.protocol.document`.

The page has no build step, so both files are kept in the tree; a test sees that they are current.
"""

from __future__ import annotations

import types
from collections.abc import Iterator
from pathlib import Path
from typing import (
    Annotated,
    Any,
    Literal,
    NotRequired,
    Union,
    get_args,
    get_origin,
    get_type_hints,
    is_typeddict,
)

from pydantic import BaseModel
from pydantic_core import PydanticUndefined

from neve.viewer.protocol import commands, messages, state

PAGE = Path(__file__).parents[1] / "page"
COMMANDS = """\
// What the page says to the server: types alone.
// Made from src/neve/viewer/protocol by `python -m neve.viewer.protocol.document`; do not edit it by hand.

export {};
"""
MESSAGES = """\
// What the server says to the page.
// Made from src/neve/viewer/protocol by `python -m neve.viewer.protocol.document`; do not edit it by hand.

/** Greatest number of a position or a value in a state; a particle with three of them has no position. */
export const MOST = {most};

/** Bytes of a particle in a state. */
export const PARTICLE_BYTES = {bytes};
"""
PLAIN = {bool: "boolean", int: "number", float: "number", str: "string", type(None): "null", Any: "any"}


def documents() -> dict[Path, str]:
    """Return the text of each file that is made."""
    return {PAGE / "commands.js": _commands(), PAGE / "protocol.js": _messages()}


def _commands() -> str:
    union = get_args(get_args(commands.AnyCommand)[0])
    parts = [COMMANDS, *(_command(model) for model in (commands.PageCamera, *union))]
    parts.append(_union("Command", union, "What a page may ask for."))
    return "\n".join(parts)


def _messages() -> str:
    parts = [MESSAGES.format(most=state.MOST, bytes=state.PARTICLE_BYTES)]
    tables = [value for value in vars(messages).values() if is_typeddict(value)]
    parts += [_message(table) for table in tables]
    parts.append(_union("Message", get_args(messages.Message), "What the server sends as text."))
    return "\n".join(parts)


def _command(model: type[BaseModel]) -> str:
    properties = []
    for name, field in model.model_fields.items():
        optional = field.default is not PydanticUndefined
        properties.append(_property(_type(field.annotation), name, "", optional))
    return _typedef(_name(model), model.__doc__ or "", properties)


def _message(table: type) -> str:
    properties = []
    total: bool = table.__total__  # type: ignore[attr-defined]
    for name, annotation in get_type_hints(table, include_extras=True).items():
        text = next(_texts(annotation), "")
        properties.append(_property(_type(annotation), name, text, not total or _may_lack(annotation)))
    return _typedef(table.__name__, table.__doc__ or "", properties)


def _texts(annotation: Any) -> Iterator[str]:
    if get_origin(annotation) is Annotated:
        yield from (extra for extra in get_args(annotation)[1:] if isinstance(extra, str))


def _may_lack(annotation: Any) -> bool:
    return get_origin(annotation) is NotRequired or (
        get_origin(annotation) is Annotated and _may_lack(get_args(annotation)[0])
    )


def _type(annotation: Any) -> str:
    """Return an annotation in the words of TypeScript."""
    origin, items = get_origin(annotation), get_args(annotation)
    if origin in (Annotated, NotRequired):
        return _type(items[0])
    if origin is Literal:
        return " | ".join(f'"{item}"' for item in items)
    if origin in (Union, types.UnionType):
        return " | ".join(dict.fromkeys(_type(item) for item in items))
    if origin is tuple:
        return f"[{', '.join(_type(item) for item in items)}]"
    if origin is list:
        inner = _type(items[0])
        return f"({inner})[]" if "|" in inner else f"{inner}[]"
    if origin is dict:
        return f"Record<{_type(items[0])}, {_type(items[1])}>"
    return PLAIN[annotation] if annotation in PLAIN else _name(annotation)


def _name(member: type) -> str:
    """Return the name of a type; commands have a suffix, since some are called like types of JavaScript."""
    return f"{member.__name__}Command" if issubclass(member, commands.Command) else member.__name__


def _property(type_: str, name: str, text: str, optional: bool) -> str:
    return f" * @property {{{type_}}} {f'[{name}]' if optional else name} {text}".rstrip()


def _typedef(name: str, doc: str, properties: list[str]) -> str:
    about = " ".join(doc.split())
    return "\n".join(["/**", f" * {about}", f" * @typedef {{object}} {name}", *properties, " */", ""])


def _union(name: str, members: tuple[type, ...], about: str) -> str:
    names = " | ".join(_name(member) for member in members)
    return f"/**\n * {about}\n * @typedef {{{names}}} {name}\n */\n"


if __name__ == "__main__":
    for file, text in documents().items():
        file.write_text(text, encoding="utf-8")
