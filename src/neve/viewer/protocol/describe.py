"""Describe a player's scene to a page: the panel, what is drawn with which light, and what can be added."""

from __future__ import annotations

import base64
from typing import Any

import numpy as np

from neve.build import material_table
from neve.colliders.solid import Solid
from neve.render.lighting import STEEL, density_cell, is_ground, sky_color, sun_color, sun_direction
from neve.scene.reading.files import own_files
from neve.scene.reading.load import preset_about, presets
from neve.scene.schema.allowed import shapes
from neve.scene.schema.scene import Light, Scene
from neve.viewer.modes import MODES, available
from neve.viewer.players.player import Player
from neve.viewer.players.recorded import COLUMNS, Recorded
from neve.viewer.protocol.panel import lists, panel


def describe(player: Player) -> dict[str, Any]:
    """Return the message of kind "scene", all that a page needs beside the snapshots."""
    scene = player.scene
    recorded = isinstance(player, Recorded)
    known = available(COLUMNS) if recorded else list(MODES)
    return {
        "kind": "scene",
        "number": player.number,
        "name": player.name,
        "live": player.live,
        "about": scene.about,
        "player": player.state(),
        "panel": [s for s in panel(scene) if not recorded or s["path"] == "light"],
        "presets": {} if recorded else {name: preset_about(name) for name in presets()},
        "modes": [
            {"name": name, "label": m.label, "unit": m.unit, "palette": m.palette, "classes": m.classes}
            for name, m in MODES.items()
            if name in known
        ],
        "materials": materials(player.running()),
        "addable": {} if recorded else {key: _addable(key) for key in lists()},
        **drawn(scene, player.solids()),
    }


def materials(scene: Scene) -> list[str]:
    """Return what the legend calls each row of the material table: its kind, and whose snow it is."""
    rows = material_table(scene)
    told = []
    for snow in rows:
        whose = [str(i) for i, source in enumerate(scene.sources) if scene.snow_of(source) == snow]
        told.append(snow.kind if len(rows) == 1 else f"{snow.kind}, of sources {', '.join(whose[:6])}")
    return told


def drawn(scene: Scene, solids: tuple[Solid, ...]) -> dict[str, Any]:
    """Return what is drawn beside the particles: camera, light, solids, and how large a particle is.

    Light is in the units of the film (neve.render), whose curve the page uses as well.
    """
    numerics = scene.numerics
    camera = scene.camera
    return {
        "fps": scene.run.fps,
        "dx": numerics.dx,
        "spacing": numerics.spacing,
        "cell": density_cell(numerics),
        "camera": {
            "position": camera.position, "target": camera.target, "up": camera.up, "fov": camera.fov,
        },
        "light": light_of(scene.light),
        "solids": [_solid(solid) for solid in solids],
    }  # fmt: skip


def light_of(light: Light) -> dict[str, list[float]]:
    """Return direction and colours of sun and sky as the film has them."""
    return {
        "sun": list(sun_direction(light)),
        "sun_color": list(sun_color(light)),
        "sky_color": list(sky_color(light)),
    }


def _solid(solid: Solid) -> dict[str, Any]:
    told: dict[str, Any] = {
        "name": solid.name,
        "shape": solid.shape,
        "half": [float(h) for h in solid.half],
        "color": list(solid.color or STEEL),
        "visible": solid.visible,
        "ground": is_ground(solid),
    }
    if solid.shape == "mesh" and solid.mesh is not None:
        told["mesh"] = _mesh(solid.mesh.vertices, solid.mesh.faces)
    elif solid.shape == "terrain" and solid.terrain is not None:
        told["mesh"] = _mesh(*_terrain(solid.terrain.heights, solid.terrain.size))
    return told


def _mesh(vertices: Any, faces: Any) -> dict[str, str]:
    """Return corners [m] as float32 and triangles as uint32, in base64."""
    corners, triangles = np.asarray(vertices, "<f4"), np.asarray(faces, "<u4")
    return {
        "vertices": base64.b64encode(corners.tobytes()).decode(),
        "faces": base64.b64encode(triangles.tobytes()).decode(),
    }


def _terrain(heights: Any, size: Any) -> tuple[Any, Any]:
    """Return the triangles of a height map, thinned to at most 256 places along each side."""
    heights = np.asarray(heights, np.float64)
    rows = [np.unique(np.linspace(0, n - 1, min(n, 256)).astype(int)) for n in heights.shape]
    z = heights[np.ix_(*rows)]
    x, y = (
        (r / (n - 1) - 0.5) * float(length) for r, n, length in zip(rows, heights.shape, size, strict=True)
    )
    corners = np.stack([*np.meshgrid(x, y, indexing="ij"), z], axis=-1).reshape(-1, 3)
    i = np.arange(z.size).reshape(z.shape)
    a, b, c, d = i[:-1, :-1], i[1:, :-1], i[1:, 1:], i[:-1, 1:]
    faces = np.concatenate([np.stack([a, b, c], -1).reshape(-1, 3), np.stack([a, c, d], -1).reshape(-1, 3)])
    return corners, faces


def _addable(kind: str) -> list[str]:
    """Return the shapes of a list that need nothing but a place, and the meshes that come with Neve."""
    found = []
    for shape, model in shapes(Scene.model_fields[kind].annotation).items():
        if shape == "mesh":
            found += [f"mesh:{name}" for name in own_files("meshes")]
        elif "file" not in model.model_fields:
            found.append(shape)
    return found
