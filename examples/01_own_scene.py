"""Describe a scene of your own, in Python, and save it as a file that `neve run` reads.

    python examples/01_own_scene.py                      # half a minute; film in runs/letters
    python examples/01_own_scene.py snow.kind=wet        # the same with other snow

All keys with their units and ranges: docs/scene_format.md. Lengths are metres, z points up.
"""

import sys
from pathlib import Path

import neve
from neve.scene import Collider, Numerics, Run, Snow, Source, to_toml

scene = neve.Scene(
    about="Letters of snow fall on a soft layer beside a step.",
    numerics=Numerics(dx=0.06),
    snow=Snow(kind="packed"),
    sources=(
        Source.of("text", text="Neve", height=0.7, depth=0.3, center=(0.0, 0.0, 1.4)),
        Source.of("layer", center=(0.0, 0.0), size=(3.0, 1.2), depth=0.3),
    ),
    colliders=(
        Collider.of("plane", mu_c=0.4),
        Collider.of("box", center=(0.8, 0.0, 0.4), size=(0.5, 1.2, 0.2)),
    ),
    run=Run(duration=1.0),
)

path = Path("runs") / "letters.toml"
path.parent.mkdir(exist_ok=True)
path.write_text(to_toml(scene), encoding="utf-8")

# From here on it is a file like any other; `neve run runs/letters.toml` does the same.
sim = neve.Simulation(neve.load(path, sys.argv[1:]))
sim.run(out="runs/letters", force=True)
