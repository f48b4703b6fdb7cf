"""Draw the rooms of the house and what they import: `python tools/architecture.py` writes the picture.

A room is a folder or a module right below `src/neve`, or a folder of `core`. An arrow means that a room uses
another one; an arrow from a to c is left out where a reaches c through b. The picture is made from the code
alone, so a test can see whether it is current.
"""

from __future__ import annotations

import ast
import math
import re
from dataclasses import dataclass, field
from html import escape
from itertools import pairwise
from pathlib import Path

ROOT = Path(__file__).parents[1]
PATH = Path("docs") / "images" / "architecture.svg"  # from the root of the checkout
PACKAGE = "neve"
WITHOUT = {"__init__", "__main__", "assets"}
DAMPING = 0.9
"""Place of a room over the mean place of its neighbours [1]: below 1, so that all stays together."""
MODULES = {"_core": "core/bind", "_render": "core/bind", "_surface": "core/bind", "_cpu": "core/bind"}
"""Extension modules -> the room of the core that binds them."""
INCLUDE = re.compile(r'^#include "(\w+)/', re.M)

BOX, GAP, ROW, MARGIN = (124, 30), 14, 66, 16
"""Sizes [pixels]: of a box, between boxes, from row to row, around all."""


@dataclass
class Room:
    """Hold a room: its name, what it is for, and the rooms that it uses."""

    name: str
    about: str
    uses: set[str] = field(default_factory=set)


def python_rooms() -> dict[str, Room]:
    """Return the rooms of the package."""
    rooms: dict[str, Room] = {}
    for path in sorted((ROOT / "src" / PACKAGE).iterdir()):
        name = path.stem
        files = sorted(path.rglob("*.py")) if path.is_dir() else [path] if path.suffix == ".py" else []
        if not files or name in WITHOUT:
            continue
        head = path / "__init__.py" if path.is_dir() else path
        about = (ast.get_docstring(ast.parse(head.read_text(encoding="utf-8"))) or "").split("\n")[0]
        rooms[name] = Room(name, about)
        for file in files:
            rooms[name].uses |= imported(file) - {name}
    for room in rooms.values():
        room.uses = {MODULES.get(name, name) for name in room.uses} & (rooms.keys() | set(MODULES.values()))
    for upper, lower in exceptions():
        rooms[upper].uses.discard(lower)
    return rooms


def imported(file: Path) -> set[str]:
    """Return the names right below the package that a file imports when it runs, not for types alone."""
    found: set[str] = set()
    tree = ast.parse(file.read_text(encoding="utf-8"))
    typed = {
        id(node)
        for test in ast.walk(tree)
        if isinstance(test, ast.If) and ast.unparse(test.test) == "TYPE_CHECKING"
        for statement in test.body
        for node in ast.walk(statement)
    }
    for node in ast.walk(tree):
        if id(node) in typed:
            continue
        if isinstance(node, ast.ImportFrom) and node.module:
            words = node.module.split(".")
            if words == [PACKAGE]:
                found |= {alias.name for alias in node.names}
            elif words[0] == PACKAGE:
                found.add(words[1])
        elif isinstance(node, ast.Import):
            found |= {
                alias.name.split(".")[1] for alias in node.names if alias.name.startswith(f"{PACKAGE}.")
            }
    return found


def exceptions() -> list[tuple[str, str]]:
    """Return the imports against the order of the layers that `.importlinter` allows."""
    text = (ROOT / ".importlinter").read_text(encoding="utf-8")
    return re.findall(rf"^ +{PACKAGE}\.(\w+)[\w.]* -> {PACKAGE}\.(\w+)", text, re.M)


def core_rooms() -> dict[str, Room]:
    """Return the rooms of the core, called core/NAME."""
    rooms: dict[str, Room] = {}
    for folder in sorted(path for path in (ROOT / "core").iterdir() if path.is_dir()):
        files = sorted(p for p in folder.rglob("*") if p.suffix in (".hpp", ".cpp", ".cu"))
        if files:
            room = Room(f"core/{folder.name}", "")
            for file in files:
                room.uses |= {f"core/{name}" for name in INCLUDE.findall(file.read_text(encoding="utf-8"))}
            rooms[room.name] = room
    for room in rooms.values():
        room.uses = (room.uses - {room.name}) & rooms.keys()
    return rooms


def reached(rooms: dict[str, Room], name: str) -> set[str]:
    """Return all rooms that `name` uses, on whatever way."""
    found: set[str] = set()
    new = set(rooms[name].uses)
    while new:
        found |= new
        new = {below for room in new for below in rooms[room].uses} - found
    return found


def arrows(rooms: dict[str, Room]) -> list[tuple[str, str]]:
    """Return the uses that do not follow from others (the transitive reduction).

    Errors: ValueError if rooms use each other in a circle.
    """
    below = {name: reached(rooms, name) for name in rooms}
    if circle := sorted(name for name in rooms if name in below[name]):
        raise ValueError(f"these rooms use each other in a circle: {', '.join(circle)}")
    return [
        (name, used)
        for name, room in sorted(rooms.items())
        for used in sorted(room.uses)
        if not any(used in below[other] for other in room.uses - {used})
    ]


