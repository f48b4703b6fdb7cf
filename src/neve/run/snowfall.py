"""Let it snow on a scene, a mesh or what a run has left, and write what lies into a folder."""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Mapping
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from pydantic import ValidationError

from neve import _core
from neve.build import placed_at_start
from neve.colliders.solid import Solid
from neve.geometry.mesh import read_mesh
from neve.geometry.pose import Pose
from neve.geometry.triangles import Triangles
from neve.io.atomic import replacing, write_text, writing
from neve.io.npz import write_npz
from neve.io.run_folder import RunFolder
from neve.run.fall_film import Fallen, film_fall
from neve.run.resting import Left, left_by
from neve.scene.errors import SceneError
from neve.scene.reading.files import NamedFile, missing
from neve.scene.reading.load import load, to_toml
from neve.scene.schema.file_shapes import MESHES, Mesh
from neve.scene.schema.scene import Source
from neve.scene.schema.snowfall import Snowfall
from neve.scene.values.surfaces import square
from neve.snowfall.cover import Cover, Raster, let_fall
from neve.snowfall.files import arrays_of
from neve.snowfall.scene import Falls, around, piece_of_source, require_few
from neve.snowfall.skin import skin
from neve.snowfall.surroundings import Piece, piece_of_triangles
from neve.system import disk

CELLS = 80
"""Along the longer side of the rectangle, where no cell is given. Twice as many take six times as long."""
COVER = "cover.npz"
"""File of the layers of what lies."""
FALL = "fall"
"""Folder of the run that shows the fall."""
NEW = "fresh"
"""Kind of the new snow in the scene that goes on with what a run has left."""
MARGIN = 0.1
"""Of the rectangle around all there is, in its sides."""


def snow_on(
    name: str,
    out: str | None = None,
    changes: tuple[str, ...] = (),
    options: Mapping[str, Any] | None = None,
    ground: float | None = None,
    threads: int | None = None,
    told: Callable[[int, int], None] = lambda done, of: None,
    film: int | None = None,
    filmed: Callable[[int, int, int], None] = lambda done, of, new: None,
) -> tuple[Cover, Path]:
    """Let it snow on a scene, a mesh or what a run left, write what lies, and return it with the folder.

    name: of a scene, of a mesh file, or of the folder of a run

    options: keys of a source of the shape snowfall; ground: height of level ground below a mesh [m]; film:
    number of frames of the fall of a scene, which a run folder in that folder then holds; `filmed` hears of
    its pictures. Errors: SceneError, RunError, FilmError: one sentence.
    """
    if threads is not None:
        _core.set_threads(threads)
    folder = Path(out) if out is not None else Path("snow") / Path(name.removeprefix("neve:")).stem
    own = name.startswith("neve:")
    if film is not None and (own or name.lower().endswith(MESHES) or RunFolder(name).is_run()):
        raise SceneError(f"{name}: --film is for a scene: make the mesh or what is left a part of one")
    if not own and (run := RunFolder(name)).is_run():
        if changes or ground is not None:
            raise SceneError(f"{name}: a run is over: leave --set and --ground out")
        left = left_by(run)
        cover = _on_left(left, options or {}, told)
        write_cover(cover, folder, {"resting_volume": left.volume, "resting_mass": left.mass})
        write_onward(left, folder)
        return cover, folder
    if own or name.lower().endswith(MESHES):
        if changes:
            raise SceneError(f"{name}: a mesh has no values to change: leave --set out")
        cover = _on_mesh(name, options or {}, ground, told)
    else:
        if ground is not None:
            raise SceneError(f"{name}: --ground is for a mesh: a scene has its own colliders")
        fallen = _on_scene(name, changes, options or {}, told)
        cover = fallen.cover
    write_cover(cover, folder)
    if film is not None:
        film_fall(fallen, folder / FALL, film, threads, filmed)
    return cover, folder


