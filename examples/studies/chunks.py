"""Break snow into chunks and measure them: the runs, the plot and the pictures of docs/chunks.md.

    python examples/studies/chunks.py run [CASE]... [--out DIR] [--threads N]  # one to ten minutes each
    python examples/studies/chunks.py show [--out DIR] [--images DIR]  # pictures, plot (matplotlib), table

A case is a scene and a snow or a resolution, such as collide_chunks, collide_fine, collide_fractal,
wall_soft; throw_chunks_1 has the pieces of structure_seed 1.
"""

from __future__ import annotations

import argparse
import json
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from PIL import Image

from neve.fragments import LEAST, Limits, find, size_classes, summary
from neve.render.preview import Preview
from neve.render.shot import Shot
from neve.scene.reading.load import load
from neve.simulation import Simulation

HERE = Path(__file__).parent
SCENES = {
    "collide": (str(HERE / "clods_collide.toml"), 2, 0.6, 0.08),
    "wall": (str(HERE / "clods_wall.toml"), 1, 0.6, 0.066),
    "throw": ("throw_ball", 1, 0.9, 0.06),
}
"""Case -> scene, number of sources, moment at which fragments are counted [s], coarsest numerics.dx [m]."""
SOFT = 'snow={kind="wet"}'
"""Uniform soft snow."""
FINER = {"chunks": 1.0, "fine": 1.4, "finest": 2.0}
SEEDS = range(1, 6)
"""Further structures of the thrown ball, beside that of seed 0."""


class Case(NamedTuple):
    """One run: a scene, changes to it, its moment of measuring [s], the coarse dx over its own."""

    scene: str
    changes: list[str]
    moment: float
    finer: float


def case(name: str) -> Case:
    """Return the case of a name: `SCENE_KIND` or `SCENE_KIND_SEED`."""
    short, kind, *seed = name.split("_")
    scene, sources, moment, dx = SCENES[short]
    finer = FINER.get(kind, 1.0)
    changes = [f"numerics.dx={dx / finer:.5g}"]
    for i in range(sources):
        variation = f"sources.{i}.variation"
        if short == "throw":
            changes += [] if kind in FINER else [f'sources.{i}.structure="plain"']
            changes += [f"sources.{i}.structure_seed={number}" for number in seed]
            continue
        if kind in ("uniform", "soft"):
            changes += [f"{variation}.strength=0"]
        if kind == "fractal":  # smooth noise, as strong at its strongest as the clods may legally be
            changes += [
                f'{variation}.pattern="fractal"',
                f"{variation}.strength=2.9",
                f"{variation}.octaves=2",
            ]
    if kind == "soft":
        changes += [SOFT]
    if kind == "fractal":
        changes += ["snow.p0=1.3e4"]
    return Case(scene, changes, moment, finer)


NAMES = [
    f"{short}_{kind}"
    for short in SCENES
    for kind in (*FINER, "uniform", "soft", *(["fractal"] if short != "throw" else []))
]
NAMES += [f"throw_{kind}_{seed}" for seed in SEEDS for kind in ("chunks", "fine")]


def measure(name: str, out: Path, threads: int | None) -> None:
    """Simulate a case up to its moment; leave its numbers and its picture in `out`.

    The least fragment has the mass of LEAST particles of the coarsest run at every resolution.
    """
    chosen = case(name)
    scene = load(chosen.scene, chosen.changes)
    sim = Simulation(scene, threads=threads)
    sim.advance(chosen.moment)
    s = sim.state
    limits = Limits(least=round(LEAST * chosen.finer**3))
    found = find(s.x, s.v, s.J_P, s.m, s.V0, scene.numerics.spacing, limits)
    results = {
        **summary(found),
        "dx": scene.numerics.dx,
        "count": int(s.count),
        "steps": sim.steps,
        "classes": size_classes(found).tolist(),
        "mass": (found.mass / found.mass.sum()).tolist(),
    }
    (out / f"{name}.json").write_text(json.dumps(results) + "\n")
    painter = Preview(scene, 960, 640, threads or 0)
    view = Shot(scene.camera).at(chosen.moment)
    image = painter.draw(np.array(s.x), sim.solids(), J_P=np.array(s.J_P), view=view)
    Image.fromarray(image).save(out / f"{name}.png")
    print(name, {key: value for key, value in results.items() if key not in ("mass", "classes")}, flush=True)


