"""Describe a player's scene to a page: the panel, what is drawn with which light, and what can be added."""

from __future__ import annotations

import base64
from typing import Any

import numpy as np

from neve.colliders.solid import Solid
from neve.render import falling
from neve.render.lighting import STEEL, density_cell, is_ground, sky_color, sun_color, sun_direction
from neve.render.shot import Shot, View, opening
from neve.scene.reading.presets import preset_about, presets
from neve.scene.schema.scene import Light, Numerics, Scene
from neve.viewer.modes import described
from neve.viewer.players.player import Player
from neve.viewer.protocol import messages
from neve.viewer.tools.panel import lists, panel
from neve.viewer.tools.placing import addable


def describe(player: Player) -> messages.SceneMessage:
    """Return the message of kind "scene", all that a page needs beside the snapshots."""
    scene, made = player.scene, player.running().numerics
    shown = drawn(
        player.name,
        scene,
        player.solids(),
        described(player.color_modes(), player.running()),
        player.radius(),
        _first_view(player),
        made,
    )
    jointed = {f"bodies.{i}" for i, body in enumerate(scene.bodies) if body.joint != "free"}
    for solid in shown["solids"]:
        solid["pulled"] = player.live and (solid["name"].startswith("robots.") or solid["name"] in jointed)
    return {
        **shown,
        "kind": "scene",
        "number": player.number,
        "live": player.live,
        "duration": scene.run.duration,
        "player": player.state(),
        "panel": [
            section for section in panel(scene, player.begun()) if player.live or section["path"] == "light"
        ],
        "presets": {name: preset_about(name) for name in presets()},
        "controls": player.controls(),
        "addable": {key: addable(key, made.dx) for key in lists()} if player.live else {},
    }


def _first_view(player: Player) -> View:
    """Return the view of the scene's camera at the start; what it follows is where the page shows it."""
    scene, snapshot = player.scene, player.latest
    if scene.camera.follow is None or snapshot is None:
        return opening(scene.camera)
    shot = Shot(scene.camera, player.solids(), scene.numerics.dx)
    x = np.asarray(snapshot.x)
    places = [position for position, _ in snapshot.poses]
    shot.see(snapshot.time, x, np.zeros_like(x), np.arange(len(x)), places)
    return shot.at(0.0)


def drawn(
    name: str,
    scene: Scene,
    solids: tuple[Solid, ...],
    modes: list[messages.Mode],
    radius: float,
    view: View | None = None,
    numerics: Numerics | None = None,
) -> messages.Drawn:
    """Return what is drawn beside the particles: camera, light, solids, and how large a particle is.

    radius: of a particle [m]. view: of the camera; without it that of the scene's at the start.
    numerics: with which the snow that is there was made; without it the scene's.
    Light is in the units of the film (neve.render), whose curve the page uses as well.
    """
    camera = view or opening(scene.camera)
    made = numerics or scene.numerics
    return {
        "name": name,
        "about": scene.about,
        "caption": scene.caption,
        "fps": scene.run.fps,
        "dx": made.dx,
        "spacing": 2 * radius,
        "cell": density_cell(made, radius),
        "camera": {
            "position": camera.position, "target": camera.target, "up": camera.up,
            "fov": camera.fov,
        },
        "light": light_of(scene.light),
        "falling": falling_of(scene),
        "solids": [_solid(solid) for solid in solids],
        "modes": modes,
    }  # fmt: skip


def light_of(light: Light) -> messages.Light:
    """Return direction and colours of sun and sky as the film has them."""
    return {
        "sun": sun_direction(light),
        "sun_color": sun_color(light),
        "sky_color": sky_color(light),
    }


def falling_of(scene: Scene) -> messages.Falling | None:
    """Return the law of the flakes in the air, and their light; None: there are none."""
    law = falling.law_of(scene.light)
    if law is None:
        return None
    return {
        "count": law.count, "edge": law.edge, "around": falling.AROUND,
        "velocity": law.velocity, "pace": falling.PACE,
        "radius": law.radius, "spread": falling.SPREAD,
        "sway": falling.SWAY, "period": falling.PERIOD, "second": falling.SECOND,
        "numbers": [falling.HOME, falling.HASTE, falling.PHASE, falling.RADIUS],
        "open": scene.camera.shutter / scene.run.fps,
        "least": falling.LEAST, "faintest": falling.FAINTEST, "nearest": falling.NEAREST,
        "light": falling.glow(sun_color(scene.light), sky_color(scene.light)),
    }  # fmt: skip


def _solid(solid: Solid) -> messages.Solid:
    drawn: messages.Solid = {
        "name": solid.name,
        "shape": solid.shape,
        "half": messages.vector(solid.half),
        "color": messages.vector(solid.color or STEEL),
        "visible": solid.visible,
        "ground": is_ground(solid),
    }
    if solid.shape == "mesh" and solid.mesh is not None:
        drawn["mesh"] = _mesh(solid.mesh.vertices, solid.mesh.faces)
    elif solid.shape == "terrain" and solid.terrain is not None:
        drawn["mesh"] = _mesh(*_terrain(solid.terrain.heights, solid.terrain.size))
    return drawn


def _mesh(vertices: Any, faces: Any) -> messages.Mesh:
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
