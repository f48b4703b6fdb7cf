"""What the server sends to the pages: the one definition of its messages; commands.py has the commands.

`python -m neve.viewer.protocol.document` writes both as types for the page.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Annotated, Any, Literal, NotRequired, TypedDict

Vector = tuple[float, float, float]


def vector(numbers: Iterable[float]) -> Vector:
    """Return three numbers as a message holds them."""
    x, y, z = (float(number) for number in numbers)
    return x, y, z


class PlayerState(TypedDict):
    """Whether it plays, and how fast."""

    playing: bool
    speed: Annotated[float, "simulated seconds in a second, at most"]
    frames: Annotated[int, "frames to seek in; 0 for a live run"]
    recording: bool
    recorded: Annotated[int, "frames of the recording"]
    undo: Annotated[str, "what can be taken back, in words, or empty"]
    redo: Annotated[str, "what can be done again, in words, or empty"]


class Camera(TypedDict):
    """The camera of a scene."""

    position: Annotated[Vector, "[m]"]
    target: Annotated[Vector, "[m]"]
    up: Vector
    fov: Annotated[float, "vertical angle [degrees]"]


class Light(TypedDict):
    """Sun and sky in the units of the film."""

    sun: Annotated[Vector, "unit vector towards the sun"]
    sun_color: Vector
    sky_color: Vector


class Falling(TypedDict):
    """Flakes in the air: the constants of their law, neve.render.falling, which the page computes, too."""

    count: Annotated[int, "flakes of a cube of air, which is repeated without end"]
    edge: Annotated[float, "of the cube [m]"]
    around: Annotated[float, "how far from the camera flakes are, in distances to its target"]
    velocity: Annotated[Vector, "on average [m/s]"]
    pace: Annotated[tuple[float, float], "least speed and range of speeds over the average"]
    radius: Annotated[float, "on average [m]"]
    spread: Annotated[tuple[float, float], "least radius and range of radii over the average"]
    sway: Annotated[float, "how far a flake swings aside [m]"]
    period: Annotated[float, "of a swing along x, on average [s]"]
    second: Annotated[float, "swings along y over those along x"]
    numbers: Annotated[list[int], "numbers of the random numbers of place, pace, phase and radius"]
    open: Annotated[float, "how long the shutter is open [s]"]
    least: Annotated[float, "radius of the image of a flake that is drawn smaller than it is [px]"]
    faintest: Annotated[float, "share of a pixel below which a flake is not drawn"]
    nearest: Annotated[float, "distance from the camera [m]"]
    light: Vector


class Mesh(TypedDict):
    """Triangles, in base64."""

    vertices: Annotated[str, "corners [m], float32, little endian"]
    faces: Annotated[str, "three corners a triangle, uint32, little endian"]


class Solid(TypedDict):
    """A solid as it is drawn; its position and rotation come with each state."""

    name: Annotated[str, 'its place in the scene: "colliders.1"']
    shape: str
    half: Annotated[Vector, "half of its size along each axis [m]"]
    color: Vector
    visible: bool
    ground: Annotated[bool, "drawn as ground"]
    pulled: Annotated[NotRequired[bool], "hangs on a joint, or is part of a robot: is pulled, not moved"]
    mesh: NotRequired[Mesh]


class LegendName(TypedDict):
    """One line of a legend of names."""

    value: Annotated[int | None, "whose colour stands before it; null: none does"]
    text: str


class Mode(TypedDict):
    """A colour mode."""

    name: str
    label: str
    unit: str
    classes: Annotated[bool, "the values are names, not amounts"]
    stops: Annotated[list[tuple[int, int, int]], "colours from the least to the greatest value, 0 to 255"]
    names: Annotated[list[LegendName], "the legend of a mode whose values are names"]


class Drawn(TypedDict):
    """What is drawn beside the particles, and how large a particle is."""

    name: str
    about: str
    caption: Annotated[str, "what is to be said of the scene, lest anyone is misled; empty: nothing"]
    fps: float
    dx: Annotated[float, "[m]"]
    spacing: Annotated[float, "of particles in snow at rest [m]"]
    cell: Annotated[float, "size of a cell of the film's density grid [m]"]
    camera: Camera
    light: Light
    falling: Annotated[Falling | None, "null: no flakes are in the air"]
    solids: list[Solid]
    modes: list[Mode]


class Control(TypedDict):
    """How a value is edited."""

    control: Literal["number", "choice", "switch", "vector", "list", "text"]
    choices: NotRequired[list[Any]]
    optional: NotRequired[bool]
    count: Annotated[NotRequired[int], "numbers of a vector"]
    whole: Annotated[NotRequired[bool], "only whole numbers"]
    gt: NotRequired[float]
    ge: NotRequired[float]
    lt: NotRequired[float]
    le: NotRequired[float]


class Field(Control):
    """A field of a section of the panel."""

    path: Annotated[str, 'as in --set: "snow.xi"']
    name: str
    text: Annotated[str, "meaning"]
    unit: str
    allowed: Annotated[str, "what it may hold, in words"]
    source: Annotated[str, "where its default comes from"]
    default: Any
    value: Any
    live: Annotated[bool, "a change acts at once; else when the scene begins anew"]
    now: Annotated[NotRequired[Any], "what the run goes on with until then, where that differs from value"]


class Section(TypedDict):
    """A section of the panel: a table of the scene."""

    path: str
    title: str
    text: Annotated[str, "meaning"]
    parent: Annotated[str, "path of the section that it lies in, or empty"]
    can: Annotated[Literal["", "add", "delete"], "what can be done with the whole section"]
    fields: list[Field]


class Addable(TypedDict):
    """A shape that can be added."""

    shape: Annotated[str, '"mesh:rock", "terrain:alps.tif"']
    half: Annotated[Vector, "half of the edges of the box that stands on its place [m]; zeros if endless"]


class RobotControl(TypedDict):
    """A control of a motor or a robot."""

    name: str
    low: float
    high: float
    value: float


class SceneMessage(Drawn):
    """All that a page needs beside the states; sent again when it changes."""

    kind: Literal["scene"]
    number: Annotated[int, "counts the changes"]
    live: bool
    duration: Annotated[float, "run.duration [s]"]
    player: PlayerState
    panel: list[Section]
    presets: Annotated[dict[str, str], "scenes that can be opened, and what they show"]
    controls: Annotated[list[RobotControl], "of motors and robots"]
    addable: Annotated[dict[str, list[Addable]], "list of the scene -> shapes that can be added to it"]


class PlayerMessage(PlayerState):
    """The player's state has changed."""

    kind: Literal["player"]


