"""Small whole files of every kind that Neve reads, made by code; what is damaged."""

from __future__ import annotations

import io
from functools import lru_cache
from pathlib import Path
from typing import Any, Literal

import numpy as np

from neve.fuzz.files.runs import FILES, FRAME, STATE, run_files
from neve.fuzz.files.solids import solids

SCENE = """about = "A ball, a box of other snow, a floor and a wheel."
[world]
gravity = [0, 0, -9.81]
[numerics]
dx = 0.1
transfer = "flip"
flip_alpha = 0.9
[snow]
kind = "wet"
[[sources]]
shape = "sphere"
center = [0, 0, 1.5]
radius = 0.3
velocity = [1.0, 0.0, -2.0]
variation = { stiffness = 0.3, feature_size = 0.2 }
[[sources]]
shape = "box"
size = [0.4, 0.4, 0.4]
snow = { law = "cam_clay", beta = 0.3 }
profile = { at = [0, 0.2], density = [1, 1.2] }
[[colliders]]
shape = "plane"
mu_c = 0.4
[[colliders]]
shape = "cylinder"
radius = 0.2
keyframes = [{ t = 0, position = [0, 0, 2] }, { t = 1, position = [0, 1, 2] }]
[[bodies]]
shape = "box"
size = [0.2, 0.2, 0.2]
joint = "hinge"
axis = [0, 1, 0]
motor = { kind = "velocity", target = 3 }
[[outputs]]
kind = "frames"
every_frames = 2
[run]
duration = 0.5
film = false
"""
MJCF = """<mujoco model="car">
  <compiler angle="degree"/><option timestep="0.01"/>
  <default><default class="wheel"><geom type="cylinder" size=".1 .03" friction="1.2"/></default></default>
  <asset><mesh name="tip" vertex="0 0 0 .1 0 0 0 .1 0 0 0 .1"/><material name="m" rgba=".1 .2 .3 1"/></asset>
  <worldbody><body name="chassis" pos="0 0 0.15"><freejoint/>
    <geom name="hull" type="box" size=".3 .12 .04" density="300" material="m"/>
    <geom type="mesh" mesh="tip"/>
    <body name="left" pos=".1 .2 -.05" quat="1 1 0 0"><joint name="axle" axis="0 0 -1" range="-90 90"/>
      <geom class="wheel"/></body>
    <replicate count="3" offset="0 0 .3"><body><joint type="ball"/><geom type="capsule" size=".04 .1"/></body>
    </replicate></body></worldbody>
  <actuator><velocity name="drive" joint="axle" kv="2" ctrlrange="-20 20"/></actuator>
  <keyframe><key name="k" time="0"/></keyframe>
</mujoco>
"""
URDF = """<robot name="arm">
<link name="base"><inertial><mass value="1"/><inertia ixx="0.1" iyy="0.1" izz="0.1" ixy="0" ixz="0" iyz="0"/></inertial>
  <collision><origin xyz="0 0 0" rpy="0 0 1"/><geometry><box size="0.2 0.2 0.1"/></geometry></collision></link>
<link name="hand"><inertial><mass value="2"/><inertia ixx="0.1" iyy="0.1" izz="0.1" ixy="0" ixz="0" iyz="0"/></inertial>
  <collision><geometry><cylinder radius="0.05" length="0.4"/></geometry></collision></link>
<joint name="wrist" type="revolute"><parent link="base"/><child link="hand"/><origin xyz="0 0 0.1"/>
  <axis xyz="0 1 0"/><limit lower="-1" upper="1" effort="40" velocity="1"/></joint>
</robot>
"""  # noqa: E501

Files = dict[str, tuple[bytes, ...]]


@lru_cache
def corpus() -> Files:
    """Return the whole files by kind, each kind named after the ending of its files."""
    found: Files = {
        "toml": (SCENE.encode(),),
        "xml": (MJCF.encode(),),
        "urdf": (URDF.encode(),),
        "ttf": ((Path(__file__).parents[2] / "assets" / "FredokaOne-Regular.ttf").read_bytes(),),
        "png": (_picture("png", np.uint8), _picture("png", np.uint16)),
        "tif": (
            _picture("tiff", np.uint8),
            _picture("tiff", np.uint16, compression="tiff_lzw"),
            _picture("tiff", np.float32, compression="tiff_adobe_deflate"),
            _geotiff(">", bigtiff=True, compression="zlib", tile=(16, 16)),
            _geotiff("<", rowsperstrip=5),
        ),
        "asc": (_text_grid(),),
        "npy": (_array(np.float64), _array(np.int16)),
    }
    files = run_files()
    of_run = {name: (files[name],) for name in FILES}
    found |= solids()
    return found | of_run | {STATE: (files["checkpoint"],), "frame.npz": (files[FRAME],)}


def heights() -> np.ndarray[Any, Any]:
    """Return 12 x 16 heights of a hill [m]."""
    x, y = np.meshgrid(np.linspace(-1, 1, 12), np.linspace(-1, 1, 16), indexing="ij")
    return np.asarray(100.0 / (1.0 + x * x + 2.0 * y * y))


def _picture(kind: str, number: Any, **options: Any) -> bytes:
    from PIL import Image

    file = io.BytesIO()
    Image.fromarray(heights().astype(number)).save(file, format=kind, **options)
    return file.getvalue()


def _geotiff(order: Literal["<", ">"], **options: Any) -> bytes:
    """Return a GeoTIFF of pixels of 2 m, with a value for missing heights, in Texas's feet."""
    from tifffile import imwrite

    keys = (1, 1, 0, 3, 1024, 0, 1, 1, 3072, 0, 1, 2277, 4099, 0, 1, 9002)
    tags = [
        (33550, "d", 3, (2.0, 2.0, 0.0), True),
        (33922, "d", 6, (0.0, 0.0, 0.0, 5e5, 5e6, 0.0), True),
        (34735, "H", len(keys), keys, True),
        (42113, "s", 0, "-9999", True),
    ]
    file = io.BytesIO()
    imwrite(file, heights().astype(np.float32), byteorder=order, extratags=tags, metadata=None, **options)
    return file.getvalue()


def _text_grid() -> bytes:
    head = "ncols 16\nnrows 12\nxllcorner 5e5\nyllcorner 5e6\ncellsize 2\nNODATA_value -9999\n"
    rows = (" ".join(f"{z:.3f}" for z in row) for row in heights())
    return (head + "\n".join(rows)).encode()


def _array(number: Any) -> bytes:
    file = io.BytesIO()
    np.save(file, heights().astype(number))
    return file.getvalue()
