"""The car on game snow: serve the page that `web/drive` builds."""

from neve.drive.serve import DriveError, drive

__all__ = ["DriveError", "drive"]
