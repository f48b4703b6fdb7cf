"""Turn a Scene into a Model and a State: the only module that turns scene values into MPM's arrays."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from neve.build import coupled, material_table, samples_of
from neve.flow.births import Births
from neve.heat.clock import heat_model
from neve.heat.enthalpy import enthalpy_at
from neve.mpm.model import Model
from neve.sampling import Samples
from neve.sampling.fineness import particles_of
from neve.sampling.room import require_room_for_all
from neve.scene.errors import SceneError
from neve.scene.schema.scene import Scene

if TYPE_CHECKING:
    from neve._core import State


FAR = 1000
"""Cells from the origin beyond which positions are kept to more than float32."""


def build(scene: Scene) -> tuple[Model, State, Births]:
    """Sample the sources and assemble the material table; the third value says whose a particle is.

    Each particle has rest volume V0, its share of its source's volume, factors on stiffness and strength, and
    mass m = rho0 f V0 with its factor f on density; F_E = I and J_P = 1; with an affine transfer the
    affine velocity C is that of the source's spin; further modes of the velocity are zero.
    `numerics.initial_volume = "grid"` replaces V0 in the first step. Snow that would start inside a solid is
    left out, and a SceneWarning says so, as one does of sources that fill the same space.

    Errors: SceneError for a source, a mesh or a height map that cannot be used.
    """
    model = make_model(scene)
    if scene.emitters and not scene.sinks:
        require_room_for_all(particles_of(scene), scene.numerics)
    state, sizes = snow_of(scene, model, range(len(scene.sources)))
    return model, state, Births.of_sources(sizes)


def snow_of(scene: Scene, model: Model, indices: Sequence[int]) -> tuple[State, list[int]]:
    """Return the particles of the sources of these indices, without those inside a solid of `model`.

    The second value is how many each source has.

    Errors: SceneError for a source that cannot be used, or that starts wholly inside solids, and for more
    particles than there is memory for.
    """
    sources = [scene.sources[i] for i in indices]
    samples = samples_of(scene, model, indices)
    count = sum(len(s.x) for s in samples)
    state = model.particles(count)
    rows_of = {snow: row for row, snow in enumerate(model.snows)}
    begin = 0
    for source, s in zip(sources, samples, strict=True):
        snow = scene.snow_of(source)
        rows = slice(begin, begin + len(s.x))
        _place(state, rows, s, rows_of[snow], snow.rho0)
        if model.native.keeps_C:
            state.C[rows] = _spin_matrix(source.spin)
        if model.has_heat:
            state.enthalpy[rows, 0] = enthalpy_at(scene, state.m[rows], s)
            if s.growth is not None:
                state.thermal[rows, 1] = s.growth
        begin = rows.stop
    return state, [len(s.x) for s in samples]


def make_model(scene: Scene) -> Model:
    """Return the constants of the scene's run, without sampling any snow.

    Errors: SceneError for emitters, sinks or heat where the device has none.
    """
    if (scene.is_open or scene.heat is not None) and scene.numerics.device != "cpu":
        scene = _on_the_processor(scene)
    solids, rigid = coupled(scene)
    snows, heat = material_table(scene), heat_model(scene)
    return Model(scene.world, scene.numerics, snows, scene.colliders, solids, rigid, heat, lies_far(scene))


def lies_far(scene: Scene) -> bool:
    """Tell whether positions of a float32 would be coarse where snow starts: from FAR cells on.

    Such a number is rounded by up to 2^-24 of itself: there to 6e-5 dx.
    """
    if scene.numerics.precision != "float32" or scene.numerics.device != "cpu":
        return False
    far = FAR * scene.numerics.dx
    places = [(*snow.place, *snow.half_extents()) for snow in (*scene.sources, *scene.emitters)]
    return any(abs(number) > far for place in places for number in place)


def _on_the_processor(scene: Scene) -> Scene:
    """Return a scene in which snow comes, goes or has heat for the processor, if its device may be that."""
    if scene.numerics.device == "auto":
        return scene.model_copy(update={"numerics": scene.numerics.model_copy(update={"device": "cpu"})})
    name = "emitters" if scene.emitters else "sinks" if scene.sinks else "heat"
    lacks = "knows no heat" if name == "heat" else "adds and removes no snow"
    raise SceneError(f'{name}: numerics.device = "{scene.numerics.device}" {lacks}; use "cpu"')


def _place(state: State, rows: slice, s: Samples, material: int, rho0: float) -> None:
    state.x[rows] = s.x
    if state.beyond.shape[1]:
        state.beyond[rows] = s.x - state.x[rows]
    state.v[rows] = s.v
    state.m[rows] = rho0 * s.density * s.volume
    state.V0[rows] = s.volume
    state.stiffness[rows] = s.stiffness
    state.strength[rows] = s.strength if s.growth is None or state.thermal.shape[1] else s.strength * s.growth
    if s.J_P is not None:
        state.J_P[rows] = s.J_P
    state.material[rows] = np.uint16(material)


def _spin_matrix(spin: tuple[float, float, float]) -> list[list[float]]:
    """Return grad v of v = spin x (x - centre): with it, the first step sees no false strain."""
    a, b, c = spin
    return [[0.0, -c, b], [c, 0.0, -a], [-b, a, 0.0]]
