"""Write docs/scene_format.md and the tables of snows in other pages: `python tools/scene_pages.py`."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

from pydantic import BaseModel
from pydantic.fields import FieldInfo

from neve.particles.constants import NEVER, contact_constants, without_counterpart
from neve.scene.reading.presets import PRESETS
from neve.scene.reading.snow_tables import as_table
from neve.scene.reading.validation_errors import shown
from neve.scene.schema.outputs import OutputOptions, Scheduled, kinds
from neve.scene.schema.roles import SHAPES
from neve.scene.schema.scene import (
    Body,
    Camera,
    CameraKeyframe,
    Collider,
    Control,
    Emitter,
    EmitterKeyframe,
    Heat,
    Keyframe,
    Light,
    Motor,
    Numerics,
    Profile,
    Robot,
    Run,
    Scene,
    Sink,
    Snow,
    SnowKeyframe,
    Source,
    Target,
    Variation,
    World,
    WorldKeyframe,
)
from neve.scene.schema.snow_kinds import SNOWS
from neve.scene.values.allowed import allowed, choices, part, source, unit

LISTS = {
    "source": "sources",
    "emitter": "emitters",
    "sink": "sinks",
    "collider": "colliders",
    "body": "bodies",
}
PATH = Path("docs") / "scene_format.md"  # from the root of the checkout
SNOWS_PATH = Path("docs") / "snows.md"
CONTACTS_PATH = Path("docs") / "particles.md"
BEGIN, END = (
    "<!-- table of snows: begin; written by `python tools/scene_pages.py` -->",
    "<!-- table of snows: end -->",
)

INTRODUCTION = """\
# The scene format

<!-- Written by `python tools/scene_pages.py` from src/neve/scene; change it there. -->

A scene is a TOML file. Units are SI (metres, seconds, kilograms; angles in degrees, spins in radians per
second), and z points up. Every key may be left out, except `shape` and the `kind` of an output, and a scene
needs at least one source or emitter.
An unknown key, a value outside its range or a misspelled word is an error that says what is allowed.
Every number has finite limits, and none may be nearer to 0 than 1e-30 without being 0. A source may take
2.7e8 particles (points of the box around it); about 260 bytes for each must be free, in the container if
there is one.

The same words lead to a value everywhere: in a file, `[numerics]` and `dx = 0.02`; on the command line,
`--set numerics.dx=0.02`; in Python, `scene.numerics.dx`. Entries of lists are numbered from 0:
`--set sources.0.radius=0.3`, `--set world.gravity.2=-1.62`.

`snow.kind` picks a named snow ([snows](snows.md)); the other keys of `[snow]` override what it brings. Each
law has constants of its own; setting one that the law does not use is an error. A source's own `snow` changes
single values of the scene's, unless it names a `kind`, or a law with other constants, and starts from that.
`--set 'snow={{kind="wet"}}'` replaces the whole table of a file.

A rotation is a vector: its direction is the axis, its length the angle. `[0, 0, 90]` is a quarter turn about
z, anticlockwise seen from above.

This is the preset `throw_ball`, complete:

