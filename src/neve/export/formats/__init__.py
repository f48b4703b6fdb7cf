"""The formats of `neve export`: one file for each, named in `neve.export.registry`."""
