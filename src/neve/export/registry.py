"""The formats that frames can be exported to, by the word of `--to`."""

from __future__ import annotations

from neve.registry import Registry

FORMATS = Registry(
    "the format",
    {
        "ply": "neve.export.formats.ply:Ply",
        "obj": "neve.export.formats.obj:Obj",
        "glb": "neve.export.formats.glb:Glb",
        "abc": "neve.export.formats.alembic:Alembic",
        "usd": "neve.export.formats.usd:Usd",
        "vdb": "neve.export.formats.vdb:Vdb",
        "vtk": "neve.export.formats.vtk:Vtk",
    },
    {
        "ply": "points with all fields, binary",
        "obj": "the surface of the snow and the solids as meshes, text",
        "glb": "the same as a glTF scene, binary, with velocities",
        "abc": "points, surface and solids as Alembic, one file for all frames",
        "usd": "points and solids as a USD stage, a layer for each frame",
        "vdb": "density and velocity as OpenVDB volumes",
        "vtk": "points, a grid and solids for ParaView, with .pvd files of their times",
    },
)
"""Subclasses of `neve.export.format.Format`."""
