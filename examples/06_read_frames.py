"""Read the frames of a run with NumPy: measure how dense the snow is, and where.

    python examples/06_read_frames.py                    # runs ball_on_snow first; under a minute

Every frame is an .npz file whose arrays are described in docs/run_folder.md: they are yours to load anywhere.
"""

import sys
from pathlib import Path

import numpy as np

import neve

scene = neve.load("ball_on_snow", ["numerics.dx=0.08", "run.film=false", *sys.argv[1:]])
neve.Simulation(scene).run(out="runs/dense", force=True)

frames = sorted(Path("runs/dense/frames").glob("*.npz"))
print(f"{'time [s]':>9} {'fastest [m/s]':>14} {'density under the ball, over that of fresh snow':>48}")
for path in frames[:: max(1, len(frames) // 10)]:
    with np.load(path) as frame:
        x, v, J_P = frame["x"], frame["v"], frame["J_P"]
        under = np.hypot(x[:, 0], x[:, 1]) < 0.2
        denser = np.mean(1 / J_P[under]) if under.any() else np.nan
        print(f"{float(frame['time']):9.3f} {np.linalg.norm(v, axis=1).max():14.2f} {denser:48.3f}")
