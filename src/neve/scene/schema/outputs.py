"""Describe what a run writes, and how often: the entries of `[[outputs]]`."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from typing import Annotated, Any, ClassVar, NamedTuple, Self, Union

from pydantic import BeforeValidator, Field, SerializeAsAny, TypeAdapter, model_validator

from neve.scene.values.fields import SHORTEST, Part, Real, Whole, entry, rounded_up, wrong

RESERVED = ("run.json", "scene.toml", "assets")
"""What lies in a run folder and is no output."""


LONGEST = 240
"""Bytes in the name of a file at most: systems allow 255, and parts of a film have longer names."""


class Sizes(NamedTuple):
    """Bytes of what a run writes at a moment: a file of frames/, all of the state, rows for all solids."""

    frame: float
    state: float
    solids: float


class Need(NamedTuple):
    """What an output takes in a whole run: bytes of disk, and pictures that are drawn."""

    bytes: float
    pictures: int = 0


class OutputOptions(Part):
    """Hold an entry of `[[outputs]]`; each kind has a class of its own."""

    suffix: ClassVar[str] = ""
    """What the option `name`, if the kind has it, must end in."""

    kind: str = entry("", "What is written.", "")

    @model_validator(mode="after")
    def _plain_name(self) -> Self:
        if not re.fullmatch(r"\w[\w.-]*", self.file() or "x") or not self.file().endswith(self.suffix):
            ending = f" that ends in {self.suffix}" if self.suffix else ""
            raise wrong("name", f"must be the name of a file{ending}, of letters, digits and . _ - alone")
        if len(self.file().encode()) > LONGEST:
            raise wrong("name", f"must be at most {LONGEST} bytes long")
        return self

    def file(self) -> str:
        """Return the name of what the output writes in the run folder; "" if it is not known."""
        return str(getattr(self, "name", ""))

    def need(self, sizes: Sizes, due: int) -> Need | None:
        """Return what the output takes that is due so many times; None if that is not known before."""
        return None

    def options(self) -> dict[str, Any]:
        """Return the options of this kind alone, without what every entry has."""
        common = {*OutputOptions.model_fields, *Scheduled.model_fields}
        return {key: getattr(self, key) for key in type(self).model_fields if key not in common}


class Scheduled(OutputOptions):
    """Hold an entry with a schedule."""

    every_frames: Whole | None = entry(
        None, "Number of frames from one to the next, beginning with frame 0, the start.", "1", ge=1
    )
    every_seconds: Real | None = entry(
        None,
        "Simulated time from one to the next: the first frame at or after each multiple of it, beginning "
        "with frame 0.",
        "s",
        ge=SHORTEST,
        le=86400,
    )

    @model_validator(mode="after")
    def _one_of_both(self) -> Self:
        if self.every_frames is not None and self.every_seconds is not None:
            raise wrong("every_seconds", "must not stand beside every_frames: give one of the two")
        return self


def kinds() -> dict[str, type[OutputOptions]]:
    """Return the class of entries of each kind that is registered, by its word."""
    from neve.run.outputs.registry import kinds as registered

    return {name: kind.options for name, kind in registered().items()}


def _read(value: Any) -> Any:
    """Return the entry that a table describes; which keys it may have depends on its kind."""
    if isinstance(value, OutputOptions):
        return value
    union: Any = Annotated[Union[tuple(kinds().values())], Field(discriminator="kind")]  # noqa: UP007
    return TypeAdapter(union).validate_python(value)


class OpenList:
    """Mark the annotation of a list whose kinds of entries are registered while the program runs.

    tag: the key whose word picks the kind. models: the class of the entries for each word.
    """

    tag = "kind"

    def models(self) -> Mapping[str, type[OutputOptions]]:
        """Return the class of entries for each word."""
        return kinds()


OutputEntry = Annotated[SerializeAsAny[OutputOptions], BeforeValidator(_read), OpenList()]
"""An entry of `[[outputs]]`, of any kind."""


def conflict(outputs: Sequence[OutputOptions], fps: int) -> tuple[str, str] | None:
    """Return the key that is wrong with the list and the end of a sentence about it; None if all is well.

    Two entries must not write the same file, and none can be due more often than there are frames.
    """
    if not outputs:
        return None
    usual = {name: file for name, model in kinds().items() if (file := model().file())}
    taken: dict[str, str] = dict.fromkeys(RESERVED, "the run")
    for i, output in enumerate(outputs):
        seconds = getattr(output, "every_seconds", None)
        if seconds is not None and seconds * fps < 1.0 - 1e-12:
            return f"{i}.every_seconds", f"must be at least 1 / run.fps = {rounded_up(1.0 / fps)} [s]"
        others = {file: f"the output {kind}" for kind, file in usual.items() if kind != output.kind}
        name = output.file() or f"({output.kind})"
        owner = (others | taken).get(name)
        if owner and "name" in type(output).model_fields:
            return f"{i}.name", f"must not be {name}, which {owner} writes"
        if owner:
            return str(i), f"must not write what {owner} writes"
        taken[name] = f"outputs.{i}"
    return None
