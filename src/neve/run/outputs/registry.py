"""The kinds of outputs of a run: those that come with Neve, and those that users register."""

from __future__ import annotations

import inspect
import re
from collections.abc import Callable, Collection
from dataclasses import dataclass
from importlib import import_module
from typing import TYPE_CHECKING, Annotated, Any, Literal, TypeVar, get_type_hints

from pydantic import Strict, create_model

from neve.run.outputs.context import Output
from neve.scene.schema.outputs import OutputOptions, Scheduled
from neve.scene.values.fields import entry
from neve.schedule import EveryFrames, EverySeconds, Schedule

if TYPE_CHECKING:
    from neve.scene.schema.scene import Scene

BUILT_IN = (
    "frames",
    "picture",
    "film",
    "export",
    "fragments",
    "solids",
    "log",
    "checkpoint",
)
"""Modules of this package that register an output each, in the order in which a frame is written."""

Made = TypeVar("Made", bound=type[Output])


@dataclass(frozen=True)
class OutputKind:
    """Hold a registered kind of output.

    Attributes:
        name: the word in a scene, `kind = "film"`
        options: class of the entries of `[[outputs]]`
        make: class of the output; it takes the options by their names
        unasked: whether a run of a scene has this output although no entry asks for it
        completes: whether it marks its frame as complete, and so is written last
    """

    name: str
    options: type[OutputOptions]
    make: Callable[..., Output]
    unasked: Callable[[Scene], bool]
    completes: bool


_kinds: dict[str, OutputKind] = {}


def register_output(
    name: str,
    options: type[OutputOptions] | None = None,
    unasked: Callable[[Scene], bool] = lambda scene: False,
    completes: bool = False,
) -> Callable[[Made], Made]:
    """Register the class below as an output, so that a scene can ask for it by `kind = "NAME"`.

    name: the word in `[[outputs]]`
    options: class of the entries; by default made from the parameters of the class, each of which then needs
        a default. A parameter `name` is the name of the file that it writes.
    unasked, completes: see `OutputKind`

    Errors: ValueError for a name that is none, that is taken, or that comes with Neve, a class without write
        or close, or a parameter without default, with a name that entries have already, or with a default
        that is not allowed.
    """

    def register(made: Made) -> Made:
        if not re.fullmatch(r"[^\W\d][\w-]*", name):
            raise ValueError(f'"{name}" is no name of an output: use letters, digits, _ and -')
        if name in BUILT_IN and made.__module__ != f"{__package__}.{name}":
            raise ValueError(f'"{name}" is an output that comes with Neve: choose another name')
        before = _kinds.get(name)
        if before and _place(before.make) != _place(made):
            raise ValueError(f'the output "{name}" is registered already, by {_place(before.make)}')
        entries = options or _options_of(name, made)
        if lacks := [word for word in ("write", "close") if not callable(getattr(made, word, None))]:
            raise ValueError(f'the output "{name}" needs a method {" and ".join(lacks)}')
        entries()  # its defaults are allowed, or no scene could have outputs from now on
        _kinds[name] = OutputKind(name, entries, made, unasked, completes)
        return made

    return register


def _place(made: object) -> str:
    """Return where a class stands; one that is defined again, as in a notebook, stands in the same place."""
    return f"{getattr(made, '__module__', '')}.{getattr(made, '__qualname__', '')}"


def kinds() -> dict[str, OutputKind]:
    """Return all kinds by name, in the order in which a frame is written."""
    for module in BUILT_IN:
        import_module(f"{__package__}.{module}")
    built_in = [_kinds[name] for name in BUILT_IN]
    own = [kind for name, kind in _kinds.items() if name not in BUILT_IN]
    return {kind.name: kind for kind in sorted(built_in + own, key=lambda kind: kind.completes)}


def entries(scene: Scene) -> list[OutputOptions]:
    """Return all outputs of a run of `scene`, in the order in which a frame is written.

    These are the entries of its `[[outputs]]`, and what a run has unasked, unless an entry writes that file.
    """
    found: list[OutputOptions] = []
    for kind in kinds().values():
        asked = [given for given in scene.outputs if given.kind == kind.name]
        usual = kind.options()
        if kind.unasked(scene) and usual.file() not in [given.file() for given in asked]:
            found.append(usual)
        found += asked
    return found


def usual_files(among: Collection[str] | None = None) -> set[str]:
    """Return what outputs, or those `among` them, write when their entries name no other file."""
    return {kind.options().file() for kind in kinds().values() if among is None or kind.name in among} - {""}


def schedule_of(given: OutputOptions, output: Output, fps: int) -> Schedule:
    """Return when an output is due: as its entry says, or as is usual for its class, or at every frame."""
    if isinstance(given, Scheduled) and given.every_frames is not None:
        return EveryFrames(given.every_frames)
    if isinstance(given, Scheduled) and given.every_seconds is not None:
        return EverySeconds(given.every_seconds, fps)
    return own_schedule(output)


def own_schedule(output: Output) -> Schedule:
    """Return the attribute `schedule` of an output; every frame if it has none."""
    schedule: Schedule = getattr(output, "schedule", None) or EveryFrames()
    return schedule


def _options_of(name: str, made: type[Output]) -> type[OutputOptions]:
    """Make the class of the entries from the parameters of the output's class."""
    hints = get_type_hints(made.__init__, include_extras=True)
    fields: dict[str, Any] = {"kind": (Literal[name], entry(name, "What is written.", ""))}
    for key, parameter in inspect.signature(made).parameters.items():
        if key.startswith("_") or hasattr(Scheduled, key) or key in Scheduled.model_fields:
            raise ValueError(f'the output "{name}" cannot be asked for by a scene: call "{key}" otherwise')
        if parameter.default is inspect.Parameter.empty:
            raise ValueError(f'the output "{name}" cannot be asked for by a scene: give "{key}" a default')
        hint = hints.get(key, type(parameter.default))
        strict = Annotated[hint, Strict()] if hint in (int, float, bool) else hint
        fields[key] = (strict, entry(parameter.default, f"Parameter of {made.__name__}.", ""))
    options: type[OutputOptions] = create_model(f"{made.__name__}Options", __base__=Scheduled, **fields)
    return options