class RefusedMessage(TypedDict):
    """A command was refused, and why."""

    kind: Literal["refused"]
    sentence: str
    path: Annotated[str, "of the value that was refused, or empty"]


class NoteMessage(TypedDict):
    """Something that a user should know, and no fault."""

    kind: Literal["note"]
    sentence: str


class ProgressMessage(TypedDict):
    """An export goes on."""

    kind: Literal["progress"]
    what: str
    done: int
    of: int


class FileMessage(TypedDict):
    """An export is finished."""

    kind: Literal["file"]
    name: str
    url: str
    place: Annotated[str, "path on the server's machine"]
    bytes: int


class FigureColumn(TypedDict):
    """A figure that can be plotted."""

    name: str
    unit: str


class FiguresMessage(TypedDict):
    """Figures over time: rows from number `first` on; from 0 on, all."""

    kind: Literal["figures"]
    first: int
    columns: list[FigureColumn]
    rows: Annotated[list[list[float | None]], "number of the frame, then a value for each column"]


class LibraryEntry(TypedDict):
    """A scene or a run that can be opened."""

    name: str
    kind: Literal["scene", "run"]


class LibraryMessage(TypedDict):
    """What lies in the served folders."""

    kind: Literal["library"]
    entries: list[LibraryEntry]


class DroppedMessage(TypedDict):
    """A mesh or a height map that this page has dropped is there, and can be added."""

    kind: Literal["dropped"]
    what: Addable


Message = (
    SceneMessage
    | PlayerMessage
    | RefusedMessage
    | NoteMessage
    | ProgressMessage
    | FileMessage
    | FiguresMessage
    | LibraryMessage
    | DroppedMessage
)
"""What comes as text."""


class Facts(TypedDict, total=False):
    """Figures of a run; a recorded one has particles alone."""

    particles: int
    steps: int
    dt: Annotated[float, "mean time step [s]"]
    bound: Annotated[str, "what bounds the time step"]
    rejected: Annotated[int, "steps that were rejected and tried again"]
    pace: Annotated[float, "simulated seconds in a second"]
    keyed: Annotated[dict[str, list[float]], "what keyframes change, as it is now"]
    stages: Annotated[dict[str, float], "share of the time that each stage takes, in the solver's order"]


class StateHead(TypedDict):
    """The head of a state, which comes as bytes; state.py has the layout."""

    kind: Literal["state"]
    version: Annotated[int, "counts the states"]
    n: Annotated[int, "particles"]
    low: Annotated[Vector, "position of q = 0 [m]"]
    step: Annotated[Vector, "position = low + step q [m]"]
    mode: Annotated[str, "colour mode that the values belong to"]
    limits: Annotated[tuple[float, float], "values that get the first and the last colour"]
    log: Annotated[bool, "the value is spaced by powers between the limits"]
    classes: Annotated[bool, "the values are names"]
    time: Annotated[float, "simulated [s]"]
    frame: int
    scene: Annotated[int, "number of the scene message that it belongs to"]
    poses: Annotated[
        list[list[float]], "position [m] and rotation, row by row, of each solid: twelve numbers"
    ]
    facts: Facts


class ReplayHead(Drawn):
    """The head of a replay; exports/replay.py says how the positions are packed."""

    n: Annotated[int, "particles"]
    low: Annotated[Vector, "position of q = 0 [m]"]
    step: Annotated[Vector, "position = low + step q [m]"]
    keys: Annotated[list[int], "frames whose positions are held"]
    frames: int
    times: Annotated[list[float], "of each frame [s]"]
    poses: Annotated[list[list[list[float]]], "of each frame: as in a state"]