def show(out: Path, images: Path) -> None:
    """Draw the plot, write the pictures as JPEG, print the table in Markdown."""
    results = {
        name: json.loads(path.read_text()) for name in NAMES if (path := out / f"{name}.json").exists()
    }
    whole = {name: t for name, t in results.items() if name.count("_") == 1}  # those of seed 0
    for name in whole:
        with Image.open(out / f"{name}.png") as image:
            small = image.resize((720, 480), Image.Resampling.LANCZOS)
            small.save(images / f"chunks_{name}.jpg", quality=82, optimize=True)
    plot(whole, images / "chunks.png")
    print("| case | dx [m] | particles | fragments | decades | largest | largest five | powder |")
    print("|---|---|---|---|---|---|---|---|")
    for name, t in whole.items():
        shares = " | ".join(f"{t[key]:.1%}" for key in ("largest", "five", "powder"))
        size = f"{t['dx']:.3g} | {t['count']:,}"
        print(f"| `{name}` | {size} | {t['fragments']} | {t['decades']:.1f} | {shares} |")
    print("| case | decades | 32 to 100 % | 10 to 32 | 3.2 to 10 | 1 to 3.2 | 0.3 to 1 | powder |")
    print("|---|---|---|---|---|---|---|---|")
    for name, t in results.items():
        if name.startswith("throw"):
            shares = " | ".join(f"{share:.1%}" for share in (*t["classes"][:5], t["powder"]))
            print(f"| `{name}` | {t['decades']:.1f} | {shares} |")


def plot(results: dict[str, Any], path: Path) -> None:
    """Plot how many fragments are heavier than a share of the snow, one panel a scene."""
    import matplotlib as mpl

    mpl.use("Agg")
    import matplotlib.pyplot as plt

    figure, panels = plt.subplots(
        1, len(SCENES), figsize=(5 * len(SCENES), 4), sharey=True, layout="constrained"
    )
    for panel, short in zip(panels, SCENES, strict=True):
        for name, t in results.items():
            scene, kind = name.split("_")
            if scene != short or not t["fragments"]:
                continue
            mass = np.array(t["mass"][1:])
            style = "-" if kind in FINER else "--"
            label = f"{kind}: dx {t['dx']:.3g} m" if kind in FINER else kind
            panel.step(mass, np.arange(1, len(mass) + 1), style, where="pre", label=label)
        panel.set(
            xscale="log", yscale="log", xlabel="share m of the whole mass", title=Path(SCENES[short][0]).stem
        )
        panel.set_xlim(2e-4, 1.2)
        panel.grid(alpha=0.3)
        panel.legend(fontsize=8)
    panels[0].set_ylabel("fragments of mass m or more")
    figure.savefig(path, dpi=110)


def main() -> None:
    """Read the command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("what", choices=["run", "show"])
    parser.add_argument("cases", nargs="*", metavar="CASE", help=", ".join(NAMES))
    parser.add_argument("--out", type=Path, default=Path("runs/chunks"))
    parser.add_argument("--images", type=Path, default=Path("docs/images"))
    parser.add_argument("--threads", type=int)
    options = parser.parse_args()
    options.out.mkdir(parents=True, exist_ok=True)
    if options.what == "show":
        show(options.out, options.images)
        return
    for name in options.cases or NAMES:
        measure(name, options.out, options.threads)


if __name__ == "__main__":
    main()
