"""The named snows that `snow.kind` knows, as src/neve/assets/snow_kinds.toml lists them."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Literal, TypeAlias

from neve.scene.values.choices import DEFAULT_LAW

PATH = Path(__file__).parents[2] / "assets" / "snow_kinds.toml"
Tag = Literal["quoted", "derived", "chosen"]
NOTHING: Mapping[str, Any] = MappingProxyType({})


@dataclass(frozen=True)
class SnowKind:
    """Hold one named snow.

    Attributes:
        about: what it is, in one line
        source: where the constants come from
        tag: how sure they are
        law: its constitutive law
        constants: keys of [snow] -> values [SI]
        structure, variation, profile: keys of a source, for sources that have none of their own
    """

    about: str
    source: str
    tag: Tag
    law: str = DEFAULT_LAW
    constants: Mapping[str, float] = field(default_factory=lambda: NOTHING)
    structure: str = ""
    variation: Mapping[str, Any] = field(default_factory=lambda: NOTHING)
    profile: Mapping[str, Any] = field(default_factory=lambda: NOTHING)


SNOWS: Mapping[str, SnowKind] = {
    name: SnowKind(**table) for name, table in tomllib.loads(PATH.read_text(encoding="utf-8")).items()
}
"""Kind -> snow, in the order of the file."""
DEFAULT_KIND = next(iter(SNOWS))
"""The kind of a scene that names none."""

if TYPE_CHECKING:
    Kind: TypeAlias = str
else:
    Kind = Literal[tuple(SNOWS)]
"""The word that picks a snow."""
