"""Roll one wheel over the same snow by MPM and by the game method: the runs and the plot of docs/contrast.md.

    python examples/studies/contrast.py mpm [--out DIR] [--threads N]    # three runs of some five minutes
    python examples/studies/contrast.py game [--out DIR]                 # the page of neve drive, a Chromium
    python examples/studies/contrast.py show [--out DIR] [--image FILE]  # plot (matplotlib) and table

The game's snow has three numbers that no snow has: the compaction is what MPM shows, the other two are fitted
to the depths of the ruts by MPM.
"""

from __future__ import annotations

import argparse
import json
import os
import shutil
import threading
import time
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

from neve.scene import scene_from
from neve.simulation import Simulation

Array = NDArray[np.float64]

G = 9.81
"""[m/s2]"""
RADIUS, WIDTH = 0.35, 0.25
"""Wheel [m]."""
DEPTH, DENSITY = 0.3, 250.0
"""Snow: depth of the layer [m], density [kg/m3]."""
LOADS = (122.0, 244.0, 366.0)
"""What the wheel bears, itself included [kg]."""
WHEEL = 22.0
"""Mass of the wheel alone [kg]."""
SPEED = 1.6
"""Speed at which it is towed [m/s]."""
START, ALONG = -0.95, 0.2
"""Place of the axle at the start, and half the length over which profiles are averaged [m]."""
BIN = 0.03
"""Width of a bin across the track [m]."""


def scene(load: float, dx: float) -> dict[str, Any]:
    """Return the scene of a wheel that bears `load` [kg], towed, free to turn, on a flat layer of snow."""
    top = DEPTH + RADIUS + 0.01
    linked = {"contacts": False, "visible": False, "shape": "box", "size": [0.2, 0.2, 0.2]}
    x, z = [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]
    return {
        "numerics": {"dx": dx},
        "snow": {
            "law": "cam_clay", "rho0": DENSITY, "E0": 4e5, "nu": 0.2, "xi": 0.5, "M": 1.2, "beta": 0.4,
            "p0": 8e3,
        },
        "sources": [{"shape": "layer", "size": [2.7, 1.2], "depth": DEPTH}],
        "colliders": [{"shape": "plane", "mu_c": 0.8}],
        "bodies": [
            {**linked, "center": [START, 0.0, top + 0.9], "mass": 2.0, "joint": "slide", "axis": x,
             "motor": {"kind": "velocity", "gain": 4000.0,
                       "keyframes": [{"t": 0.1, "value": 0.0}, {"t": 0.4, "value": SPEED}]}},
            {**linked, "center": [START, 0.0, top + 0.5], "mass": load - WHEEL, "parent": 0, "joint": "slide",
             "axis": z},
            {"shape": "cylinder", "center": [START, 0.0, top], "rotation": [90.0, 0.0, 0.0], "radius": RADIUS,
             "height": WIDTH, "mass": WHEEL, "mu_c": 0.4, "parent": 1, "joint": "hinge",
             "axis": [0.0, 1.0, 0.0]},
        ],
        "run": {"duration": 1.5, "film": False},
    }  # fmt: skip


def profile(x: Array, half: float) -> tuple[Array, Array]:
    """Return places across the track and the height of the snow there [m], a mean along the track.

    The height of a bin is that of its highest particle, and `half` a particle's distance more.
    """
    here = x[np.abs(x[:, 0]) < ALONG]
    across = np.round(here[:, 1] / BIN).astype(int)
    along = np.floor((here[:, 0] + ALONG) / (2 * BIN)).astype(int)
    most = int(0.56 / BIN)
    tops = np.full((2 * most + 1, int(np.ceil(ALONG / BIN))), np.nan)
    keep = np.abs(across) <= most
    for i, j, height in zip(across[keep] + most, along[keep], here[keep, 2], strict=True):
        tops[i, j] = np.nanmax([tops[i, j], height])
    return np.arange(-most, most + 1) * BIN, np.nanmean(tops, axis=1) + half


def roll(load: float, dx: float, threads: int | None) -> dict[str, Any]:
    """Simulate the wheel with `load` [kg]; return its rut and what it cost."""
    sim = Simulation(scene_from(scene(load, dx)), threads=threads)
    begin, ways = time.perf_counter(), []
    while sim.time < 1.5:
        sim.advance(0.05)
        ways.append((sim.time, *sim.solids()[-1][1].position))
        print(f"{load:g} kg, {sim.time:.2f} s, axle at {ways[-1][1]:.2f} m", flush=True)
    seconds = time.perf_counter() - begin
    across, height = profile(sim.state.x, 0.25 * dx)
    passing = [z for _, x, _, z in ways if abs(x) < ALONG]
    return {
        "load": load, "dx": dx, "particles": len(sim.state.x), "steps": sim.steps, "seconds": seconds,
        "simulated": sim.time, "across": across.tolist(), "height": height.tolist(),
        "sinkage": DEPTH + RADIUS - float(np.mean(passing)),
    }  # fmt: skip


def measured(out: Path) -> list[dict[str, Any]]:
    """Return the runs by MPM that lie in `out`, by load."""
    runs = [json.loads(path.read_text(encoding="utf-8")) for path in out.glob("mpm_*.json")]
    return sorted(runs, key=lambda run: float(run["load"]))