def rows_of(rooms: dict[str, Room]) -> dict[str, int]:
    """Return the row of each room, from 0 at the top: right below the lowest room that uses it."""
    users = {name: [other for other, room in rooms.items() if name in room.uses] for name in rooms}
    row: dict[str, int] = {}

    def of(name: str) -> int:
        if name not in row:
            row[name] = 1 + max((of(user) for user in users[name]), default=-1)
        return row[name]

    for name in rooms:
        of(name)
    return row


def threads(row: dict[str, int], links: list[tuple[str, str]]) -> tuple[dict[str, int], list[list[str]]]:
    """Cut arrows over several rows into pieces: return the rows with a point in each row that is passed, and
    the chain of rooms and points of each arrow.
    """
    points, chains = dict(row), []
    for upper, lower in links:
        chain = [upper]
        for number in range(row[upper] + 1, row[lower]):
            chain.append(f"{upper}>{lower}>{number}")
            points[chain[-1]] = number
        chains.append([*chain, lower])
    return points, chains


def columns(points: dict[str, int], chains: list[list[str]], sweeps: int = 100) -> dict[str, float]:
    """Return the x of each room and point, in the middle of those it is joined to (Sugiyama et al. 1981)."""
    joined: dict[str, list[str]] = {name: [] for name in points}
    for chain in chains:
        for upper, lower in pairwise(chain):
            joined[upper].append(lower)
            joined[lower].append(upper)
    rows = [[name for name in sorted(points) if points[name] == k] for k in range(max(points.values()) + 1)]
    x = {name: (k - len(row) / 2) * BOX[0] for row in rows for k, name in enumerate(row)}
    for sweep in range(sweeps):
        side = range(len(rows)) if sweep % 2 == 0 else range(len(rows) - 1, -1, -1)
        for number in side:
            near = {name: [x[other] for other in joined[name]] for name in rows[number]}
            ideal = {
                name: DAMPING * sum(found) / len(found) if found else x[name] for name, found in near.items()
            }
            order = sorted(rows[number], key=lambda name: (ideal[name], name))
            x |= apart(order, ideal)
    left = min(x.values()) - MARGIN - BOX[0] / 2
    return {name: value - left for name, value in x.items()}


def apart(order: list[str], ideal: dict[str, float]) -> dict[str, float]:
    """Return places in this order, far enough apart and near those that are ideal."""
    half = {name: (BOX[0] if ">" not in name else 0) / 2 + GAP / 2 for name in order}
    right, left = {}, {}
    edge = -math.inf
    for name in order:
        right[name] = max(ideal[name], edge + half[name])
        edge = right[name] + half[name]
    edge = math.inf
    for name in reversed(order):
        left[name] = min(ideal[name], edge - half[name])
        edge = left[name] - half[name]
    return {name: 0.5 * (right[name] + left[name]) for name in order}


def curve(chain: list[str], x: dict[str, float], top: dict[str, int]) -> str:
    """Return the path of an arrow: down from the first room, through the points, to the last room."""
    text = f"M{x[chain[0]]:.0f} {top[chain[0]] + BOX[1]}"
    for upper, lower in pairwise(chain):
        y, v = top[upper] + BOX[1], top[lower]
        middle = (y + v) // 2
        text += f"C{x[upper]:.0f} {middle} {x[lower]:.0f} {middle} {x[lower]:.0f} {v}"
        if ">" in lower:
            text += f"V{v + BOX[1]}"
    return text


def picture() -> str:
    """Return the picture as SVG."""
    rooms = python_rooms() | core_rooms()
    links = arrows(rooms)
    points, chains = threads(rows_of(rooms), links)
    x = columns(points, chains)
    top = {name: MARGIN + number * ROW for name, number in points.items()}
    width, height = max(x.values()) + MARGIN + BOX[0] / 2, max(top.values()) + MARGIN + BOX[1]
    parts = [
        '<svg xmlns="http://www.w3.org/2000/svg" font-family="sans-serif" '
        f'viewBox="0 0 {width:.0f} {height}">',
        "<title>The rooms of Neve; an arrow points from a room to one that it uses</title>",
        "<style>path{fill:none;stroke:#8a9bb0;stroke-width:1.2;marker-end:url(#a)}rect{stroke:#456;rx:5}"
        ".p{fill:#eef5fc}.c{fill:#fdf1e3}text{text-anchor:middle;fill:#123;font-size:14px}</style>",
        '<defs><marker id="a" viewBox="0 0 8 8" refX="8" refY="4" markerWidth="7" markerHeight="7" '
        'orient="auto"><path d="M0 0L8 4L0 8z" style="fill:#8a9bb0;stroke:none"/></marker></defs>',
        f'<rect width="{width:.0f}" height="{height}" style="fill:#fff;stroke:none"/>',
    ]
    parts += [f'<path d="{curve(chain, x, top)}"/>' for chain in chains]
    for name, room in sorted(rooms.items()):
        kind = "c" if name.startswith("core/") else "p"
        parts.append(
            f'<g><title>{escape(room.about or name)}</title><rect class="{kind}" '
            f'x="{x[name] - BOX[0] / 2:.0f}" y="{top[name]}" width="{BOX[0]}" height="{BOX[1]}"/>'
            f'<text x="{x[name]:.0f}" y="{top[name] + 20}">{name}</text></g>'
        )
    return "\n".join([*parts, "</svg>"]) + "\n"


if __name__ == "__main__":
    (ROOT / PATH).write_text(picture(), encoding="utf-8")
    print(f"wrote {PATH}")
