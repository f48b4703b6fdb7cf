"""Open a run in Blender: snow with a look, solids, sun, sky and the camera of its scene.

    blender --python examples/blender/import_snow.py -- runs/ball
    blender --background --python examples/blender/import_snow.py -- runs/ball --frame 30 --render ball.png

It reads exports of the run: `neve export runs/ball --to usd` (points and solids), `--to vdb` (a volume) or
`--to abc` (a surface). `--as points|volume|surface` chooses; by default volume, surface or points, whichever
of them is there first. Written for Blender 4.2 or newer, tested with the wheel bpy 5.0.1.
"""

from __future__ import annotations

import argparse
import json
import math
import sys
import tomllib
from pathlib import Path

import bpy
from mathutils import Vector

KINDS = {"volume": "vdb", "surface": "abc", "points": "usd"}
"""What snow can be -> the folder of the export in the run folder."""
ALBEDO = (0.95, 0.965, 0.985, 1.0)
PACKED = 400.0
"""Density that counts as packed snow [kg/m3]."""


def main():
    """Read the arguments after `--`, build the scene, and render a picture if one is asked for."""
    words = sys.argv[sys.argv.index("--") + 1 :] if "--" in sys.argv else sys.argv[1:]
    parser = argparse.ArgumentParser(prog="import_snow.py")
    parser.add_argument("run", type=Path, help="run folder, with exports in usd, vdb or abc")
    parser.add_argument("--as", dest="kind", choices=KINDS)
    parser.add_argument("--extinction", type=float, default=200.0, help="of packed snow as a volume [1/m]")
    parser.add_argument("--frame", type=int, help="frame to show or render")
    parser.add_argument("--render", type=Path, help="picture to write (PNG)")
    parser.add_argument("--size", default="1280x720", help="of the picture, WIDTHxHEIGHT")
    parser.add_argument("--samples", type=int, default=64, help="paths for each pixel")
    parser.add_argument("--save", type=Path, help=".blend file to write")
    given = parser.parse_args(words)
    run = given.run.resolve()
    kind = given.kind or next((k for k, name in KINDS.items() if (run / name).is_dir()), None)
    if kind is None or not (run / KINDS[kind]).is_dir():
        parser.error(f"{run} has no such export: neve export {given.run} --to {KINDS[kind or 'points']}")
    if wrong := unusual(run, kind):
        parser.error(wrong)
    described = tomllib.loads((run / "scene.toml").read_text(encoding="utf-8"))

    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    scene.render.fps = described["run"]["fps"]
    {"points": add_points, "surface": add_surface, "volume": add_volume}[kind](run, given.extinction)
    add_light(described["light"])
    add_camera(described["camera"])
    set_up_rendering(scene, given)
    if given.frame is not None:
        scene.frame_set(given.frame)
    if given.save:
        bpy.ops.wm.save_as_mainfile(filepath=str(given.save.resolve()))
    if given.render:
        scene.render.filepath = str(given.render.resolve())
        bpy.ops.render.render(write_still=True)


def unusual(run, kind):
    """Say which export of the run is not in metres with its usual axis up, as light and camera need it."""
    for name in {KINDS[kind], "usd"}:
        card = run / name / "export.json"
        if not card.is_file():
            continue
        options = json.loads(card.read_text(encoding="utf-8"))["options"]
        up = "y" if name == "abc" else "z"
        if (options["scale"], options["up"]) != (1.0, up):
            return (
                f"{run / name} has --scale or --up: neve export {run} --to {name} --scale 1 --up {up} --force"
            )
    return None


def add_points(run, extinction):
    """Points, drawn as balls as wide as particles are apart, and the solids, both animated."""
    bpy.ops.wm.usd_import(filepath=str(run / "usd/snow.usda"))
    finish_solids()
    bpy.data.objects["Snow"].data.materials.append(principled("snow", ALBEDO, 0.9))


def add_surface(run, extinction):
    """The surface, with the velocities of its vertices for motion blur, and the solids."""
    bpy.ops.wm.alembic_import(filepath=str(run / "abc/snow.abc"))
    finish_solids()
    bpy.data.objects.remove(bpy.data.objects["snow"])
    snow = bpy.data.objects["snow_surface"]
    snow.data.materials.append(snow_surface_material())


