"""What a page may ask for. Everything that arrives is checked here; what is not one of these is dropped.

A new command is a class here, its name in `AnyCommand`, and its case in the player that obeys it;
`python -m neve.viewer.protocol.document` writes its type for the page.
"""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import AfterValidator, BaseModel, ConfigDict, Field, TypeAdapter, ValidationError

Number = Annotated[float, Field(ge=-1e6, le=1e6, allow_inf_nan=False)]
Vector = tuple[Number, Number, Number]
Positive = Annotated[float, Field(gt=0, le=1e4, allow_inf_nan=False)]
Amount = Annotated[float, Field(ge=-1e12, le=1e12, allow_inf_nan=False)]
Name = Annotated[str, Field(min_length=1, max_length=200)]


def _rising(limits: tuple[float, float]) -> tuple[float, float]:
    if limits[1] - limits[0] <= 1e-6 * max(abs(limits[0]), abs(limits[1])):
        raise ValueError("the last colour needs a greater value than the first")
    return limits


class Command(BaseModel):
    """Hold one command of a page: frozen, no unknown keys."""

    model_config = ConfigDict(extra="forbid", frozen=True)


class Acknowledge(Command):
    """Say that the state number `version` has been drawn."""

    do: Literal["acknowledge"]
    version: int = Field(ge=0, le=2**53)


class ColorMode(Command):
    """Choose the colours of this page, with the values of the first and the last one, or found from the snow.

    `log` spaces the colours between them by powers.
    """

    do: Literal["color_mode"]
    mode: Name
    limits: Annotated[tuple[Amount, Amount], AfterValidator(_rising)] | None = None
    log: bool = False


class Play(Command):
    """Play."""

    do: Literal["play"]


class Pause(Command):
    """Pause."""

    do: Literal["pause"]


class Frame(Command):
    """Play one frame, and pause."""

    do: Literal["frame"]


class Restart(Command):
    """Begin again; a live run, with all changes to the scene."""

    do: Literal["restart"]


class Speed(Command):
    """Set how many simulated seconds pass in one second at most."""

    do: Literal["speed"]
    factor: Annotated[float, Field(ge=0.001, le=100)]


class Seek(Command):
    """Show a frame of a recorded run: number `frame` of those that it has, or the one next to `time` [s]."""

    do: Literal["seek"]
    frame: Annotated[int, Field(ge=0, le=10**9)] = 0
    time: Amount | None = None


class Plot(Command):
    """Tell the figures over time, now and from now on."""

    do: Literal["plot"]


class Library(Command):
    """Tell which scenes and runs lie in the served folders."""

    do: Literal["library"]


class Open(Command):
    """Play another scene that comes with Neve, or a scene or run of the library."""

    do: Literal["open"]
    scene: Name


class Piece(Command):
    """Bring a piece of a file that was dropped: from byte number `at`, of so many bytes; `data` in base64."""

    do: Literal["piece"]
    name: Name
    at: int = Field(ge=0, le=2**25)
    of: int = Field(ge=1, le=24 * 2**20)
    data: Annotated[str, Field(min_length=4, max_length=15_000)]


class Set(Command):
    """Change a value of the scene: `path` as in --set."""

    do: Literal["set"]
    path: Name
    value: bool | int | float | str | Annotated[list[float], Field(max_length=1000)] | None


class Add(Command):
    """Add a body or snow of one `shape` at a point [m]; `kind` is a list of the scene."""

    do: Literal["add"]
    kind: Name
    shape: Name
    at: Vector


class Enlarge(Command):
    """Add a table that is left out, or one more entry to a list of tables: "colliders.1.keyframes"."""

    do: Literal["enlarge"]
    path: Name


class Undo(Command):
    """Take back the last change of the scene."""

    do: Literal["undo"]


class Redo(Command):
    """Do again what was taken back last."""

    do: Literal["redo"]


class Delete(Command):
    """Delete an entry of the scene, or a table in one: "colliders.1", "sources.0.variation"."""

    do: Literal["delete"]
    name: Name


class Move(Command):
    """Put the solid `name` at a position [m] with a rotation vector [degrees]; `done` ends the drag."""

    do: Literal["move"]
    name: Name
    position: Vector
    rotation: Vector | None = None
    done: bool = False


class Throw(Command):
    """Throw a ball of snow from a point [m] along a direction, with a speed [m/s]; radius [m]."""

    do: Literal["throw"]
    origin: Vector
    direction: Vector
    speed: Annotated[float, Field(ge=0, le=100)] = 12.0
    radius: Annotated[float, Field(gt=0, le=10)] = 0.15


class Touch(Command):
    """Push or grab the snow within `radius` [m] of a point [m] that moves with a velocity [m/s]."""

    do: Literal["touch"]
    tool: Literal["push", "grab"]
    point: Vector
    velocity: Vector
    radius: Positive
    done: bool = False


class Pull(Command):
    """Pull a body by a spring: from a point of its own frame [m] to a target [m]; `done` lets it go."""

    do: Literal["pull"]
    name: Name
    grip: Vector
    target: Vector
    done: bool = False


class Drive(Command):
    """Hold the control `name` of a motor or robot at a value; without one, the scene has it again."""

    do: Literal["drive"]
    name: Name
    value: Number | None = None


class PageCamera(BaseModel):
    """Hold a page's camera: points [m], vertical angle [degrees], size of the picture [px]."""

    model_config = ConfigDict(extra="forbid", frozen=True)
    position: Vector
    target: Vector
    up: Vector = (0.0, 0.0, 1.0)
    fov: Annotated[float, Field(gt=1, lt=170)] = 40.0
    width: Annotated[int, Field(ge=16, le=4096)] = 1280
    height: Annotated[int, Field(ge=16, le=4096)] = 720


class Record(Command):
    """Begin or end the recording of a live run."""

    do: Literal["record"]
    on: bool


class Picture(Command):
    """Draw a PNG with the page's camera."""

    do: Literal["picture"]
    camera: PageCamera


class Film(Command):
    """Make a film of all frames of the run, or of the last recording, with the page's camera."""

    do: Literal["film"]
    camera: PageCamera


class Replay(Command):
    """Make a page that plays the run by itself."""

    do: Literal["replay"]


class Save(Command):
    """Write the scene as TOML; with `camera`, with the page's camera."""

    do: Literal["save"]
    camera: PageCamera | None = None


AnyCommand = Annotated[
    Acknowledge | ColorMode | Play | Pause | Frame | Restart | Speed | Seek | Plot | Library | Open | Piece
    | Set | Add | Enlarge | Delete | Undo | Redo | Move | Throw | Touch | Pull | Drive | Record | Picture
    | Film | Replay | Save,
    Field(discriminator="do"),
]  # fmt: skip
_ADAPTER: TypeAdapter[Any] = TypeAdapter(AnyCommand)

MOST_BYTES = 16_384
"""A command is a few hundred bytes; more is no command."""


def read(message: str | bytes) -> Command | None:
    """Return the command that a page sent, or None for anything else."""
    if len(message) > MOST_BYTES:
        return None
    try:
        command = _ADAPTER.validate_json(message)
    except (ValidationError, ValueError, RecursionError):
        return None
    return command if isinstance(command, Command) else None