def rut_depth(run: dict[str, Any]) -> float:
    """Return how far the floor of a rut lies below the snow beside it [m]."""
    across, height = np.abs(run["across"]), np.asarray(run["height"])
    return float(np.median(height[across > 0.4]) - np.median(height[across < 0.3 * WIDTH]))


def rim_share(run: dict[str, Any]) -> float:
    """Return the volume above the old surface, as a share of the volume below it."""
    across, height = np.abs(run["across"]), np.asarray(run["height"])
    above = height - np.median(height[across > 0.4])
    return float(above[above > 0.0].sum() / -above[above < 0.0].sum())


def play(out: Path) -> None:
    """Fit the game's snow to the ruts by MPM, and roll each load over it."""
    from playwright.sync_api import sync_playwright

    from neve.drive.serve import listening

    runs = measured(out)
    compaction = 1.0 - max(0.0, min(0.8, float(np.median([rim_share(run) for run in runs]))))
    wheel = {"radius": RADIUS, "width": WIDTH}
    browser = os.environ.get("NEVE_BROWSER") or shutil.which("chromium") or shutil.which("google-chrome")
    with listening("127.0.0.1", 0) as server, sync_playwright() as playwright:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        chromium = playwright.chromium.launch(executable_path=browser, args=["--use-angle=swiftshader"])
        page = chromium.new_page()
        page.goto(f"http://127.0.0.1:{server.server_address[1]}/lab.html")
        page.wait_for_function("window.neveLab")

        def sinkage(load: float, strain: float, pressure: float) -> float:
            given = {"wheel": {**wheel, "load": load * G}, "snow": {"strain": strain, "pressure": pressure}}
            ask = "([wheel, snow, depth, c]) => neveLab.sinkage(wheel, snow, depth, c)"
            return float(page.evaluate(ask, [given["wheel"], given["snow"], DEPTH, compaction]))

        def miss(guess: Array) -> list[float]:
            strain, pressure = 1.0 / (1.0 + np.exp(-guess[0])), np.exp(guess[1])
            return [sinkage(run["load"], strain, pressure) - rut_depth(run) for run in runs]

        found = least_squares(miss, [0.5, np.log(3e4)]).x
        snow = {"strain": 1.0 / (1.0 + np.exp(-found[0])), "pressure": float(np.exp(found[1]))}
        for run in runs:
            given = {**wheel, **snow, "load": run["load"] * G, "depth": DEPTH, "compaction": compaction}
            rut = page.evaluate("given => neveLab.rollWheel(given)", {**given, "speed": SPEED, "passes": 1})
            text = json.dumps({**rut, **snow, "load": run["load"], "compaction": compaction})
            (out / f"game_{run['load']:g}.json").write_text(text, encoding="utf-8")
        server.shutdown()


def show(out: Path, image: Path) -> None:
    """Draw the ruts of both methods into one plot, and print what they cost."""
    import matplotlib.pyplot as plt

    runs = measured(out)
    figure, axes = plt.subplots(1, len(runs), figsize=(4 * len(runs), 3.2), sharey=True, layout="constrained")
    print("| load | rut, MPM | rut, game | MPM: particle-steps, time | game: updates, time |")
    print("|---|---|---|---|---|")
    for axis, run in zip(axes, runs, strict=True):
        game = json.loads((out / f"game_{run['load']:g}.json").read_text(encoding="utf-8"))
        axis.fill_between(run["across"], run["height"], color="#bcd3ea", label="MPM")
        axis.plot(game["across"], game["height"], color="#c0392b", lw=1.6, label="game")
        axis.set(
            title=f"{run['load']:g} kg", xlabel="across the track [m]", xlim=(-0.55, 0.55), ylim=(0, 0.36)
        )
        steps = run["particles"] * run["steps"]
        print(
            f"| {run['load']:g} kg | {100 * rut_depth(run):.1f} cm | {100 * rut_depth(game):.1f} cm "
            f"| {steps / 1e9:.2f} 10^9, {run['seconds']:.0f} s | {game['updates']}, {game['seconds']:.1f} s |"
        )
    print(
        f"game: strain {game['strain']:.3f}, pressure {game['pressure']:.0f} Pa, c {game['compaction']:.3f}"
    )
    axes[0].set_ylabel("height of the snow [m]")
    axes[0].legend(loc="lower left")
    figure.savefig(image, dpi=90)


def main() -> None:
    """Read the command line."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("do", choices=["mpm", "game", "show"])
    parser.add_argument("--load", type=float, action="append")
    parser.add_argument("--dx", type=float, default=0.03)
    parser.add_argument("--out", type=Path, default=Path("runs/contrast"))
    parser.add_argument("--image", type=Path, default=Path("docs/images/contrast.png"))
    parser.add_argument("--threads", type=int)
    options = parser.parse_args()
    options.out.mkdir(parents=True, exist_ok=True)
    if options.do == "game":
        play(options.out)
    elif options.do == "show":
        show(options.out, options.image)
    else:
        for load in options.load or LOADS:
            text = json.dumps(roll(load, options.dx, options.threads))
            (options.out / f"mpm_{load:g}.json").write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