def _on_left(left: Left, options: Mapping[str, Any], told: Callable[[int, int], None]) -> Cover:
    """Let it snow on what a run has left."""
    pieces = [piece_of_triangles(f"sources.{i}", rest.surface) for i, (rest, _) in enumerate(left.snows)]
    bounded = [pair for pair in left.placed if not pair[0].endless]
    fall = _fall({"cell": left.scene.numerics.spacing}, options, pieces, bounded)
    return let_fall(fall, around(fall, left.placed, pieces), _raster(fall), told)


def write_onward(left: Left, folder: Path) -> None:
    """Write what the run has left, and scene.toml that goes on with it and the cover, into `folder`."""
    several = len(left.snows) > 1
    files = [folder / (f"rest_{i}.npz" if several else "rest.npz") for i, _ in enumerate(left.snows)]
    for path, (rest, _) in zip(files, left.snows, strict=True):
        with replacing(path) as file:
            write_npz(file, rest.arrays())
    cover = folder / COVER
    scene = left.onward(files, (Source.of("lying", file=str(cover), snow={"kind": NEW}),))
    names: dict[tuple[str, ...], str]
    names = {("sources", str(i), "file"): path.name for i, path in enumerate([*files, cover])}
    write_text(folder / "scene.toml", to_toml(scene, names))


def _on_mesh(
    name: str, options: Mapping[str, Any], ground: float | None, told: Callable[[int, int], None]
) -> Cover:
    mesh = Mesh(file=name)
    if problem := missing(NamedFile(("mesh",), name, MESHES, "meshes")):
        raise SceneError(problem)
    surface = read_mesh(mesh.model_copy(update={"thickness": 1e-9}), "mesh")
    pieces: list[Piece] = [piece_of_triangles("mesh", surface)]
    if ground is not None:
        pieces.append(_ground(surface, ground))
    fall = _fall({}, options, pieces[:1], None)
    raster = _raster(fall)
    return let_fall(fall, around(fall, [], pieces), raster, told)


def _ground(surface: Triangles, z: float) -> Piece:
    """Return level ground that reaches far beyond `surface`."""
    far = 10.0 * float((surface.high - surface.low).max()) + float(np.abs(surface.vertices).max())
    corners, faces = square()
    return "ground", "ground", corners * far + [0.0, 0.0, z], faces


def _on_scene(
    name: str, changes: tuple[str, ...], options: Mapping[str, Any], told: Callable[[int, int], None]
) -> Fallen:
    """Let it snow on a scene as its last snowfall says, changed by options. Errors: SceneError."""
    scene = load(name, changes)
    placed = placed_at_start(scene)
    falls = [i for i, source in enumerate(scene.sources) if isinstance(source, Snowfall)]
    if falls:
        index = falls[-1]
        own = scene.sources[index].model_dump(exclude_unset=True)
        if {"depth", "rate"} & {*options}:
            own = {key: value for key, value in own.items() if key not in ("depth", "rate")}
        source = _checked(own, options, Source)
        sources = (*scene.sources[:index], source)
    else:
        pieces = [piece_of_source(source, f"sources.{i}") for i, source in enumerate(scene.sources)]
        bounded = [pair for pair in placed if not pair[0].endless]
        own_fall = _fall({}, options, pieces, bounded)
        source = _checked(own_fall.model_dump(exclude_unset=True), {}, Source)
        index, sources = len(scene.sources), (*scene.sources, source)
    fall: Any = source
    if fall.cell is None and not falls:
        fall = fall.model_copy(update={"cell": max(fall.size) / CELLS})
        sources = (*sources[:-1], fall)
    scene = scene.model_copy(update={"sources": sources})
    depths: list[NDArray[np.float64]] = []
    cover = Falls(scene, placed).fallen(index, told, depths.append)
    return Fallen(scene, index, fall, cover, np.array(depths))