```toml
{example}```
"""


def _meaning(model: type[BaseModel]) -> str:
    """Return the sentence about an output: the meaning of its kind."""
    return model.model_fields["kind"].description or ""


SECTIONS: tuple[tuple[str, str, type[BaseModel]], ...] = (
    ("[world]", "Surroundings.", World),
    ("[[world.keyframes]]", "Gravity at several times.", WorldKeyframe),
    ("[numerics]", "Grid, time step and particles.", Numerics),
    ("[snow]", "The snow of every source that does not say otherwise in `snow`.", Snow),
    (
        "[heat]",
        "Warming, melting, freezing and sintering ([heat.md](heat.md)); a scene without this "
        "table knows no heat.",
        Heat,
    ),
    (
        "[[snow_keyframes]]",
        "Constants of [snow] at several times; a source's or an emitter's own `snow` stays. The method "
        "particles has none. Snow that was pressed keeps its state.",
        SnowKeyframe,
    ),
    (
        "[[sources]]",
        "Where snow is at the start. Each source has these keys, and those of its shape.",
        Source,
    ),
    (
        "[sources.variation]",
        "Snow that differs from place to place: one field of noise, which moves with the snow.",
        Variation,
    ),
    ("[sources.profile]", "Snow that differs with depth or height: a crust, a soft core, layers.", Profile),
    (
        "[[emitters]]",
        "Where snow comes in during the run ([recipes](recipes.md#snow-that-comes-and-goes)). It leaves "
        "through a section of the shape: of a plane across `velocity`, through the middle of the shape, what "
        "lies in the shape. Each has these keys, and those of its shape.",
        Emitter,
    ),
    ("[[emitters.keyframes]]", "Velocities and rates at several times.", EmitterKeyframe),
    (
        "[[sinks]]",
        "Where snow is taken out during the run. Each has these keys, and those of its shape.",
        Sink,
    ),
    (
        "[[colliders]]",
        "Solids that snow meets, at rest or moved by a script. Each has these keys, and those of its shape.",
        Collider,
    ),
    ("[[colliders.keyframes]]", "A scripted motion.", Keyframe),
    (
        "[[bodies]]",
        "Solids that snow and other forces move. Each has these keys, and those of its shape, which say "
        "where it is at the start.",
        Body,
    ),
    ("[bodies.motor]", "What drives the joint of a body.", Motor),
    ("[[bodies.motor.keyframes]]", "Targets of a motor over time.", Target),
    ("[[robots]]", "Robots and vehicles from files, which snow moves too.", Robot),
    ("[[robots.controls]]", "Commands to the actuators of a robot, and when they are given.", Control),
    ("[camera]", "Camera of films and pictures ([film.md](film.md#the-camera)).", Camera),
    ("[[camera.keyframes]]", "Views at several times.", CameraKeyframe),
    ("[light]", "Light of the film.", Light),
    ("[run]", "Length of the run.", Run),
    (
        "[[outputs]]",
        "What a run writes ([the run folder](run_folder.md)), each entry with a `kind`, and how often. A run "
        "also writes what no entry names: frames, log, checkpoint, picture, film (`run.film`), fragments "
        "(`run.fragments`) and the table of its solids, if it has any; an entry that writes the same file "
        "takes its place. Give one of the two keys below; neither means every frame. The picture, which is "
        "drawn at the end, takes none. Kinds of your own: `neve.register_output`.",
        Scheduled,
    ),
    *((f'[[outputs]] with kind = "{kind}"', _meaning(model), model) for kind, model in kinds().items()),
)
"""Heading, sentence and model of every section, in the order of the document."""


def document() -> str:
    """Return the documentation of the scene format, as Markdown."""
    example = (PRESETS / "throw_ball.toml").read_text(encoding="utf-8")
    parts = [INTRODUCTION.format(example=example)]
    parts += [f"## Top\n\n{_table([('about', Scene.model_fields['about'])])}"]
    for heading, sentence, model in (*SECTIONS, *_shapes()):
        rows = [(name, field) for name, field in model.model_fields.items() if not _in_heading(name, model)]
        parts.append(f"## `{heading}`\n\n{sentence}\n" + (f"\n{_table(rows)}" if rows else ""))
    return "\n".join(parts)


def _in_heading(name: str, model: type[BaseModel]) -> bool:
    """Return whether the key is described in the heading, or in the section of all kinds of outputs."""
    if not issubclass(model, OutputOptions):
        return name == "shape"
    return name == "kind" or (model is not Scheduled and name in Scheduled.model_fields)


def _shapes() -> Iterator[tuple[str, str, type[BaseModel]]]:
    """Yield heading, sentence and model of every shape."""
    for word, shape in SHAPES.items():
        lists = ", ".join(f"`[[{LISTS[role]}]]`" for role in shape.roles)
        about = shape.model_fields["shape"].description
        yield f'shape = "{word}"', f"{about} For {lists}.", shape


def _table(rows: list[tuple[str, FieldInfo]]) -> str:
    lines = ["| key | default | unit | allowed | meaning | source |", "|---|---|---|---|---|---|"]
    for name, field in rows:
        cells = [
            f"`{name}`",
            _default(field),
            unit(field),
            _range(field),
            field.description or "",
            source(field),
        ]
        lines.append(f"| {' | '.join(cell.replace('|', '&#124;') for cell in cells)} |")
    return "\n".join(lines) + "\n"


def _range(field: FieldInfo) -> str:
    if part(field.annotation):
        return "a table"
    text = allowed(field)
    label = unit(field)
    text = text.removesuffix(f" [{label}]")
    for word in choices(field):
        text = text.replace(f'"{word}"', f'`"{word}"`')
    return text


def _default(field: FieldInfo) -> str:
    value: Any = field.default
    if value is None:
        return "left out"
    if part(field.annotation):
        return "its defaults"
    return f"`{shown(list(value) if isinstance(value, tuple) else value)}`"


def contacts_table() -> str:
    """Return what each named snow is to particles in contact, as a table in Markdown."""
    lines = [
        "| `kind` | law | E [Pa] | bond strain e | yield pressure Y_0 [Pa] | friction mu "
        "| without counterpart |",
        "|---|---|---|---|---|---|---|",
    ]
    for name in SNOWS:
        snow = Snow.model_validate({"kind": name})
        c = contact_constants(snow)
        pressure = "none" if c.yield_pressure >= NEVER else f"{c.yield_pressure:.4g}"
        left = ", ".join(f"{key} {getattr(snow, key):g}" for key in without_counterpart(snow))
        lines.append(
            f"| `{name}` | `{snow.law}` | {c.modulus:.4g} | {c.bond_strain:.3g} | {pressure} "
            f"| {c.friction:.3g} | {left} |"
        )
    return "\n".join(lines) + "\n"


TABLES = {SNOWS_PATH: as_table, CONTACTS_PATH: contacts_table}
"""Pages with a table of snows between two marks, and what writes it."""


def with_table(page: str, table: str) -> str:
    """Return a page with what is between its two marks replaced by `table`."""
    before, rest = page.split(BEGIN)
    _, after = rest.split(END)
    return f"{before}{BEGIN}\n{table}{END}{after}"


if __name__ == "__main__":
    PATH.write_text(document(), encoding="utf-8")
    for path, written in TABLES.items():
        path.write_text(with_table(path.read_text(encoding="utf-8"), written()), encoding="utf-8")
    print(f"wrote {PATH} and the tables of {', '.join(map(str, TABLES))}")
