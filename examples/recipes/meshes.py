"""Write the meshes of the recipes: drum.obj, a tube, and bin.obj, a box without a lid."""

from pathlib import Path

import numpy as np

Corners = list[list[float]]
Faces = list[list[int]]


def tube(inner: float, outer: float, length: float, sides: int = 96) -> tuple[Corners, Faces]:
    """Return corners and faces of a tube around the y axis: radii and length [m]."""
    angle = 2 * np.pi * np.arange(sides) / sides
    rings = [(outer, -1), (outer, 1), (inner, 1), (inner, -1)]
    corners = [
        [radius * np.sin(a), 0.5 * side * length, radius * np.cos(a)] for radius, side in rings for a in angle
    ]
    faces = []
    for ring in range(4):
        a, b = ring * sides, (ring + 1) % 4 * sides
        for k in range(sides):
            after = (k + 1) % sides
            faces.append([a + k, a + after, b + after, b + k])
    return corners, faces


def bin_of(size: tuple[float, float, float], wall: float) -> tuple[Corners, Faces]:
    """Return corners and faces of an open box, size and walls [m]; its origin is on its right lower edge."""
    x, y, z = size
    base = np.array([[-x, -y / 2], [0, -y / 2], [0, y / 2], [-x, y / 2]])
    inward = wall * np.array([[1, 1], [-1, 1], [-1, -1], [1, -1]])
    levels = [(base, 0.0), (base, z), (base + inward, z), (base + inward, wall)]
    corners = [[*place, height] for places, height in levels for place in places.tolist()]
    faces = [[3, 2, 1, 0], [12, 13, 14, 15]]
    for level in range(3):
        for k in range(4):
            after = (k + 1) % 4
            faces.append([4 * level + k, 4 * level + after, 4 * level + 4 + after, 4 * level + 4 + k])
    return corners, faces


def write(name: str, mesh: tuple[Corners, Faces]) -> None:
    """Write an OBJ file beside this one."""
    corners, faces = mesh
    lines = [f"v {x:.5g} {y:.5g} {z:.5g}" for x, y, z in corners]
    lines += ["f " + " ".join(str(corner + 1) for corner in face) for face in faces]
    Path(__file__).with_name(name).write_text("\n".join(lines) + "\n", encoding="utf-8")


if __name__ == "__main__":
    write("drum.obj", tube(0.5, 0.6, 0.7))
    write("bin.obj", bin_of((1.0, 0.8, 0.7), 0.1))
