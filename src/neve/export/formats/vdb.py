"""OpenVDB: density and velocity of the snow, a file for each frame."""

from __future__ import annotations

from neve.export.format import Format, replacing
from neve.export.formats.vdb_tree import VdbGrid, leaves_of, write_vdb
from neve.export.grid import snow_grid
from neve.export.moment import Moment


class Vdb(Format):
    """Write `snow_NNNNNN.vdb` with the grids `density` [kg/m3] and `velocity` [units/s].

    A voxel is as large as particles at rest are apart, spread by quadratic B-splines; voxels without snow are
    inactive and 0.
    """

    ending = "vdb"
    takes_fields = False
    weighs = True

    def write(self, moment: Moment) -> None:
        """Write the file of a frame."""
        grid = snow_grid(moment, self.job.spacing, self.job.axes.scale)
        leaves, (density, velocity) = leaves_of(grid.blocks, [grid.density, grid.velocity])
        active = density > 0
        kept = active.any(axis=(1, 2, 3))
        leaves, active = leaves[kept], active[kept]
        place = grid.cell, grid.first
        grids = [
            VdbGrid("density", leaves, active, density[kept], *place, {"class": "fog volume"}),
            VdbGrid("velocity", leaves, active, velocity[kept], *place, {"vector_type": "invariant"}),
        ]
        with replacing(self.path(self.names(moment.frame)[0])) as file:
            write_vdb(file, grids, {"creator": "Neve"})