def _fall(
    own: Mapping[str, Any],
    options: Mapping[str, Any],
    pieces: list[Piece],
    bounded: list[tuple[Solid, Pose]] | None,
) -> Snowfall:
    """Return how it snows; where the options give no rectangle, it is that around all pieces and solids."""
    found: dict[str, Any] = dict(own)
    points = [piece[2] for piece in pieces]
    for solid, pose in bounded or []:
        points.append(np.array([pose.position - solid.reach, pose.position + solid.reach]))
    if points:
        low = np.min([p[:, :2].min(axis=0) for p in points], axis=0)
        high = np.max([p[:, :2].max(axis=0) for p in points], axis=0)
        margin = MARGIN * float((high - low).max()) if bounded is not None else 0.0
        found["center"] = tuple(float(v) for v in 0.5 * (low + high))
        found["size"] = tuple(float(v) + 2.0 * margin for v in high - low)
    fall: Snowfall = _checked(found, options, Snowfall)
    return fall


def _checked(own: Mapping[str, Any], options: Mapping[str, Any], kind: Any) -> Any:
    """Return a snowfall of these keys. Errors: SceneError, one sentence that names the option."""
    values = {**own, **options, "shape": "snowfall"}
    for key, value in options.items():
        if not all(math.isfinite(v) for v in np.atleast_1d(value).tolist() if isinstance(v, float)):
            raise SceneError(f"{_option(key)}: {value} is not finite")
    if "duration" in options and values.get("rate") is None:
        raise SceneError("--duration: it says how long it snows at a rate: give --rate, too, or leave it out")
    try:
        if kind is Source:
            return Source.of(**values)
        return Snowfall(**values)
    except ValidationError as error:
        first = error.errors()[0]
        context = first.get("ctx") or {}
        key = str(context.get("key") or ".".join(str(part) for part in first["loc"] if part != "snowfall"))
        text = context.get("message") or first["msg"][:1].lower() + first["msg"][1:]
        raise SceneError(f"{_option(key.split('.')[0])}: {text}") from None


def _option(key: str) -> str:
    """Return how the command line writes a key of a snowfall."""
    return f"--{key.replace('_', '-')}"


def _raster(fall: Snowfall) -> Raster:
    cell = fall.cell or max(fall.size) / CELLS
    raster = Raster.over(fall.center, fall.size, cell)
    require_few(raster, "--cell", cell)
    return raster


def write_cover(cover: Cover, folder: Path, more: Mapping[str, float] | None = None) -> None:
    """Write snow.ply, depth.csv, cover.npz and books.json, which has `more`. Errors: RunError."""
    with writing(folder):
        disk.make_folder(folder)
    surface = skin(cover)
    _write_ply(folder / "snow.ply", surface)
    with replacing(folder / "depth.csv") as file:
        file.write(b"x,y,z,depth,share,part\n")
        rows = np.column_stack([cover.x[:, :2], cover.z, cover.depth, cover.share, cover.columns.part()])
        np.savetxt(file, rows, fmt=["%.6g", "%.6g", "%.6g", "%.6g", "%.4g", "%d"], delimiter=",")
    with replacing(folder / COVER) as file:
        write_npz(file, arrays_of(cover))
    books = {
        **asdict(cover.books),
        "density": cover.density,
        "volume_of_mesh": surface.volume,
        **(more or {}),
    }
    write_text(folder / "books.json", json.dumps(books, indent=2) + "\n")


def _write_ply(path: Path, surface: Triangles) -> None:
    head = (
        f"ply\nformat binary_little_endian 1.0\nelement vertex {len(surface.vertices)}\n"
        "property float x\nproperty float y\nproperty float z\n"
        f"element face {len(surface.faces)}\nproperty list uchar int vertex_indices\nend_header\n"
    )
    faces = np.empty(len(surface.faces), [("n", "u1"), ("v", "<i4", 3)])
    faces["n"], faces["v"] = 3, surface.faces
    with replacing(path) as file:
        file.write(head.encode())
        file.write(surface.vertices.astype("<f4").tobytes())
        file.write(faces.tobytes())
