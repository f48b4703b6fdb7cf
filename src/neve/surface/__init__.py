"""Particles as density, grains, closed surfaces and metaballs: what pictures and other tools are given."""
