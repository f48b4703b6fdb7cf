"""The formats that frames can be exported to, by the word of `--to`."""

from __future__ import annotations

from neve.registry import Registry

FORMATS = Registry(
    "the format",
    {
        "ply": "neve.export.formats.ply:Ply",
        "vtk": "neve.export.formats.vtk:Vtk",
    },
    {
        "ply": "points with all fields, binary",
        "vtk": "points and solids for ParaView, with .pvd files of their times",
    },
)
"""Subclasses of `neve.export.format.Format`."""
