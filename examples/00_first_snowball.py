"""Throw a snowball and film it.

python examples/00_first_snowball.py                       # a minute or two; film in runs/snowball
python examples/00_first_snowball.py numerics.dx=0.08      # changes of values may follow: coarser
"""

import sys

import neve

scene = neve.load("throw_ball", sys.argv[1:])
sim = neve.Simulation(scene)
sim.run(out="runs/snowball", force=True)

print(f"{len(sim.state.x):,} particles, {sim.steps} steps to t = {sim.time:g} s")
print("film: runs/snowball/preview.mp4; arrays: runs/snowball/frames")
