"""`neve drive --fit`: the game's snow fitted to runs with a wheel, and a recording for the page."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

from neve.drive.fit import Fit, fitted
from neve.drive.recording import write_recording
from neve.drive.track import Passage, Track, measured


def fit_runs(
    runs: Sequence[str], wheel: str | None = None, tell: Callable[[str], None] = print
) -> tuple[Fit, Path]:
    """Fit the game's snow to the wheels of run folders; return it with the recording of the first.

    wheel: name of the body that is the wheel, where there are several. Writes `drive.json` into the first.
    Errors: RunError, SceneError, one sentence each.
    """
    passages = [Passage(run, wheel) for run in runs]
    tracks = [measured(passage) for passage in passages]
    fit = fitted(tracks)
    for line in report(runs, tracks, fit):
        tell(line)
    return fit, write_recording(passages[0], tracks[0], fit)


def report(runs: Sequence[str], tracks: Sequence[Track], fit: Fit) -> list[str]:
    """Return what a fit says, in lines."""
    snow = fit.snow
    lines = [
        f"strain {snow.strain:.3f} (standard error {fit.strain_error:.2g}), pressure {snow.pressure:.0f} Pa "
        f"({fit.pressure_error:.2g}), compaction {snow.compaction:.2f} (measured in the rut)",
        f"sinkage differs by {100 * fit.residual:.1f} cm (root mean square); the rut is "
        f"{fit.density_ratio[0]:.2f} times as dense as the snow, by the law {fit.density_ratio[1]:.2f} times",
    ]
    for run, track, predicted in zip(runs, tracks, fit.predicted, strict=True):
        load, sinkage = track.load, track.sinkage
        lines.append(
            f"{run}: {track.wheel.name}, {len(load)} moments of {load.min():.0f} to {load.max():.0f} N, "
            f"sinkage {100 * sinkage.min():.1f} to {100 * sinkage.max():.1f} cm, by the law "
            f"{100 * predicted.min():.1f} to {100 * predicted.max():.1f} cm"
        )
    if fit.untold:
        lines.append(
            f"warning: {' and '.join(fit.untold)} could be others: loads that are alike, or pressures far "
            "below the fitted one, tell no more than strain / pressure = "
            f"{snow.strain / snow.pressure:.3g} per Pa."
        )
    return lines
