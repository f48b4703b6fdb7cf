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


REPOSE = 50.0
"""Angle of repose of fluffy new snow, which kinds without one have [degrees]: 48 to 53 in heaps of 1 m."""


@dataclass(frozen=True)
class Repose:
    """Hold the angle of repose of fallen snow of a kind [degrees], where it is from, and how sure it is."""

    degrees: float
    source: str
    tag: Tag


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
        repose: at which angle it lies when it has fallen; None where nothing says so
    """

    about: str
    source: str
    tag: Tag
    law: str = DEFAULT_LAW
    constants: Mapping[str, float] = field(default_factory=lambda: NOTHING)
    structure: str = ""
    variation: Mapping[str, Any] = field(default_factory=lambda: NOTHING)
    profile: Mapping[str, Any] = field(default_factory=lambda: NOTHING)
    repose: Repose | None = None

    @property
    def angle_of_repose(self) -> float:
        """Angle at which it lies when it has fallen [degrees]."""
        return self.repose.degrees if self.repose else REPOSE


def _kind(table: dict[str, Any]) -> SnowKind:
    """Return the snow that a table of the file describes."""
    repose = table.pop("repose", None)
    return SnowKind(**table, repose=Repose(**repose) if repose else None)


SNOWS: Mapping[str, SnowKind] = {
    name: _kind(table) for name, table in tomllib.loads(PATH.read_text(encoding="utf-8")).items()
}
"""Kind -> snow, in the order of the file."""
DEFAULT_KIND = next(iter(SNOWS))
"""The kind of a scene that names none."""

if TYPE_CHECKING:
    Kind: TypeAlias = str
else:
    Kind = Literal[tuple(SNOWS)]
"""The word that picks a snow."""
