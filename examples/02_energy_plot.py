"""Plot where the energy of a snowball goes: kinetic, elastic, potential, and what contact takes.

    python examples/02_energy_plot.py                    # needs matplotlib; plot in runs/energy.png

docs/run_folder.md describes the columns of log.csv.
"""

import sys

import matplotlib as mpl
import numpy as np

import neve

mpl.use("Agg")
import matplotlib.pyplot as plt

scene = neve.load("throw_ball", ["numerics.dx=0.08", "run.film=false", *sys.argv[1:]])
neve.Simulation(scene).run(out="runs/energy", force=True)
log = np.genfromtxt("runs/energy/log.csv", delimiter=",", names=True, dtype=None, encoding="utf-8")

total = log["kinetic"] + log["elastic"] + log["potential"]
figure, axes = plt.subplots(layout="constrained")
for name in ("kinetic", "elastic", "potential"):
    axes.plot(log["time"], log[name], label=name)
axes.plot(log["time"], total, color="black", label="sum")
axes.set(xlabel="time [s]", ylabel="energy [J]", title="A snowball hits the ground")
axes.legend()
figure.savefig("runs/energy.png", dpi=150)

lost = 1 - total[-1] / total[0]
if lost >= 0:
    print(f"{lost:.0%} of the energy is lost to plastic flow, friction and impact")
else:
    print(f"the sum of the energies grew by {-lost:.1%}")
