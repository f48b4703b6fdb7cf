"""Record the last bits of small runs, to see that a refactoring changes none of them.

    python tools/golden.py record before.json     # with the installed Neve
    python tools/golden.py check before.json      # after it was installed again; exit code 1 if a bit differs
    python tools/golden.py record few.json --share 0.1

docs/design.md says on which machines the bits are the same. Every law, transfer, spline and preset, both
precisions, colliders, rigid bodies, meshes, terrain and a robot take part.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import sys
import tempfile
import tomllib
import warnings
from pathlib import Path
from typing import Any

import numpy as np

import neve
from neve.scene.errors import SceneWarning

SECONDS = 0.03
"""Simulated time of the small scenes [s]."""

LANDING = """
[numerics]
dx = 0.05
[[sources]]
shape = "sphere"
radius = 0.25
center = [0, 0, 0.24]
velocity = [1, 0, -5]
[[colliders]]
shape = "plane"
mu_c = 0.3
[[colliders]]
shape = "cylinder"
radius = 0.1
height = 0.2
center = [0.2, 0, 0.1]
spin = [0, 0, 90]
"""

SPLIT = """
[numerics]
dx = 0.05
[[sources]]
shape = "box"
size = [0.4, 0.4, 0.3]
center = [0, 0, 0.15]
variation = { stiffness = 0.3, strength = 0.3, density = 0.1, feature_size = 0.1, seed = 3 }
[[sources]]
shape = "box"
size = [0.2, 0.2, 0.2]
center = [0, 0, 0.45]
velocity = [0, 0, -6]
snow = { law = "drucker_prager" }
[[colliders]]
shape = "plane"
"""

PILED = """
[numerics]
dx = 0.05
dt = 2e-3
implicit_strain = 1.0
[[sources]]
shape = "box"
size = [0.3, 0.3, 0.2]
center = [0, 0, 0.1]
snow = { E0 = 1e7 }
[[sources]]
shape = "sphere"
radius = 0.12
center = [0.05, 0, 0.34]
velocity = [0, 0, -1]
[[sources]]
shape = "sphere"
radius = 0.12
center = [1, 0, 0.5]
velocity = [1, 0, 0]
[[colliders]]
shape = "plane"
mu_c = 0.3
"""

ROBOT = """
[numerics]
dx = 0.05
[[sources]]
shape = "layer"
size = [1.0, 0.6]
depth = 0.15
[[colliders]]
shape = "plane"
[[robots]]
file = "cart.xml"
position = [0, 0, 0.22]
controls = [{ t = 0, actuator = "drive", value = 6 }]
"""
CART = """
<mujoco><worldbody><body name="cart"><freejoint/><geom type="box" size="0.2 0.1 0.04" mass="20"/>
<body name="axle" pos="0.1 0 -0.05"><joint name="spin" type="hinge" axis="0 1 0"/>
<geom type="cylinder" size="0.09 0.12" euler="90 0 0" mass="4"/></body></body></worldbody>
<actuator><velocity name="drive" joint="spin" kv="5"/></actuator></mujoco>
"""

# name: scene (TOML, or a preset), changes, simulated time [s]
CASES: dict[str, tuple[str, tuple[str, ...], float]] = {
    "stomakhin2013 apic quadratic float32": (LANDING, (), SECONDS),
    "stomakhin2013 flip cubic float64": (
        LANDING,
        ("numerics.transfer=flip", "numerics.spline=cubic", "numerics.precision=float64"),
        SECONDS,
    ),
    "neo_hookean pic cubic float32": (
        LANDING,
        ("snow.law=neo_hookean", "numerics.transfer=pic", "numerics.spline=cubic"),
        SECONDS,
    ),
    "hencky asflip quadratic float32": (
        LANDING,
        ("snow.law=hencky", "numerics.transfer=asflip"),
        SECONDS,
    ),
    "drucker_prager polypic 8 quadratic float64": (
        LANDING,
        ("snow.law=drucker_prager", "numerics.transfer=polypic", "numerics.precision=float64"),
        SECONDS,
    ),
    "cam_clay polypic 27 cubic float32": (
        LANDING,
        (
            "snow.law=cam_clay",
            "numerics.transfer=polypic",
            "numerics.polypic_modes=27",
            "numerics.spline=cubic",
        ),
        SECONDS,
    ),
    "two laws, variation, flip quadratic float32": (SPLIT, ("numerics.transfer=flip",), SECONDS),
    "ball_on_snow": ("ball_on_snow", ("numerics.dx=0.12",), 0.5),
    "boot": ("boot", ("numerics.dx=0.02",), 0.2),
    "avalanche": ("avalanche", ("numerics.dx=0.2",), 0.1),
    "wheel": ("wheel", ("numerics.dx=0.06",), 0.1),
    "robot": (ROBOT, (), 0.1),
    "two laws, variation, apic quadratic float64": (SPLIT, ("numerics.precision=float64",), SECONDS),
    "semi-implicit float32": (PILED, ("numerics.integrator=semi_implicit",), 2 * SECONDS),
    "semi-implicit, raw system, float64": (
        PILED,
        (
            "numerics.integrator=semi_implicit",
            "numerics.implicit_system=raw",
            "numerics.precision=float64",
        ),
        2 * SECONDS,
    ),
    "implicit float64": (
        PILED,
        ("numerics.integrator=implicit", "numerics.precision=float64"),
        2 * SECONDS,
    ),
    "castle": ("castle", ("numerics.dx=0.14",), 0.03),
    "collide": ("collide", ("numerics.dx=0.14",), 0.03),
    "cube_on_snow": ("cube_on_snow", ("numerics.dx=0.14",), 0.03),
    "plow": ("plow", ("numerics.dx=0.15",), 0.03),
    "roll": ("roll", ("numerics.dx=0.1",), 0.03),
    "snowball_wall": ("snowball_wall", ("numerics.dx=0.12",), 0.03),
    "snowballs_collide": ("snowballs_collide", ("numerics.dx=0.15",), 0.03),
    "text_fall": ("text_fall", ("numerics.dx=0.12",), 0.03),
    "throw_ball": ("throw_ball", ("numerics.dx=0.12",), 0.03),
    "throw_cube": ("throw_cube", ("numerics.dx=0.15",), 0.03),
    "walk": ("walk", ("numerics.dx=0.04",), 0.03),
}


def verdict(known: str | None, found: str) -> str:
    """Say how the hash of a run compares to the recorded one."""
    if known is None:
        return "not recorded"
    return "same" if known == found else "DIFFERS"


def digest(arrays: dict[str, Any]) -> str:
    """Return the hash of named arrays, names and types included."""
    seen = hashlib.sha256()
    for name in sorted(arrays):
        values = np.ascontiguousarray(arrays[name])
        seen.update(f"{name} {values.dtype} {values.shape}".encode())
        seen.update(values.tobytes())
    return seen.hexdigest()[:32]


def run(text: str, changes: tuple[str, ...], seconds: float) -> str:
    """Simulate a scene and return the hash of all that its checkpoint would hold."""
    with tempfile.TemporaryDirectory() as folder, warnings.catch_warnings():
        warnings.simplefilter("ignore", SceneWarning)
        path = text
        if "\n" in text:
            tomllib.loads(text)
            (Path(folder) / "cart.xml").write_text(CART, encoding="utf-8")
            path = f"{folder}/scene.toml"
            Path(path).write_text(text, encoding="utf-8")
        sim = neve.Simulation(neve.load(path, list(changes)))
        sim.advance(seconds)
        return digest(sim.arrays())


def main() -> int:
    """Record or check."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("what", choices=["record", "check"])
    parser.add_argument("file", type=Path)
    parser.add_argument("--share", type=float, default=1.0, help="share of the time that is simulated")
    asked = parser.parse_args()
    known = {}
    if asked.what == "check":
        try:
            known = json.loads(asked.file.read_text(encoding="utf-8"))
        except (OSError, ValueError) as error:
            parser.error(f"{asked.file} holds no recorded hashes: {error}")
    found: dict[str, str] = {}
    for name, (text, changes, seconds) in CASES.items():
        found[name] = run(text, changes, asked.share * seconds)
        told = "" if asked.what == "record" else verdict(known.get(name), found[name])
        print(f"{found[name]}  {name}  {told}", flush=True)
    if asked.what == "record":
        asked.file.write_text(json.dumps(found, indent=1) + "\n", encoding="utf-8")
        return 0
    return int(found != known)


if __name__ == "__main__":
    sys.exit(main())
