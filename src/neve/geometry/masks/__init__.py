"""Masks of layers: pictures and rasters that say where snow lies, or how deep."""
