"""What a scene may choose by a word, where users can register more: methods and devices."""

from __future__ import annotations

from importlib import import_module
from typing import Any


class Registry:
    """Map the words of a key of a scene to classes.

    key: of the scene, such as "numerics.method". entries: a class for each word, or where it stands as
    "module:Class", so that it is imported only when it is chosen. meanings: of the words, for the pages of
    the scene format.
    """

    def __init__(self, key: str, entries: dict[str, Any], meanings: dict[str, str]) -> None:
        self.key = key
        self.entries = entries
        self.meanings = meanings

    def names(self) -> tuple[str, ...]:
        """Return the words that may be chosen."""
        return tuple(self.entries)

    def meaning(self) -> str:
        """Return what the words mean, as `"word": meaning; ...`."""
        return "; ".join(f'"{word}": {meaning}' for word, meaning in self.meanings.items())

    def checked(self, name: str) -> str:
        """Return `name` if it may be chosen. Errors: ValueError that says what is allowed."""
        if name not in self.entries:
            raise ValueError(f'{self.key} = "{name}" is not allowed: use one of {", ".join(self.entries)}')
        return name

    def get(self, name: str) -> Any:
        """Return the class that `name` stands for. Errors: ValueError that says what is allowed."""
        self.checked(name)
        found = self.entries[name]
        if isinstance(found, str):
            module, _, member = found.partition(":")
            found = getattr(import_module(module), member)
        return found


METHODS = Registry(
    "numerics.method",
    {
        "mpm": "neve.mpm.solver:MpmSolver",
        "particles": "neve.particles.solver:ParticleSolver",
        "sph": "neve.sph.solver:SphSolver",
    },
    {
        "mpm": "the material point method",
        "particles": "particles in contact",
        "sph": "smoothed particles with implicit pressure and shear",
    },
)
"""The solvers: subclasses of `neve.solver.Solver`."""

DEVICES = Registry(
    "numerics.device",
    {"cpu": "neve.backend:Cpu", "cuda": "neve.cuda.backend:Cuda", "auto": "neve.cuda.backend:Auto"},
    {
        "cpu": "the processor",
        "cuda": "a GPU of NVIDIA (not yet run on one: docs/cuda.md)",
        "auto": "the GPU if there is one that can be used, else the processor",
    },
)
"""Where a solver's stages run: classes with the methods of `neve.backend.Backend`."""

FIRST = (0,)
"""The number of the first device of its kind."""
