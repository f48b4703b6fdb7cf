"""A stand-in for the simulation and for drawing: particles thrown in the air, in a few lines of NumPy.

It has the attributes that the run loop relies on, reorders its particles in each frame as the core may, and
gives the same bits whether it was stopped and restored or not. As a script it is Neve's command line with
this simulation inside.
"""

from __future__ import annotations

import os
import shutil
import sys
import time
import types
from pathlib import Path
from types import SimpleNamespace

import numpy as np

from neve.mpm.solver import MpmSolver

PAUSE = float(os.environ.get("NEVE_FAKE_PAUSE", "0"))  # seconds of wall time a frame takes


class Simulation:
    """Throw `count` particles."""

    count = 50
    bytes = 50
    solver = SimpleNamespace(
        log_columns=MpmSolver.log_columns, log_values=lambda totals: MpmSolver.log_values(MpmSolver, totals)
    )

    def __init__(self, scene, threads=None):
        self.scene, self.threads = scene, threads
        rng = np.random.default_rng(scene.numerics.seed)
        n = self.count
        self.time, self.steps, self.radius = 0.0, 0, scene.numerics.spacing / 2
        self.state = SimpleNamespace(
            x=rng.random((n, 3), np.float32),
            v=rng.standard_normal((n, 3), np.float32),
            J_P=np.ones(n, np.float32),
            id=np.arange(n, dtype=np.uint32),
            material=np.zeros(n, np.uint16),
            m=np.full(n, 0.4, np.float32),
            V0=np.full(n, 0.001, np.float32),
            count=n,
        )
        self.blocks = 7
        self.stats = SimpleNamespace(
            dt_min=float("nan"),
            dt_mean=float("nan"),
            bound="",
            rejected=0,
            steps=0,
            stage_seconds=dict.fromkeys(MpmSolver.stages, 0.0),
        )

    def columns(self):
        return {name: lambda name=name: getattr(self.state, name) for name in vars(self.state)}

    @classmethod
    def restore(cls, scene, arrays, threads=None):
        sim = cls(scene, threads)
        sim.time, sim.steps = arrays["time"], arrays["steps"]
        for name in ("x", "v", "J_P", "id", "material", "m", "V0"):
            setattr(sim.state, name, arrays[name].copy())
        return sim

    def arrays(self):
        names = ("x", "v", "J_P", "id", "material", "m", "V0")
        return {"time": self.time, "steps": self.steps, **{n: getattr(self.state, n).copy() for n in names}}

    def advance(self, seconds, enough=None):
        time.sleep(PAUSE)
        s, dt = self.state, np.float32(seconds / 4)
        for _ in range(4):
            s.v[:, 2] -= np.float32(9.81) * dt
            s.x += dt * s.v
            s.v *= np.where(s.x[:, 2:] < 0, np.float32(0.5), np.float32(1))
            s.J_P *= np.float32(1) - dt * np.abs(s.x[:, 0])
        order = np.random.default_rng(self.steps).permutation(s.count)
        for name in ("x", "v", "J_P", "id", "material", "m", "V0"):
            setattr(s, name, getattr(s, name)[order])
        self.time += seconds
        self.steps += 4
        self.stats = SimpleNamespace(
            dt_min=seconds / 4,
            dt_mean=seconds / 4,
            bound="speed",
            rejected=0,
            steps=4,
            exchanged=np.full((len(self.scene.colliders), 7), self.time),
            stage_seconds=dict.fromkeys(MpmSolver.stages, 0.1),
        )
        if enough is not None:
            enough()

    def solids(self):
        at = SimpleNamespace(
            position=np.full(3, self.time), rotation=np.eye(3), velocity=np.ones(3), omega=np.zeros(3)
        )
        names = [f"colliders.{i}" for i, _ in enumerate(self.scene.colliders)]
        return [(SimpleNamespace(name=name), at) for name in names]

    def diagnostics(self):
        s = self.state
        m, v = s.m.astype(float), s.v.astype(float)
        return SimpleNamespace(
            mass=m.sum(),
            momentum=(m[:, None] * v).sum(0),
            kinetic=0.5 * (m * (v**2).sum(1)).sum(),
            elastic=0.0,
            affine=0.0,
            work=0.0,
            potential=9.81 * (m * s.x[:, 2]).sum(),
            particles=s.count,
            asleep=0,
            blocks=self.blocks,
            bodies_momentum=(0.0, 0.0, 0.0),
            bodies_kinetic=0.0,
            bodies_potential=0.0,
        )


class Preview:
    """Draw particles as single white dots, whatever the camera, and its view as a few bytes."""

    def __init__(self, scene, width=1280, height=720, threads=0, radius=None):
        self.size = width, height

    def draw(self, x, bodies, J_P=None, view=None, water=None, time=0.0):
        width, height = self.size
        image = np.zeros((height, width, 3), np.uint8)
        spot = (np.abs(x[:, [2, 0]]) * 50).astype(int) % (height, width)
        image[spot[:, 0], spot[:, 1]] = 255
        seen = np.frombuffer(np.array([*view.position, *view.target]).tobytes(), np.uint8)
        image.ravel()[: len(seen)] = seen  # another view is another picture
        return image


class Film:
    """Keep the mean of each image, one line each; parts of an unfinished film as files in a hidden folder."""

    def __init__(self, path, fps, size, start=0):
        self.path, self.parts = Path(path), Path(path).with_name(f".{Path(path).name}.parts")
        self.rate = fps
        self.frames = {}
        if start == 0:
            shutil.rmtree(self.parts, ignore_errors=True)
        for part in self.parts.glob("*.part"):
            if int(part.stem) < start:
                self.frames[int(part.stem)] = part.read_text()
        self.missing = sorted(set(range(start)) - self.frames.keys())

    def add(self, image, index=None):
        assert index not in self.frames
        self.frames[index] = repr(float(image.mean()))

    def close(self, keep=False):
        assert sorted(self.frames) == list(range(len(self.frames)))
        self.path.write_text("\n".join(self.frames[index] for index in sorted(self.frames)))
        if not keep:
            shutil.rmtree(self.parts, ignore_errors=True)
            return
        self.parts.mkdir(exist_ok=True)
        for index, text in self.frames.items():
            (self.parts / f"{index}.part").write_text(text)


def install(put=sys.modules.__setitem__):
    """Put the stand-ins where the run loop imports the real ones."""
    for name, content in {
        "neve.simulation": {"Simulation": Simulation},
        "neve.render.preview": {"Preview": Preview},
        "neve.render.film": {"Film": Film},
    }.items():
        module = types.ModuleType(name)
        vars(module).update(content)
        put(name, module)


if __name__ == "__main__":
    install()
    from neve.cli import main

    main()
