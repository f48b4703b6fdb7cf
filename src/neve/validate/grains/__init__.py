"""Loose and cohesive grains: columns, slopes, cuts and sliding blocks."""
