"""What a page changes: entries of the scene, snow that is touched, solids that are dragged."""
