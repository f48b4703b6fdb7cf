"""Folders of `core/` have layers, as Python packages have in `.importlinter`; includes have no loop."""

import re
from pathlib import Path

CORE = Path(__file__).parents[2] / "core"
INCLUDE = re.compile(r'^#include "([^"]+)"', re.M)

# From the bottom to the top: a folder includes its own headers and those of earlier lines. "" is core/.
LAYERS = [
    {""},  # threads
    {"math"},  # scalars, lane packs, matrices, splines, lists
    {"constitutive", "transfer", "geometry"},  # laws; particles and grid; shapes
    {"coupling", "heat"},  # what snow and solids do to each other; phases, the sun
    {"rigid"},  # how the rigid-body engine moves bodies
    {"mpm"},  # the step of one particle and one node, from values to values
    # where particles and nodes lie, who is near whom and how near, how data moves between them; the camera
    {"cpu/grid", "cuda/grid", "render/view", "neighbours"},
    {"render/solids"},  # solids on a picture
    {"render"},  # what draws
    {"cpu", "surface", "cuda"},  # the stages of the step over all of them
    {"snowfall", "cpu/implicit/nodes"},  # where snow comes to lie; nodes, solids and bodies of implicit steps
    # what is asked of all of them besides; their heat; implicit steps; the discrete element method
    {"cpu/passes", "cpu/heat", "cpu/implicit", "cpu/ranks", "particles"},
    {"particles/heat", "sph"},  # its heat; smoothed particles
    {"sph/water"},  # the solve for pressure where there is water
    {"bind/device"},  # what is handed to a GPU
    {"bind"},  # Python
    # Python, for heat, implicit steps, discrete elements, ranks, rigid bodies, snowfall, smoothed particles
    {"bind/heat", "bind/implicit", "bind/particles", "bind/ranks", "bind/rigid", "bind/snowfall", "bind/sph"},
]
LEVEL = {folder: level for level, folders in enumerate(LAYERS) for folder in folders}


def includes():
    """Each file of `core/` and what it includes of it, as paths from there."""
    files = sorted(path for path in CORE.rglob("*") if path.suffix in {".hpp", ".cpp"})
    return {str(p.relative_to(CORE)): INCLUDE.findall(p.read_text(encoding="utf-8")) for p in files}


def folder(path):
    """The folder of `core/` that a file is in."""
    return path.rpartition("/")[0]


def loop_from(start, graph):
    """A chain of includes that leads back to a file, or none."""
    seen, todo = set(), [(start, [start])]
    while todo:
        at, chain = todo.pop()
        for name in graph.get(at, []):
            if name == start:
                return [*chain, name]
            if name not in seen:
                seen.add(name)
                todo.append((name, [*chain, name]))
    return None


def test_includes_point_down():
    """No header includes one of a layer above it, or of a folder beside its own."""
    wrong = [
        f"{path} includes {name}"
        for path, names in includes().items()
        for name in names
        if folder(name) != folder(path) and LEVEL[folder(name)] >= LEVEL[folder(path)]
    ]
    assert wrong == []


def test_includes_have_no_loop():
    """No header includes itself by way of others, and all that is included exists."""
    graph = includes()
    assert [chain for path in graph if (chain := loop_from(path, graph))] == []
    assert {name for names in graph.values() for name in names} - set(graph) == set()


def test_loop_is_found():
    """The search sees a loop and passes over a diamond."""
    assert loop_from("a", {"a": ["b", "c"], "b": ["d"], "c": ["d"], "d": []}) is None
    assert loop_from("a", {"a": ["b"], "b": ["c"], "c": ["a"]}) == ["a", "b", "c", "a"]
