"""Add an output of your own: a table of how high the snow reaches, written while the scene runs.

    python examples/05_own_output.py                     # a few seconds; leaves runs/own_output

A scene file can ask for it too, wherever this module has been imported:

    [[outputs]]
    kind = "height"
    every_seconds = 0.1
"""

import sys

import neve
from neve.scene import scene_from

SCENE = {
    "numerics": {"dx": 0.1},
    "run": {"duration": 0.6, "film": False},
    "sources": [{"shape": "sphere", "center": [0.0, 0.0, 1.0], "velocity": [0.0, 0.0, -3.0]}],
    "colliders": [{"shape": "plane"}],
    "outputs": [{"kind": "height", "every_seconds": 0.1}],
}


@neve.register_output("height")
class Height:
    """Write a table of the height below which a share of the particles lies [m]."""

    def __init__(self, name: str = "height.csv", share: float = 0.99) -> None:
        self.name, self.share = name, share

    def write(self, context):
        """Add a row; called at each frame that is due."""
        z = sorted(context.content.x[:, 2])
        context.add_row(self.name, {"height": float(z[int(self.share * (len(z) - 1))])})

    def close(self, context):
        """Do nothing: each row is complete."""


def main(changes: list[str]) -> None:
    """Run the scene with the table that it asks for, and with another one given as an object."""
    sim = neve.Simulation(scene_from(SCENE, changes))
    sim.run("runs/own_output", force=True, outputs=[Height("middle.csv", share=0.5)])
    print("wrote runs/own_output/height.csv, every 0.1 s, and middle.csv, every frame")


if __name__ == "__main__":
    main(sys.argv[1:])
