"""Train the network of a law and write its weights: `python -m neve.learned.train LAW [FILE]`.

The weights that come with Neve are made so, on one thread in minutes: same seed, same samples. Beside them
the file holds the seed, the ranges of constants, the loss after each iteration, and the errors on samples
never shown.
"""

from __future__ import annotations

import json
import sys
from dataclasses import asdict, fields, replace
from pathlib import Path

import numpy as np

from neve.learned.fit import errors, fit
from neve.learned.network import Network, first
from neve.learned.shipped import weights_file
from neve.learned.targets import TARGETS, samples
from neve.system import disk

ITERATIONS, SEED, FRESH = 100, 1, 1001
"""Of the weights that come with Neve; FRESH is the seed of the samples that errors are measured on."""


def train(
    law: str, count: int | None = None, iterations: int = ITERATIONS, seed: int = SEED
) -> tuple[Network, list[float]]:
    """Return the network of a law of `TARGETS`, and its loss after each iteration [1]."""
    target = TARGETS[law]
    shown = samples(target, count or target.samples, seed)
    used = (shown.y != 0).any(0)  # what is never told has no weight
    start = first(np.random.default_rng(seed), target.steps, target.hidden, int(used.sum()), target.reach)
    net, curve = fit(start, replace(shown, y=shown.y[:, used]), iterations)
    V = np.zeros((target.hidden, used.size))
    V[:, used] = net.V
    return replace(net, V=V), curve


def record(law: str, net: Network, curve: list[float]) -> dict[str, object]:
    """Return what the file of weights holds."""
    target = TARGETS[law]
    return {
        "law": law,
        "seed": SEED,
        "samples": target.samples,
        "reach": target.reach,
        "ranges": {name: list(ends) for name, ends in target.ranges.items()},
        "errors": asdict(errors(net, samples(target, target.samples, FRESH))),
        "curve": [float(f"{loss:.6g}") for loss in curve],
        "weights": {f.name: [float(x) for x in getattr(net, f.name).ravel()] for f in fields(net)},
    }


def main(law: str, path: Path) -> None:
    """Train and write."""
    net, curve = train(law)
    with disk.replacing(path) as file:
        file.write((json.dumps(record(law, net, curve), indent=1) + "\n").encode())


if __name__ == "__main__":
    if len(sys.argv) not in (2, 3) or sys.argv[1] not in TARGETS:
        sys.exit(f"Usage: python -m neve.learned.train {'|'.join(TARGETS)} [FILE]")
    main(sys.argv[1], Path(sys.argv[2]) if len(sys.argv) == 3 else weights_file(sys.argv[1]))
