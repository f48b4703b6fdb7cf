"""Geometry: triangle meshes, signed distances, terrain and poses."""
