"""The car on game snow: serve the page of `web/drive`, fit its snow to runs, begin on ground snowed on."""

from neve.drive.bridge import fit_runs
from neve.drive.ground import write_ground
from neve.drive.serve import DriveError, drive

__all__ = ["DriveError", "drive", "fit_runs", "write_ground"]
