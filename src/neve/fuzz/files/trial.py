"""Damage one file and read it as a run would: it is read, or refused in one sentence, within bounds."""

from __future__ import annotations

import contextlib
import os
import sys
import tempfile
import traceback
import warnings
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from neve.fuzz.files.corpus import corpus
from neve.fuzz.files.runs import damaged_file, readers
from neve.fuzz.outcome import Outcome
from neve.io.errors import RunError
from neve.scene.errors import SceneError, SceneWarning
from neve.solver import Blowup

MOST_MEMORY = 1 << 30
"""What reading a file may add to the memory of the process [bytes]: no file is larger than 1 MiB."""
ADDRESS_SPACE = 12 << 30
"""Address space of the process that reads [bytes]."""
MOST_POINTS = 2**22
"""Points in the box around a source: what is far larger only takes longer."""
KEYS = ("sources.0", "colliders.0", "robots.0", "bodies and robots", "particle ")
"""How a sentence begins that names the file by its key, or a particle of a state."""
LONGEST = 1200
"""Characters of a sentence at most."""


def read_damaged(seed: int, number: int) -> Outcome:
    """Read file `number` of `seed`: kinds take turns, and which damages it has follows from both."""
    kinds = list(corpus())
    kind = kinds[number % len(kinds)]
    rng = np.random.default_rng([seed, number, 15])
    whole = corpus()[kind]
    one, other = (whole[rng.integers(len(whole))] for _ in range(2))
    content = damaged_file(kind, one, other, rng)
    with tempfile.TemporaryDirectory(prefix="neve-") as folder:
        path = Path(folder) / f"{number:06d}.{kind}"
        path.write_bytes(content)
        before = _peak()
        fault, sentence = _attempt(READERS[kind], path)
        grown = _peak() - before
    if not fault and grown > MOST_MEMORY:
        fault = f"took {grown / 2**30:.2g} GiB to read {len(content):,} bytes"
    facts = {"kind": kind, "told": sentence.replace(f"{path.parent}{os.sep}", "")}
    return Outcome(seed, number, "failed" if fault else "held", kind, fault, 0.0, facts)


def _attempt(reader: Callable[[Path], object], path: Path) -> tuple[str, str]:
    """Return what is wrong with how `reader` takes the file, and the sentence by which it refuses it."""
    with _limits(), warnings.catch_warnings(record=True) as heard:
        warnings.simplefilter("always")
        try:
            reader(path)
            said = ""
        except (SceneError, RunError, Blowup) as error:
            said = str(error)
        except Exception as error:
            last = traceback.extract_tb(error.__traceback__)[-1]
            where = f"{Path(last.filename).name}:{last.lineno}"
            return f"{type(error).__name__} in {where}: {' '.join(str(error).split())[:200]}", ""
    loud = [f"{w.category.__name__}: {w.message}" for w in heard if not issubclass(w.category, SceneWarning)]
    if loud:
        return f"warned: {' '.join(loud[0].split())[:200]}", said
    if said and (len(said) > LONGEST or "\n" in said or not _names(said, path)):
        return f"not one sentence that names the file or its key: {said[:300]}", said
    return "", said


def _names(said: str, path: Path) -> bool:
    return f"{path.name.partition('.')[0]}." in said or said.startswith(KEYS)


def _peak() -> int:
    """Return the most memory that the process has had [bytes]; 0 if the system does not say."""
    if sys.platform == "win32":
        return 0
    import resource

    unit = 1 if sys.platform == "darwin" else 1024
    return unit * resource.getrusage(resource.RUSAGE_SELF).ru_maxrss


@contextlib.contextmanager
def _limits() -> Iterator[None]:
    """Hold the process to its address space in the block, and keep no grid of a damaged mesh."""
    cache = os.environ.get("NEVE_CACHE")
    os.environ["NEVE_CACHE"] = ""
    try:
        with _address_space():
            yield
    finally:
        if cache is None:
            del os.environ["NEVE_CACHE"]
        else:
            os.environ["NEVE_CACHE"] = cache


@contextlib.contextmanager
def _address_space() -> Iterator[None]:
    if sys.platform == "win32":
        yield
        return
    import resource

    soft, hard = resource.getrlimit(resource.RLIMIT_AS)
    bounds = [limit for limit in (soft, hard) if limit != resource.RLIM_INFINITY]
    resource.setrlimit(resource.RLIMIT_AS, (min([ADDRESS_SPACE, *bounds]), hard))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_AS, (soft, hard))


def _scene(path: Path) -> None:
    from neve.scene.checks.advice import advice
    from neve.scene.reading.load import load

    list(advice(load(str(path))))


def _source(**keys: Any) -> None:
    """Fill a source with particles; more than MOST_POINTS are refused, as Neve refuses more than 2.7e8."""
    from neve.sampling import fill, room
    from neve.scene.reading.load import scene_from

    scene = scene_from({"sources": [keys], "numerics": {"dx": 0.25}})
    usual, room.MOST = room.MOST, MOST_POINTS
    try:
        fill(scene.sources[0], scene.numerics, 0)
    finally:
        room.MOST = usual


def _mesh(path: Path) -> None:
    _source(shape="mesh", file=str(path))


def _font(path: Path) -> None:
    _source(shape="text", text="NEVE gQ", font=str(path), height=0.5)


def _terrain(path: Path) -> None:
    from neve.geometry.terrain import height_field
    from neve.scene.reading.load import scene_from

    collider = {"shape": "terrain", "file": str(path), "size": [4.0, 4.0]}
    scene = scene_from({"sources": [{"shape": "sphere"}], "colliders": [collider]})
    height_field(scene.colliders[0], "colliders.0")  # type: ignore[arg-type]


def _robot(path: Path) -> None:
    from neve.rigid.bodies import RigidBodies
    from neve.scene.reading.load import scene_from

    robot = {"file": str(path), "position": [0.0, 0.0, 1.0]}
    bodies = RigidBodies(scene_from({"sources": [{"shape": "sphere"}], "robots": [robot]}), ())
    _ = bodies.motion.mobility


READERS: dict[str, Callable[[Path], object]] = {
    "toml": _scene,
    "xml": _robot,
    "urdf": _robot,
    "ttf": _font,
    **dict.fromkeys(("obj", "ply", "stl", "glb", "gltf"), _mesh),
    **dict.fromkeys(("png", "tif", "asc", "npy"), _terrain),
    **readers(),
}


def summary(seen: Sequence[Outcome]) -> str:
    """Say of each kind how many files were read in spite of their damage."""
    read = Counter(str(o.facts.get("kind")) for o in seen if o.verdict == "held" and not o.facts.get("told"))
    every = Counter(str(o.facts.get("kind", "lost")) for o in seen)
    parts = [f"{kind} {read[kind]:,} of {every[kind]:,}" for kind in sorted(every)]
    return f"read in spite of the damage: {', '.join(parts)}; the others were told in one sentence"
