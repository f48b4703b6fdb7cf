"""Files that other tools open: the frames of a run as points, volumes, meshes and scenes."""
