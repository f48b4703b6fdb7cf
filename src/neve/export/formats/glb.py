"""GLB: the surface of the snow and the solids as a glTF scene, a file for each frame, in binary.

The format is that of the glTF 2.0 specification (Khronos): a description in JSON, then the arrays.
"""

from __future__ import annotations

import json
import struct
from typing import Any, BinaryIO

import numpy as np
from numpy.typing import NDArray

from neve.export.camera import ASPECT, CameraPose
from neve.export.camera import NAME as CAMERA
from neve.export.format import NAME, Format, replacing
from neve.export.moment import Moment

FLOAT, UNSIGNED = 5126, 5125
VERTICES, CORNERS = 34962, 34963
SNOW_COLOR = (0.93, 0.95, 0.98)
SOLID_COLOR = (0.20, 0.23, 0.27)
"""Linear; of a solid without a colour of its own."""
ALIGNED = 4


class Glb(Format):
    """Write `snow_NNNNNN.glb`: the node `snow` with normals and velocities, one for each solid, and `camera`.

    Velocities [units/s] are the attribute _VELOCITY of the vertices. glTF has y up and metres.
    """

    ending = "glb"
    up = "y"
    takes_fields = False

    def write(self, moment: Moment) -> None:
        """Write the file of a frame."""
        from neve.surface.mesh import snow_surface

        snow = snow_surface(moment.x, self.job.spacing, v=moment.v)
        scene = Scene({"time": moment.time, "frame": moment.frame})
        if len(snow.faces):
            assert snow.velocity is not None
            more = {"NORMAL": snow.normals, "_VELOCITY": snow.velocity}
            scene.add(NAME, snow.vertices, snow.faces, SNOW_COLOR, np.eye(4), more)
        for i, surface in self.solids:
            color = surface.color or SOLID_COLOR
            scene.add(surface.name, surface.vertices, surface.faces, color, moment.poses[i], {})
        scene.look(self.job.camera.at(moment.time))
        with replacing(self.path(self.names(moment.frame)[0])) as file:
            scene.write(file)


class Scene:
    """Collect meshes, and write them as a file."""

    def __init__(self, facts: dict[str, Any]) -> None:
        self._parts: list[NDArray[Any]] = []
        self._size = 0
        self._nodes: list[dict[str, Any]] = []
        self._meshes: list[dict[str, Any]] = []
        self._cameras: list[dict[str, Any]] = []
        self._materials: list[dict[str, Any]] = []
        self._accessors: list[dict[str, Any]] = []
        self._views: list[dict[str, Any]] = []
        self._facts = facts

    def add(
        self,
        name: str,
        vertices: NDArray[Any],
        faces: NDArray[Any],
        color: tuple[float, float, float],
        pose: NDArray[np.float64],
        more: dict[str, NDArray[Any]],
    ) -> None:
        """Add a mesh: vertices (n, 3), faces (m, 3), a matrix to the world (4, 4), more attributes (n, 3)."""
        attributes = {"POSITION": self._accessor(vertices, FLOAT, VERTICES)}
        attributes |= {key: self._accessor(values, FLOAT, VERTICES) for key, values in more.items()}
        primitive = {
            "attributes": attributes,
            "indices": self._accessor(faces.reshape(-1), UNSIGNED, CORNERS),
            "material": len(self._materials),
        }
        surface = {"baseColorFactor": [*color, 1.0], "metallicFactor": 0.0, "roughnessFactor": 1.0}
        self._materials.append({"name": name, "pbrMetallicRoughness": surface})
        columns = [float(value) for value in pose.T.ravel()]
        self._nodes.append({"name": name, "mesh": len(self._meshes), "matrix": columns})
        self._meshes.append({"name": name, "primitives": [primitive]})

    def look(self, pose: CameraPose) -> None:
        """Add a camera."""
        near, far = pose.clipping
        lens = {"yfov": pose.fov, "aspectRatio": ASPECT, "znear": near, "zfar": far}
        columns = [float(value) for value in pose.matrix.T.ravel()]
        self._nodes.append({"name": CAMERA, "camera": len(self._cameras), "matrix": columns})
        self._cameras.append({"name": CAMERA, "type": "perspective", "perspective": lens})

    def write(self, file: BinaryIO) -> None:
        """Write the file."""
        document = {
            "asset": {"version": "2.0", "generator": "Neve"},
            "scene": 0,
            "scenes": [{"nodes": list(range(len(self._nodes))), "extras": self._facts}],
            "nodes": self._nodes,
            "cameras": self._cameras,
            "meshes": self._meshes,
            "materials": self._materials,
            "accessors": self._accessors,
            "bufferViews": self._views,
            "buffers": [{"byteLength": self._size}],
        }
        kept = {
            key: value for key, value in document.items() if value != [] and (self._size or key != "buffers")
        }
        text = json.dumps(kept, separators=(",", ":")).encode()
        text += b" " * (-len(text) % ALIGNED)
        whole = 12 + 8 + len(text) + (8 + self._size if self._size else 0)
        file.write(struct.pack("<4sII", b"glTF", 2, whole) + struct.pack("<I4s", len(text), b"JSON") + text)
        if self._size:
            file.write(struct.pack("<I4s", self._size, b"BIN\0"))
            for part in self._parts:
                file.write(part.tobytes())

    def _accessor(self, values: NDArray[Any], kind: int, target: int) -> int:
        """Take an array; return its number."""
        values = np.ascontiguousarray(values, "<f4" if kind == FLOAT else "<u4")
        self._views.append(
            {"buffer": 0, "byteOffset": self._size, "byteLength": values.nbytes, "target": target}
        )
        self._accessors.append(
            {
                "bufferView": len(self._views) - 1,
                "componentType": kind,
                "count": len(values),
                "type": "VEC3" if values.ndim == 2 else "SCALAR",
                "min": np.atleast_1d(values.min(axis=0)).tolist(),
                "max": np.atleast_1d(values.max(axis=0)).tolist(),
            }
        )
        self._parts.append(values)
        self._size += values.nbytes  # of 4 bytes each: all that follows is aligned
        return len(self._accessors) - 1
