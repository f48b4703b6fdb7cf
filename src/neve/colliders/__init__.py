"""Scripted solids and solids at rest: what snow meets, and how colliders move."""