def add_volume(run, extinction):
    """The density as a volume, a file for each frame; the solids if there is a USD export as well."""
    files = sorted((run / "vdb").glob("snow_*.vdb"))
    numbers = [int(path.stem.rpartition("_")[2]) for path in files]
    volume = bpy.data.volumes.new("Snow")
    volume.filepath = str(files[0])
    if len(files) > 1:
        volume.is_sequence = True
        volume.frame_start, volume.frame_offset = numbers[0], numbers[0] - 1
        volume.frame_duration = numbers[-1] - numbers[0] + 1
    bpy.context.scene.frame_start, bpy.context.scene.frame_end = numbers[0], numbers[-1]
    snow = bpy.data.objects.new("Snow", volume)
    bpy.context.scene.collection.objects.link(snow)
    volume.materials.append(snow_volume_material(extinction))
    if (run / "usd/solids.usdc").is_file():
        bpy.ops.wm.usd_import(filepath=str(run / "usd/snow.usda"), import_points=False)
        finish_solids()


def finish_solids():
    """Give solids that have none a material: dark grey."""
    for thing in bpy.data.objects:
        if thing.type == "MESH" and thing.name != "snow_surface" and not thing.data.materials:
            thing.data.materials.append(principled("solid", (0.20, 0.23, 0.27, 1.0), 0.6))


def principled(name, color, roughness):
    """A material with nodes: the colour of its surface, linear, and its roughness."""
    found = bpy.data.materials.get(name)
    if found:
        return found
    material = bpy.data.materials.new(name)
    material.use_nodes = True
    shader = next(node for node in material.node_tree.nodes if node.type == "BSDF_PRINCIPLED")
    shader.inputs["Base Color"].default_value = color
    shader.inputs["Roughness"].default_value = roughness
    return material


def snow_surface_material():
    """White, rough, with light that comes out some millimetres beside where it went in, blue farthest."""
    material = principled("snow", ALBEDO, 0.9)
    shader = next(node for node in material.node_tree.nodes if node.type == "BSDF_PRINCIPLED")
    shader.inputs["Subsurface Weight"].default_value = 1.0
    shader.inputs["Subsurface Radius"].default_value = (0.75, 0.9, 1.15)
    shader.inputs["Subsurface Scale"].default_value = 0.006
    return material


def snow_volume_material(extinction):
    """Scattering in proportion to the grid `density`: `extinction` [1/m] in packed snow."""
    material = bpy.data.materials.new("snow")
    material.use_nodes = True
    tree = material.node_tree
    tree.nodes.clear()
    shader = tree.nodes.new("ShaderNodeVolumePrincipled")
    shader.inputs["Color"].default_value = (0.985, 0.99, 0.995, 1.0)
    shader.inputs["Density Attribute"].default_value = "density"
    shader.inputs["Density"].default_value = extinction / PACKED
    output = tree.nodes.new("ShaderNodeOutputMaterial")
    tree.links.new(shader.outputs["Volume"], output.inputs["Volume"])
    return material


def add_light(light):
    """Sun and sky of the scene."""
    bpy.ops.object.light_add(type="SUN")
    sun = bpy.context.object
    up, around = math.radians(light["sun_elevation"]), math.radians(light["sun_azimuth"])
    to_sun = Vector((math.cos(up) * math.cos(around), math.cos(up) * math.sin(around), math.sin(up)))
    sun.rotation_euler = to_sun.to_track_quat("Z", "Y").to_euler()
    sun.data.energy, sun.data.angle = 5.0 * light["sun_strength"], math.radians(1.5)
    sun.data.color = light["sun_color"]
    world = bpy.data.worlds.new("sky")
    world.use_nodes = True
    background = next(node for node in world.node_tree.nodes if node.type == "BACKGROUND")
    background.inputs["Color"].default_value = (*light["sky_color"], 1.0)
    background.inputs["Strength"].default_value = 0.8 * light["sky_strength"]
    bpy.context.scene.world = world


def add_camera(described):
    """The camera of the scene, which names its vertical angle of view."""
    camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
    position, target = Vector(described["position"]), Vector(described["target"])
    camera.location = position
    camera.rotation_euler = (target - position).to_track_quat("-Z", "Y").to_euler()
    camera.data.sensor_fit = "VERTICAL"
    camera.data.angle = math.radians(described["fov"])
    bpy.context.scene.collection.objects.link(camera)
    bpy.context.scene.camera = camera


def set_up_rendering(scene, given):
    """Cycles, a filmic curve, motion blur of half a frame."""
    scene.render.engine = "CYCLES"
    scene.cycles.samples = given.samples
    scene.cycles.volume_max_steps = 1024
    scene.cycles.max_bounces = scene.cycles.volume_bounces = 32
    scene.render.use_motion_blur = True
    scene.render.motion_blur_shutter = 0.5
    scene.view_settings.view_transform = "AgX"
    scene.render.image_settings.file_format = "PNG"
    scene.render.resolution_x, scene.render.resolution_y = map(int, given.size.split("x"))


main()
