"""Files of heights: pictures, GeoTIFF, ASCII grids, SRTM tiles and NumPy arrays."""
