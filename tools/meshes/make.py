"""Make the meshes that come with Neve: `python tools/meshes/make.py` writes src/neve/assets/meshes/*.ply.

Each is one closed surface in metres, z up, forward to +x where it has a front; where its origin is stands
at the function that makes it. Needs numpy and trimesh.
"""

from __future__ import annotations

import sys
from pathlib import Path

import trimesh
from contour import contour
from figures import boot, car, car_glass, castle, hare
from simplify import simplify
from turned import carrot, hat, pine, rock, tyre

FOLDER = Path(__file__).parents[2] / "src/neve" / "assets" / "meshes"


# Field, two corners of a box around it [m], spacing of the grid [m], triangles.
FIELDS = {
    "boot": (boot, (-0.17, -0.08, -0.02), (0.17, 0.08, 0.30), 0.0032, 9800),
    "car": (car, (-2.2, -0.95, -0.08), (2.2, 0.95, 1.30), 0.022, 9800),
    "car_glass": (car_glass, (-2.0, -0.9, 0.58), (1.5, 0.9, 1.26), 0.03, 2000),
    "castle": (castle, (-1.3, -1.3, -0.07), (1.3, 1.3, 1.37), 0.026, 9000),
    "hare": (hare, (-0.24, -0.15, -0.03), (0.17, 0.15, 0.56), 0.005, 8000),
}
TURNED = {"carrot": carrot, "hat": hat, "pine": pine, "rock": rock, "tyre": tyre}
MESHES = (*FIELDS, *TURNED)


def make(name: str) -> trimesh.Trimesh:
    """Return the mesh of this name."""
    if name in TURNED:
        vertices, faces = TURNED[name]()
    else:
        field, low, high, spacing, target = FIELDS[name]
        vertices, faces = simplify(*contour(field, low, high, spacing), target, 0.02 * spacing)
    return trimesh.Trimesh(vertices.astype("float32"), faces, process=False)


def main() -> None:
    """Write the meshes named on the command line, or all."""
    FOLDER.mkdir(parents=True, exist_ok=True)
    for name in sys.argv[1:] or MESHES:
        mesh = make(name)
        data = mesh.export(file_type="ply", vertex_normal=False)
        (FOLDER / f"{name}.ply").write_bytes(data)
        size = " x ".join(f"{a:.3f}" for a in mesh.extents)
        print(
            f"{name}: {size} m, {len(mesh.faces)} triangles, {mesh.volume:.6g} m3, {len(data)} bytes, "
            f"closed: {mesh.is_watertight}"
        )


if __name__ == "__main__":
    main()
