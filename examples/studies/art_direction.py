"""Draw what docs/art_direction.md shows: each look of snow on two grids, docs/images/want_NAME.jpg.

    python examples/studies/art_direction.py [NAME]... [--out DIR] [--images DIR] [--threads N]

Needs `pip install mitsuba mitsuba-oidn`. What an earlier call has simulated and drawn is kept.
"""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import NamedTuple

from PIL import Image

from neve.cli import main as neve

GRIDS = (0.06, 0.045)
"""The two values of numerics.dx [m]."""
SIZE = (480, 270)
"""Of one picture [px]."""
PLAIN = 'sources.0.structure="plain"'


class Look(NamedTuple):
    """A preset, what is changed of it, the frame that is shown, and another camera for it."""

    preset: str
    changes: tuple[str, ...]
    frame: int
    camera: tuple[str, ...] = ()


LOOKS = {
    "chunks": Look("throw_ball", (), 22),
    "crumbs": Look(
        "throw_ball",
        (
            PLAIN,
            "snow.beta=0.1",
            'sources.0.variation={pattern="clods",feature_size=0.15,seam=0.05,strength=2.5}',
        ),
        22,
    ),
    "powder": Look("throw_ball", (PLAIN, 'snow={kind="powder"}'), 22, ("camera.fov=55",)),
    "wet": Look("snowball_wall", ('snow={kind="wet"}',), 20),
    "crust": Look(
        "throw_ball",
        (
            PLAIN,
            "snow.p0=2e4",
            "sources.0.profile={at=[0.12,0.18],strength=[8,1],stiffness=[1,0.3]}",
        ),
        22,
    ),
    "dust": Look("snowball_wall", (PLAIN, 'snow={kind="powder"}'), 13),
}


def typed(*words: str) -> None:
    """Do what a command line does. Errors: SystemExit, of any exit code but 0."""
    try:
        neve(words)
    except SystemExit as end:
        if end.code:
            raise


def picture(name: str, dx: float, out: Path, threads: str) -> Path:
    """Simulate and draw a look on one grid, unless that is done, and return the picture's place."""
    look, run = LOOKS[name], out / f"{name}_{dx:g}"
    changes = [word for change in look.changes for word in ("--set", change)]
    camera = [word for change in look.camera for word in ("--set", change)]
    if not (run / "frames" / f"{look.frame:06d}.npz").exists():
        grid = ["--set", f"numerics.dx={dx:g}", "--set", "run.film=false"]
        last = ["--frames", str(look.frame), "--out", str(run), "--force", "--threads", threads, "--quiet"]
        typed("run", look.preset, *grid, *changes, *last)
    sized = ["--quality", "draft", "--size", f"{SIZE[0]}x{SIZE[1]}", "--threads", threads, "--quiet"]
    typed("render", str(run), "--frame", str(look.frame), *sized, *camera)
    return run / "render" / f"{look.frame:06d}.png"


def sheet(pictures: list[Path], to: Path) -> None:
    """Put the pictures side by side."""
    wide, high = SIZE
    both = Image.new("RGB", (wide * len(pictures), high))
    for i, path in enumerate(pictures):
        with Image.open(path) as image:
            both.paste(image.convert("RGB"), (i * wide, 0))
    both.save(to, quality=88)


def main() -> None:
    """Draw the looks that are named, or all."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("names", nargs="*", default=list(LOOKS), metavar="NAME", help=", ".join(LOOKS))
    parser.add_argument("--out", type=Path, default=Path("runs/art_direction"))
    parser.add_argument("--images", type=Path, default=Path("docs/images"))
    parser.add_argument("--threads", default="2")
    asked = parser.parse_args()
    for name in asked.names:
        if name not in LOOKS:
            parser.error(f"there is no look {name}; there are {', '.join(LOOKS)}")
        pictures = [picture(name, dx, asked.out, asked.threads) for dx in GRIDS]
        sheet(pictures, asked.images / f"want_{name}.jpg")
        print(f"{name}: {asked.images / f'want_{name}.jpg'}")


if __name__ == "__main__":
    main()
