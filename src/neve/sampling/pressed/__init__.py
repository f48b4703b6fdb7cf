"""The inner structure of snow that was pressed by hand: shells, an outline of lumps, planned pieces."""
