"""Let days pass over snow that lies: of a folder of `neve snow`, or of a scene."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np

from neve import _core
from neve.ageing.days import HOUR, Balance, Weather, aged_cover
from neve.build import placed_at_start
from neve.io.atomic import replacing
from neve.run.snowfall import COVER, write_cover
from neve.scene.errors import SceneError
from neve.scene.reading.load import load
from neve.scene.schema.file_shapes import Layer
from neve.scene.schema.snowfall import Lying, Snowfall
from neve.snowfall.cover import Cover
from neve.snowfall.level import cover_of_layer, is_level
from neve.snowfall.scene import Falls, lying


def age(
    name: str,
    days: float,
    weather: Weather,
    out: str | None = None,
    changes: tuple[str, ...] = (),
    threads: int | None = None,
    told: Callable[[int, int], None] = lambda done, of: None,
) -> tuple[Cover, Balance, Path]:
    """Let `days` of weather pass over snow, write and return what it has become, its balance and the folder.

    name: a folder of `neve snow` or `neve age`, its cover.npz, or a scene, of which it is the last snow that
    falls, lies, or is a level layer
    Errors: SceneError, RunError: one sentence.
    """
    if threads is not None:
        _core.set_threads(threads)
    cover = _cover(name, changes)
    new, balance = aged_cover(cover, weather, 24.0 * HOUR * days, told)
    path = Path(name)
    folder = (
        Path(out) if out is not None else Path("aged") / (path.parent if path.suffix == ".npz" else path).stem
    )
    write_cover(new, folder, vars(balance))
    write_profile(new, folder)
    return new, balance, folder


def _cover(name: str, changes: tuple[str, ...]) -> Cover:
    path = Path(name)
    stored = path / COVER if (path / COVER).is_file() else path if name.lower().endswith(".npz") else None
    if stored is not None:
        if changes:
            raise SceneError(f"{name}: snow that lies has no values to change: leave --set out")
        found = lying(stored, "cover")
        if not isinstance(found, Cover):
            raise SceneError(f"{name} holds particles, which have no layers: name a cover.npz of neve snow")
        return found
    scene = load(name, changes)
    for i in reversed(range(len(scene.sources))):
        source = scene.sources[i]
        if isinstance(source, Snowfall):
            return Falls(scene, placed_at_start(scene)).fallen(i)
        if isinstance(source, Lying):
            found = lying(Path(source.file), f"sources.{i}.file")
            if isinstance(found, Cover):
                return found
        if isinstance(source, Layer) and is_level(source):
            celsius = scene.heat.snow_temperature if scene.heat else 0.0
            return cover_of_layer(source, scene.snow_of(source).rho0, celsius)
    raise SceneError(f"{name} has no snow that falls or lies, nor a level layer: there is nothing to age")


def write_profile(cover: Cover, folder: Path) -> None:
    """Write layers.csv: the layers from the surface up, averages over all their snow. Errors: RunError."""
    layers = cover.layers
    mass = layers.mass
    rows, height = [], 0.0
    for k in range(mass.shape[1]):
        if not (total := float(mass[:, k].sum())) > 0.0:
            continue
        thickness = float(layers.thickness[:, k].sum()) / max(int((cover.depth > 0.0).sum()), 1)
        height += thickness

        def mean(values: np.ndarray, k: int = k, total: float = total) -> float:
            return float(np.sum(values[:, k] * mass[:, k]) / total)

        density = total / float(layers.thickness[:, k].sum())
        strength = mean(layers.strength() * layers.growth)
        state = (mean(layers.temperature), mean(layers.liquid), strength, mean(layers.age) / HOUR)
        rows.append([height, thickness, density, *state])
    with replacing(folder / "layers.csv") as file:
        file.write(b"top,thickness,density,temperature,liquid,strength,age\n")
        np.savetxt(file, np.array(rows).reshape(-1, 7), fmt="%.6g", delimiter=",")
