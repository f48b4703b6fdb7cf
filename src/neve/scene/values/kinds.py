"""Take the annotation of a field apart: what kind of value it holds, and within which limits."""

from __future__ import annotations

import types
from dataclasses import dataclass, field
from typing import Annotated, Any, Literal, Union, get_args, get_origin

from pydantic import GetCoreSchemaHandler
from pydantic.fields import FieldInfo
from pydantic_core import CoreSchema, core_schema

from neve.registry import Registry

LIMITS = ("gt", "ge", "lt", "le")


class OneOf:
    """Mark a word that stands in a registry, where users can put more while the program runs."""

    def __init__(self, registry: Registry) -> None:
        self.registry = registry

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        return core_schema.no_info_after_validator_function(self.registry.checked, handler(source))


@dataclass(frozen=True)
class Kind:
    """Hold what an annotation allows.

    Attributes:
        name: "choice" of words or numbers, "union" of kinds, "vector" of a fixed length, "list" of any
            length, "text", "switch", "integer", "number" or "table"
        choices: what a choice is between
        members: the kinds of a union, without None; the kind of each entry of a vector or list
        optional: whether None is allowed too
        count: entries of a vector
        limits: bounds of a number by their names in pydantic: gt, ge, lt, le
        min_length: least number of characters of a text
    """

    name: str
    choices: tuple[Any, ...] = ()
    members: tuple[Kind, ...] = ()
    optional: bool = False
    count: int = 0
    limits: dict[str, float] = field(default_factory=dict)
    min_length: int = 0


def kind_of(annotation: Any, metadata: list[Any]) -> Kind:
    """Return the kind of values that `annotation`, with pydantic's `metadata` of the field, allows."""
    origin, arguments = get_origin(annotation), get_args(annotation)
    if origin is Annotated:
        inner, *more = arguments
        flat = [m for extra in more for m in (extra.metadata if isinstance(extra, FieldInfo) else [extra])]
        return kind_of(inner, flat + metadata)
    if origin is Literal:
        return Kind("choice", choices=arguments)
    if origin in (Union, types.UnionType):
        members = tuple(kind_of(item, metadata) for item in arguments if item is not type(None))
        return Kind("union", members=members, optional=type(None) in arguments)
    if origin is tuple:
        member = (kind_of(arguments[0], []),)
        if arguments[-1] is Ellipsis:
            return Kind("list", members=member)
        return Kind("vector", members=member, count=len(arguments))
    registered = [mark.registry.names() for mark in metadata if isinstance(mark, OneOf)]
    if registered:
        return Kind("choice", choices=registered[0])
    if annotation is str:
        return Kind("text", min_length=max((getattr(m, "min_length", 0) for m in metadata), default=0))
    if annotation is bool:
        return Kind("switch")
    if annotation in (int, float):
        limits = {name: getattr(m, name) for m in metadata for name in LIMITS if hasattr(m, name)}
        return Kind("integer" if annotation is int else "number", limits=limits)
    return Kind("table")
