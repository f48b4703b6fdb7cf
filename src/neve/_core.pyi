"""Types of the compiled core; `f32` and `f64` are the same interface in two precisions.

This is the contract of a device (see neve.backend). Units are SI, positions and vectors in world axes, arrays
in C order; n is the number of particles, or of points where a function takes points. "real" is float32 in
`f32` and float64 in `f64`.

Arrays go in as NumPy arrays. What a call reads may be of other numbers and in another order: it is converted,
and copied where the object keeps it, so that later changes do not show. What comes out is a new array, but
for the arrays of State, which are views. A shape other than the one named here is a TypeError where nothing
else is said.
"""

from collections.abc import Callable, Mapping, Sequence
from typing import Any, Literal, Protocol

import numpy as np
from numpy.typing import NDArray

Reals = NDArray[np.floating[Any]]
Array64 = NDArray[np.float64]

class Report:
    """What a pass over the particles found in the state that it leaves, or, a trial, would leave."""

    wave: float
    """Largest elastic wave speed c = sqrt(modulus V0 / m), hardened [m/s]."""
    speed: float
    """Largest particle speed |v| [m/s]."""
    fastest: float
    """Largest c + |v| of one particle [m/s]."""
    strain_rate: float
    """Largest |grad v|, Frobenius, of this step [1/s]; of `refresh`, from what the particles carry."""
    compression_rate: float
    """Largest -tr grad v of this step [1/s]."""
    max_displacement: float
    """Longest way of a particle in this step [cells]."""
    min_volume_ratio: float
    """Smallest det(I + dt grad v) of this step [1]."""
    ice_room: float
    """Smallest J over that at which snow that flows is ice [1]."""
    finite: bool
    """Every particle has finite x, v, F_E, J_P and stress."""
    drifted: bool
    """Some particle left the reach of its block: `sort` before the next `p2g`."""
    offending_id: int
    """Lowest id among the particles that make the step unacceptable; 2^32 - 1 if there is none."""
    rejected: bool
    """Not finite, or beyond `displacement_limit` or `volume_ratio_limit`."""
    def merge(self, other: Report) -> None:
        """Take in what another pass found: the larger of each rate, and whatever is wrong."""

class StepLimits:
    """What the scene and its snow allow a step (see neve.mpm.time_step)."""

    def __init__(
        self,
        *,
        dx: float,
        cfl: float,
        courant: float,
        strain_max: float,
        dt_max: float,
        dt: float,
        max_compression: float,
        solid_speed: float,
    ) -> None:
        """dx [m]; cfl, courant, strain_max, max_compression [1]; dt_max [s]; dt: the user's own [s], or 0
        for the longest good one; solid_speed [m/s].
        """
    dx: float
    """Grid spacing [m]."""
    cfl: float
    """Largest (c + |v|) dt / dx [1]."""
    courant: float
    """Largest stable c dt / dx [1]."""
    strain_max: float
    """Largest dt |grad v| [1]."""
    dt_max: float
    """Largest automatic step [s]."""
    dt: float
    """The user's own [s]; 0: the longest good one."""
    max_compression: float
    """Largest -dt tr grad v [1]."""
    solid_speed: float
    """Largest speed of a solid's surface [m/s]."""
    largest_strain: float
    """dt |grad v| beyond which a step is rejected [1]."""

class ParticleRates:
    """What a step follows from, as in `Report`."""

    def __init__(
        self,
        wave: float,
        speed: float,
        fastest: float,
        strain_rate: float,
        compression_rate: float,
        ice_room: float,
    ) -> None:
        """See `Report`: speeds [m/s], rates [1/s], room [1]."""

shortest_share: float
"""A step that is a smaller share of the time that remains makes no progress [1]."""
step_bounds: list[str]
"""What may bound a step, by the numbers of the enum."""

def stable_step(limits: StepLimits, rates: ParticleRates) -> float:
    """Return the longest step in which no vibration of the snow grows [s]."""

def longest_stable(limits: StepLimits, rates: ParticleRates) -> tuple[float, str]:
    """Return the automatic step [s], and what bound it."""

def largest_step(limits: StepLimits, rates: ParticleRates) -> tuple[float, str]:
    """Return the step that the scene allows [s], and what bound it."""

def fitted(dt: float, remaining: float) -> float:
    """Return the step that divides `remaining` [s] evenly and does not exceed dt [s]."""

def needs_trial(
    limits: StepLimits,
    speed: float,
    difference: float,
    change: float,
    finite: bool,
    before: ParticleRates,
    dt: float,
) -> bool:
    """Tell whether a step of dt [s] must be tried first.

    speed, difference, change [m/s], finite: of a `GridReport`; before: of the last step
    """

class GridReport:
    """What grid_update found in the nodes, but those lighter than a thousandth of the lightest particle."""

    speed: float
    """Largest node speed [m/s]."""
    max_velocity_difference: float
    """Largest difference of velocities of nodes around one block [m/s]."""
    max_velocity_change: float
    """Largest change of a node's velocity in the step [m/s]; 0 with transfers that do not keep it."""
    finite: bool
    """Every node has a finite velocity."""

class Totals:
    """Sums over the particles, in double precision and in a fixed order."""

    mass: float
    """[kg]"""
    momentum: list[float]
    """Sum of m v, (3,) [kg m/s]."""
    kinetic: float
    """Sum of m |v|^2 / 2 [J]."""
    affine: float
    """Kinetic energy of the velocity field around each particle [J]; 0 with transfers that have none."""
    elastic: float
    """Sum of V0 psi(F_E) [J]."""
    potential: float
    """Sum of -m g . x [J]."""
    heat: float
    """Enthalpy above that of ice at the melting point [J]; 0 without heat."""
    water: float
    """Mass that is liquid [kg]."""

class TriangleMesh:
    """Triangles in their own frame, in a tree of boxes; closed or not, and not to be changed.

    Faces without area do not count. If the volume that the faces enclose is negative, all of them are turned.
    """

    def __init__(self, vertices: Array64, faces: NDArray[np.int32]) -> None:
        """Copy vertices (n, 3) [m] and faces (m, 3), rows of vertices.

        Errors: ValueError for a vertex that is not finite or not there, or no face with an area.
        """
    @property
    def triangles(self) -> int:
        """Number of faces that have an area."""
    @property
    def skipped(self) -> int:
        """Number of faces without area."""
    @property
    def closed(self) -> bool:
        """Whether every edge is passed as often one way as the other; vertices at one place are one."""
    @property
    def inverted(self) -> bool:
        """Whether the faces looked inwards and were turned."""
    @property
    def area(self) -> float:
        """Area of all triangles [m2]."""
    @property
    def volume(self) -> float:
        """Enclosed volume [m3], never below 0; of an open mesh a guess."""
    @property
    def low(self) -> Array64:
        """Lower corner of the bounds of the triangles, (3,) [m]; a copy."""
    @property
    def high(self) -> Array64:
        """Upper corner of the bounds of the triangles, (3,) [m]; a copy."""
    def distance(self, points: Array64) -> Array64:
        """Return the distances (n,) [m] from points (n, 3) [m] to the nearest triangle, never below 0."""
    def closest(self, points: Array64) -> tuple[Array64, Array64, NDArray[np.int32]]:
        """Return of points (n, 3) [m] what is nearest on the surface.

        Its place (n, 3) [m], its distance (n,) [m] and its row in the faces given (n,).
        """
    def winding(self, points: Array64, exact: bool = False) -> Array64:
        """Return how often the surface winds around points (n, 3) [m]: (n,) [1], 1 inside, 0 outside.

        Where the mesh is open it is between. exact: add up all triangles one by one; otherwise far ones count
        together, within 0.03.
        """
    def signed_distance(self, points: Array64) -> Array64:
        """Return the distances (n,) [m] of points (n, 3) [m], below 0 where |winding| is above 0.5."""
    def ray(self, origins: Array64, directions: Array64) -> tuple[Array64, NDArray[np.int32]]:
        """Return where rays first meet the surface, from either side.

        origins (n, 3) [m], directions (n, 3) of any length. First the way (n,) in lengths of the direction,
        above 0, or inf; then the row in the faces given (n,), or -1.
        Errors: ValueError unless there is one direction per origin.
        """

class SdfGrid:
    """Signed distance to a mesh and its normal, sampled in the frame of the mesh; not to be changed.

    Bricks of 8^3 cells hold samples wherever the surface is within the band; elsewhere those at the
    corners of bricks serve.
    """

    @staticmethod
    def build(mesh: TriangleMesh, spacing: float, band: float, thickness: float = 0.0) -> SdfGrid:
        """Sample the signed distance of `mesh`, which need not live on.

        spacing: of the samples [m]; band: where |distance| is no more, samples have that spacing [m];
        thickness [m]: above 0, the distance is that to a sheet of this thickness, and no more to a body.
        Errors: ValueError for a spacing that is not above 0, a band or thickness below 0, or 2^27 bricks and
        more.
        """
    @staticmethod
    def bytes_for(mesh: TriangleMesh, spacing: float, band: float, thickness: float = 0.0) -> int:
        """Return the memory that `build` of the same would take [bytes], sooner. Errors: those of `build`."""
    @staticmethod
    def from_arrays(arrays: dict[str, NDArray[Any]]) -> SdfGrid:
        """Make the grid that `arrays()` came from, with copies of them.

        Errors: ValueError for an array that is missing or of another type or shape, for
        arrays that do not fit each other, a brick that is not there, or a spacing that is not above 0.
        """
    def arrays(self) -> dict[str, NDArray[Any]]:
        """Return copies of all that the grid is, for a grid of (a, b, c) bricks, k of them with samples.

        table (a, b, c) int32: row of `fine`, or -1; coarse (a + 1, b + 1, c + 1, 4) float32 at the corners of
        bricks and fine (k, 9, 9, 9, 4) float32: distance [m] and normal [1]; sizes (13,) float64: first
        corner of the grid, `low`, `high`, `spacing`, `band`, `thickness` [m], `openness` [1].
        """
    def sample(self, points: Array64) -> tuple[Array64, Array64]:
        """Return signed distances (n,) [m], below 0 inside, and unit normals (n, 3) at points (n, 3) [m].

        Trilinear between samples. Beyond the grid: the distance to a point of the surface, not always the
        nearest.
        """
    @property
    def bytes(self) -> int:
        """Memory [bytes]."""
    @property
    def spacing(self) -> float:
        """Spacing of the samples in bricks [m]."""
    @property
    def band(self) -> float:
        """Largest |distance| around which there are surely bricks [m]."""
    @property
    def thickness(self) -> float:
        """Thickness of the sheet that the surface was taken for [m]; 0: it is the boundary of a body."""
    @property
    def openness(self) -> float:
        """Share of samples near the surface that are neither in nor out [1]; 0 for a closed mesh.

        Of those between a spacing and the band (or three spacings) off it, the ones whose winding number is
        more than 0.25 from a whole number.
        """
    @property
    def low(self) -> Array64:
        """Lower corner of the bounds of the solid, half a thickness beyond the mesh, (3,) [m]; a copy."""
    @property
    def high(self) -> Array64:
        """Upper corner of the same bounds, (3,) [m]; a copy."""

class HeightField:
    """Ground in its own frame, z up; the middle of its rectangle is x = y = 0. Not to be changed.

    Bilinear between the heights. Beyond an edge the edge's height goes on for ever; below all is ground.
    """

    def __init__(self, heights: NDArray[np.float32], size: Array64 | tuple[float, float]) -> None:
        """Copy heights (nx, ny) [m], rows along x.

        The outer ones lie on the edges. size: of the rectangle along x and y, (2,) [m].
        Errors: ValueError for fewer than 2 or more than 2^20 samples a side, a size that is not above 0, or a
        height that is not finite.
        """
    def sample(self, points: Array64) -> tuple[Array64, Array64]:
        """Return signed distances (n,) [m], below 0 in the ground, and normals (n, 3) at points (n, 3) [m].

        The distance is (z - h) n_z, that to the tangent plane: exact for planes.
        """
    @property
    def heights(self) -> NDArray[np.float32]:
        """Heights as given, (nx, ny) [m]; a copy."""
    @property
    def size(self) -> tuple[float, float]:
        """Size of the rectangle along x and y [m]."""
    @property
    def low(self) -> float:
        """Least height [m]."""
    @property
    def high(self) -> float:
        """Largest height [m]."""
    @property
    def bytes(self) -> int:
        """Memory [bytes]."""

_TriangleMesh = TriangleMesh
_SdfGrid = SdfGrid
_HeightField = HeightField

class Geometry(Protocol):
    """What is known of shapes: bodies of triangles, their signed distance, ground from heights."""

    TriangleMesh: type[_TriangleMesh]
    """Triangles."""
    SdfGrid: type[_SdfGrid]
    """Sampled signed distance."""
    HeightField: type[_HeightField]
    """Ground from heights."""
    @staticmethod
    def shapes() -> tuple[str, ...]:
        """Return the words of all shapes, those with a formula before those with samples."""

class Columns:
    """What snow can lie on: n places, surfaces below open space over the middles of cells.

    Slopes of more than 75 degrees count as 75.
    """

    def __init__(
        self,
        low: tuple[float, float],
        cell: float,
        cells: tuple[int, int],
        vertices: Array64,
        faces: NDArray[np.int32],
        part: NDArray[np.int32],
        kinds: list[str],
    ) -> None:
        """Look down on vertices (n, 3) [m] and faces (m, 3) from the sky.

        low: corner of the raster [m]; cell: edge of its cells [m]; part: of each face, a row of kinds (m,);
        kinds: "closed", "sheet" or "ground". Errors: ValueError for rows that are not there.
        """
    def __len__(self) -> int:
        """Return how many places there are."""
    def column(self) -> NDArray[np.int32]:
        """Over which cell each place is, i ny + j (n,); those of a cell from the top down."""
    def part(self) -> NDArray[np.int32]:
        """On whose surface each place is (n,)."""
    def z(self) -> Array64:
        """Height of each place (n,) [m]."""
    def ceiling(self) -> Array64:
        """Height of what hangs above each place (n,) [m]; inf under the sky."""
    def slope(self) -> Array64:
        """Of the surface, dz/dx and dz/dy (n, 2) [1]."""
    def joined(self, top: Array64) -> NDArray[np.int32]:
        """Return for each place those along +x, -x, +y, -y that are one surface with it, or -1, (n, 4).

        top: height of the snow on each place (n,) [m], no steeper than 75 degrees from one to the other.
        """
    def walls(self, top: Array64) -> NDArray[np.int8]:
        """Return what is along +x, -x, +y, -y beside the tops (n,) [m]: 0 open space, 1 a body, 2 the rim."""

_Columns = Columns

class Heat(Protocol):
    """Laws of heat that layers of lying snow share with particles (core/heat)."""

    latent: float
    """Heat of fusion [J/kg]."""
    c_ice: float
    """Specific heat of ice and snow [J/(kg K)]."""
    c_water: float
    """Specific heat of water [J/(kg K)]."""
    strength_power: float
    """Power of density with which strength grows [1]."""

    @staticmethod
    def conductivity(density: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the conductivity [W/(m K)] of snow of `density` [kg/m3], (n, k): Calonne et al. 2011."""
    @staticmethod
    def grown(
        growth: NDArray[np.float64],
        density: NDArray[np.float64],
        celsius: NDArray[np.float64],
        dt: float,
    ) -> NDArray[np.float64]:
        """Return the growth of strength [1] after dt [s] at `celsius` [deg C] of what was `growth` before.

        (n, k) each; density [kg/m3]. At most the strength of ice over that of such snow. Errors: ValueError
        for arrays of other sizes.
        """

class Snowfall(Protocol):
    """Where falling snow comes to lie, and what of it slides on."""

    Columns: type[_Columns]
    """Places that snow can lie on."""
    shortest_piece: float
    """Height of the pieces of a flake's way near the ground [m]."""
    piece_growth: float
    """Height of a piece over that above the start, where it is longer [1]."""
    @staticmethod
    def exposure(
        *,
        columns: _Columns,
        solids: list[TriangleMesh],
        top: Array64,
        slope: Array64,
        flutter: float,
        wind: tuple[float, float],
        seed: int,
        tolerance: float,
        detail: float,
        most: int,
    ) -> tuple[Array64, Array64, NDArray[np.uint32], int]:
        """Return the share of what falls on level open ground that reaches each place, per area seen from
        above (n,), its standard error (n,), the edge of the bucket that it was counted in (n,) [cells], and
        the number of flakes.

        solids: what is in a flake's way; top (n,) [m] and slope (n, 2) of the snow; flutter: sideways way
        over 1 m, rms [m]; wind: over the speed of fall [1]; tolerance: standard error of a bucket that has
        enough flakes; detail: difference of its quarters from which it is split; most: flakes of a bucket.
        """
    @staticmethod
    def slide(
        *,
        columns: _Columns,
        depth: Array64,
        repose: float,
        holding_depth: bool,
        least_slope: float,
        gravity: float,
        passes: int,
    ) -> tuple[Array64, dict[str, Any]]:
        """Return the depth (n,) [m] when nothing moves any more, and sums of depths [m].

        repose: tangent of the angle of repose; holding_depth: instead, slopes above the tangent least_slope
        hold 3178 beta^-1.998 m (beta in degrees); gravity [m/s2]; passes: at most. Sums: lost over the rim or
        into the void, moved, over_edges; passes: taken; settled: whether all rests.
        """

class ScriptedPath:
    """Where a script has a solid at any time: the same bits with every instruction set."""

    def __init__(self, starts: Array64, legs: Array64) -> None:
        """Take legs (n + 1, 27), of which leg i + 1 holds from starts[i] [s] (n,) on, and the first before.

        A leg: its beginning and its span [s], then position [m] and rotation (row by row) at the beginning,
        its way [m], the axis of its turn and the angle [rad], velocity [m/s] and angular velocity [rad/s].
        Errors: ValueError for another number of legs.
        """
    def at(self, time: float) -> tuple[Array64, Array64, Array64, Array64]:
        """Return position (3,) [m], rotation (3, 3) [1], velocity (3,) [m/s] and omega (3,) [rad/s]."""
    def place(self, time: float, position: Array64, quaternion: Array64) -> None:
        """Write the position [m] into (3,) and the rotation into (4,), w x y z with w >= 0.

        Errors: ValueError for arrays of another size.
        """

class BodyMotion:
    """Where n bodies are at the beginning of a step, and how they move in it; all arrays are copies."""

    def __init__(
        self, centres: Array64, rotations: Array64, rates: Array64, mobility: Array64, acceleration: Array64
    ) -> None:
        """Take what the properties return. Errors: ValueError for arrays that do not fit one another."""
    @property
    def centres(self) -> Array64:
        """Origins of their frames, (n, 3) [m]."""
    @property
    def rotations(self) -> Array64:
        """From their own axes to the world's, (n, 3, 3) [1]."""
    @property
    def rates(self) -> Array64:
        """Velocity of the origin [m/s] and angular velocity [1/s], (n, 6)."""
    @property
    def mobility(self) -> Array64:
        """A (6 n, 6 n) in dU = A dP: impulses [N s], moments [N m s] at the origins to changes of `rates`."""
    @property
    def acceleration(self) -> Array64:
        """Of all but the snow, (n, 6) [m/s2, 1/s2]: gravity, contacts among bodies, motors."""
    @property
    def groups(self) -> int:
        """How many groups of bodies there are that do not move one another."""

class BodyDynamics:
    """How solids on bodies of the rigid-body engine, MuJoCo, move; it reads the engine's arrays in place."""

    def __init__(
        self, model: dict[str, Any], data: dict[str, Any], bodies: NDArray[np.int32], frames: Array64
    ) -> None:
        """Take arrays of the engine's model and data by their names there (see neve.rigid.dynamics).

        bodies (n,): of the engine, that carry the solids; frames (n, 3, 4): axes and origin of each solid's
        frame, as that body has them.
        Errors: KeyError, RuntimeError or ValueError for an array that is missing, of another type or short.
        """
    def update(self, h: float, constraints: dict[str, Any] | None = None) -> None:
        """Derive `motion` after the first half of the engine's step, whose length is h [s]."""
    def apply(self, exchanged: Array64, dt: float) -> int | None:
        """Let what the solids exchanged with the snow in dt [s], (n, 7), act as a constant force and torque.

        Returns the first solid whose force is not finite; then none acts. Errors: ValueError for another n.
        """
    @property
    def motion(self) -> BodyMotion:
        """Of the solids; the same object always."""

class Model(Protocol):
    """The constants of one run, and its solids where they are."""

    dx: float
    """Grid spacing [m]."""
    more_modes: int
    """Rows of `State.modes`: velocity modes beyond v and C, and how far snow has left surfaces with play."""
    has_play: bool
    """Whether the last of them is how far snow has left surfaces with play [m]: `mode = "slip"`, friction."""
    keeps_C: bool
    """Whether particles carry an affine velocity."""
    stencil_stiffness: float
    """Largest sum over nodes of |g . a|^2 / w, with g what makes velocity gradients [1/cells^2]."""

    @property
    def device_choice(self) -> tuple[int, int, int, int, bool, bool]:
        """Places of spline and transfer, modes, a bit for each law, whether there are solids, some with play.

        As a GPU's kernels are chosen by.
        """
    @property
    def snow_count(self) -> int:
        """Number of rows of the material table."""
    @property
    def device_snows(self) -> bytes:
        """The material table."""
    def device_constants(self, dt: float) -> bytes:
        """Return the constants of a step of dt [s]: numbers of the model's precision."""
    @property
    def device_blend(self) -> tuple[float, float]:
        """Share of FLIP in a step [1], and the rate that it follows from instead [1/s], or -1."""
    @property
    def keeps_change(self) -> bool:
        """Whether the grid keeps changes of velocity."""
    @property
    def solid_count(self) -> int:
        """Number of solids."""
    def device_samples(self, index: int) -> list[bytes]:
        """Return the arrays of samples of a solid; none for shapes with a formula."""
    def device_view(self, index: int, addresses: list[int]) -> bytes:
        """Return what a solid's shape is to a device that has its samples at these addresses."""
    def device_solids(self, views: list[int]) -> bytes:
        """Return the solids where they are now, with what `device_view` returned at these addresses."""
    @property
    def body_count(self) -> int:
        """Number of bodies, which the snow moves."""
    def solve_bodies(self, dt: float, response: Callable[[Array64], Array64]) -> Array64:
        """Find the velocities of the b bodies after a step of dt [s], (b, 6), and let them move so.

        response(U): impulse and moment of the snow on bodies that move with U (b, 6), and row by row how
        fast they fall with it, (b, 42). Errors: ValueError for another number of responses.
        """
    def max_compression(self, strongest: float) -> float:
        """Return how far one step may compress any of the snows, -dt tr grad v [1]; see `Law`."""
    def set_heat(self, heat: HeatModel) -> None:
        """Let particles have heat."""
    def set_gravity(self, gravity: Array64) -> None:
        """Let everything fall with `gravity` (3,) [m/s2] from now on."""
    def set_snow(self, row: int, law: str, plasticity: str, constants: dict[str, float]) -> None:
        """Give a row of the material table other constants. Errors: ValueError without the row."""
    def add_snow(self, law: str, plasticity: str, constants: dict[str, float]) -> None:
        """Add a row to the material table, with the constants of the law by name, in their units.

        Errors: ValueError for an unknown law or plasticity, or a constant that no law has.
        """
    def add_solid(self, shape: str, half: Array64, mode: str, mu_c: float) -> None:
        """Add a solid, at rest at the origin until it is placed.

        half: half extents in its own axes, (3,) [m]; mode of contact; mu_c: friction [1]
        Errors: ValueError for an unknown shape or mode, or a shape with samples.
        """
    def add_mesh_solid(self, grid: SdfGrid, mode: str, mu_c: float, thickness: float = ...) -> None:
        """Add a solid of sampled distances, which it keeps alive; thickness: of its thinnest parts [m].

        Errors: ValueError for an unknown mode.
        """
    def add_terrain_solid(self, field: HeightField, mode: str, mu_c: float) -> None:
        """Add ground under a height map, which it keeps alive. Errors: ValueError for an unknown mode."""
    def surface(self, index: int, points: Array64) -> tuple[Array64, Array64]:
        """Return signed distances (n,) [m], below 0 inside, and normals (n, 3) at points (n, 3) [m].

        Computed in the precision of the step. Errors: IndexError for a solid that is not there.
        """
    def place_solid(
        self, index: int, centre: Array64, rotation: Array64, velocity: Array64, omega: Array64
    ) -> None:
        """Put solid `index` somewhere until it is placed anew.

        centre (3,) [m]; rotation (3, 3) from its own axes to the world's [1]; velocity of the centre (3,)
        [m/s]; omega (3,) [1/s]
        Errors: IndexError for a solid that is not there.
        """
    def follow(self, index: int, path: ScriptedPath, time: float, reach: float) -> float:
        """Put solid `index` where its path has it at `time` [s].

        reach: of its surface from the origin of its frame [m], infinite for one without an end. Returns a
        bound on the speed of the surface, of an endless one the speed of that origin [m/s].
        Errors: IndexError for a solid that is not there.
        """
    def move_bodies(self, motion: BodyMotion, reach: Array64) -> float:
        """Put the b bodies, in their order, somewhere until they are placed anew, and say how they move.

        reach (b,): how far a body's surface is from the origin of its frame [m].
        Returns a bound on the speed of their surfaces [m/s]. Errors: ValueError for another number of bodies.
        """
    def set_belt(self, index: int, velocity: Array64) -> None:
        """Let the flat faces of solid `index` move along themselves like a belt; at first they do not.

        velocity: of the surface past the solid, in the axes of the world (3,) [m/s]; its part along a face's
        normal does not count. Meant for planes and boxes. Errors: IndexError for a solid that is not there.
        """
    def make_dynamic(self, index: int) -> None:
        """Let snow move solid `index`; the order of the calls is the order of the bodies.

        Mobility is 0 again for all bodies until `move_bodies`. Errors: IndexError for a solid that is
        not there.
        """

class State(Protocol):
    """The particles: writable views of the core's memory, valid while `count` stays."""

    count: int
    """Number of particles n."""
    @property
    def bytes(self) -> int:
        """Memory of the arrays [bytes]."""
    @property
    def x(self) -> Reals:
        """Position [m], (n, 3)."""
    @property
    def beyond(self) -> Reals:
        """What is to be added to x [m], less than its rounding: (n, 3); (n, 0) if positions are not fine."""
    @property
    def v(self) -> Reals:
        """Velocity [m/s], (n, 3)."""
    @property
    def C(self) -> Reals:
        """Affine velocity [1/s], (n, 3, 3): row a is grad v_a; zero with transfers that have none."""
    @property
    def modes(self) -> Reals:
        """Further modes of the velocity [m/s], (n, more_modes, 3)."""
    @property
    def rest(self) -> Reals:
        """For how long the particle has rested, infinite in sleep, and its mean velocity of late [s, m/s].

        (n, 4); (n, 0) if none may sleep.
        """
    @property
    def enthalpy(self) -> Array64:
        """Heat above that of ice at the melting point [J], (n, 1), in double; (n, 0) without heat."""
    @property
    def thermal(self) -> Reals:
        """Share of water that stress follows, growth of strength by sintering, most water ever [1].

        (n, 3); (n, 0) without heat.
        """
    @property
    def F_E(self) -> Reals:
        """Elastic deformation gradient [1], (n, 3, 3)."""
    @property
    def tau(self) -> Reals:
        """Kirchhoff stress P F_E^T [Pa], (n, 6), in the order xx yy zz xy xz yz.

        Zero before the first step; written by `refresh` and `g2p`, so it is as new as the last of them.
        """
    @property
    def J_P(self) -> Reals:
        """Plastic volume change [1], (n,)."""
    @property
    def m(self) -> Reals:
        """Mass [kg], (n,)."""
    @property
    def V0(self) -> Reals:
        """Volume at rest [m3], (n,)."""
    @property
    def stiffness(self) -> Reals:
        """Factor on E0 [1], (n,)."""
    @property
    def strength(self) -> Reals:
        """Factor on the thresholds of plastic flow [1], (n,)."""
    @property
    def material(self) -> NDArray[np.uint16]:
        """Row of the material table, (n,)."""
    @property
    def id(self) -> NDArray[np.uint32]:
        """Number in the order of birth, (n,); rows change places in `sort`."""
    @property
    def capacity(self) -> int:
        """Number of particles that there is room for."""
    def with_room(self, capacity: int) -> _State:
        """Return a copy that has room for so many particles; views of this one stay as they are."""
    def append(self, n: int) -> None:
        """Add n particles after the others: at rest, not deformed, without mass, their ids the rows.

        Arrays that were handed out before do not show them. Errors: ValueError without room for them.
        """
    def rows_in_box(self, low: Array64, high: Array64) -> NDArray[np.uint32]:
        """Return the rows of the particles in the closed box from `low` to `high` (3,) [m], rising."""
    def drop(self, rows: NDArray[np.uint32]) -> None:
        """Drop the particles at `rows`, which rise; the last ones take their places.

        Errors: ValueError for rows that are none, or do not rise.
        """

class Grid(Protocol):
    """The sparse grid: scratch, laid out anew by `sort`."""

    @property
    def current(self) -> bool:
        """No particle has left the reach of its block since `sort`."""
    @property
    def blocks(self) -> int:
        """Blocks of 4x4x4 nodes in use since `sort`."""
    @property
    def homes(self) -> int:
        """Blocks that own particles which move, since `sort`."""
    def look_at_all(self, report: Report, may_sleep: bool, /) -> None:
        """Let the next `sort` see who sleeps, if somebody may; report: what `refresh` has found."""
    @property
    def bytes(self) -> int:
        """Memory [bytes]."""
    def take_exchanged(self, solids: int, /) -> Array64:
        """Return what snow and each solid exchanged since the last call, (solids, 7).

        Impulse of the snow on the solid [N s], its moment about the solid's centre [N m s], work of the solid
        on the snow [J].
        """
    def nodes(self) -> tuple[NDArray[np.int32], Reals, Reals]:
        """Return of the nodes with mass: indices (n, 3), mass (n,) [kg], and a vector (n, 3).

        After `p2g` it is the momentum [kg m/s], after `grid_update` the velocity [m/s].
        """

class ImplicitSolver(Protocol):
    """Find velocities of nodes and bodies at the end of a step from implicit equations."""

    diagonal: bool
    """Whether the diagonal of the stiffness preconditions snow that lies on what no snow moves."""
    @property
    def iterations(self) -> int:
        """Of all linear systems of the last step."""
    @property
    def rounds(self) -> int:
        """Linear systems of the last step."""
    @property
    def residual(self) -> float:
        """Largest share of the forces of a piece of snow that the last solution left over [1]."""
    @property
    def contacts_settled(self) -> bool:
        """Whether the last step followed its contacts until none changed; else they stayed as they were."""
    @property
    def converged(self) -> bool:
        """Whether the last step was solved."""
    def learn(
        self, law: str, weights: Mapping[str, Sequence[float]], regularity: float | None = None
    ) -> None:
        """Take the return map of a law from a network: a, b, W, V, w, d and q, row by row, as in
        `neve.learned`; regularity: r over the stiffness, unless it is to be the law's own. Errors: ValueError
        for an unknown law, or weights that do not fit each other.
        """
    def solve(self, model: Model, state: State, grid: Grid, dt: float) -> GridReport:
        """Turn momenta without force, as `p2g` with dt = 0 leaves them, into velocities after dt [s].

        By the midpoint rule: after dt / 2. Errors: ValueError as of `p2g`, for snow that sleeps or has heat,
        and for bodies by the midpoint rule.
        """
    def finish(self, state: State) -> None:
        """Give particles that `g2p` has moved what the midpoint rule has left for them, if it has."""

class Ranks(Protocol):
    """What a run on several ranks asks of the core; blocks are named by keys (n,)."""

    def row_bytes(self, state: State, /) -> int:
        """Return the bytes of one particle."""
    def pack(self, state: State, rows: NDArray[np.uint32], /) -> NDArray[np.uint8]:
        """Return the particles at `rows` (n,) as bytes, column after column."""
    def unpack(self, state: State, rows: NDArray[np.uint32], data: NDArray[np.uint8], /) -> None:
        """Put what `pack` gave into `rows` (n,). Errors: ValueError for other rows or bytes."""
    def homes_now(self, model: Model, state: State, /) -> NDArray[np.uint64]:
        """Return the block that each particle is in, (n,). Errors: ValueError beyond the lattice."""
    def owners(self, keys: NDArray[np.uint64], cuts: NDArray[np.uint64], /) -> NDArray[np.int32]:
        """Return the rank that owns each block (n,); cuts: where ranks but the first begin on the curve."""
    def curve(self, keys: NDArray[np.uint64], /) -> NDArray[np.uint64]:
        """Return where blocks (n,) are on the curve, (n,)."""
    def homes_then(self, grid: Grid, rows: NDArray[np.uint32], /) -> NDArray[np.uint64]:
        """Return the blocks that `rows` (n,) were in at the last sort, (n,)."""
    def note_order(self, state: State, grid: Grid, /) -> None:
        """Note where all particles were at the last sort, before some go."""
    def depart(self, state: State, grid: Grid, rows: NDArray[np.uint32], /) -> None:
        """Let the particles at `rows`, which rise, go. Errors: ValueError before `note_order`."""
    def arrive(
        self,
        state: State,
        grid: Grid,
        home: NDArray[np.uint64],
        row: NDArray[np.uint32],
        data: NDArray[np.uint8],
        /,
    ) -> None:
        """Let particles come, which were in these homes and rows (n,). Views of the state are not valid any
        longer. Errors: ValueError for other bytes, or before `note_order`.
        """
    def homes(self, grid: Grid, /) -> tuple[NDArray[np.uint64], NDArray[np.uint32]]:
        """Return the blocks that own particles, rising (n,), and how many each has, (n,)."""
    def border(
        self, grid: Grid, cuts: NDArray[np.uint64], rank: int, /
    ) -> tuple[NDArray[np.int32], NDArray[np.uint64]]:
        """Return ranks, rising (n,), and blocks of this rank beside theirs, (n,)."""
    def lay_halo(
        self,
        grid: Grid,
        lower: Sequence[bool],
        mine: Sequence[NDArray[np.uint64]],
        theirs: Sequence[NDArray[np.uint64]],
        /,
    ) -> list[tuple[int, int]]:
        """Lay out what is exchanged with each neighbour: the node blocks given to it, and taken from it.

        lower: whether its rank is; mine, theirs: what `border` found here and there, of each other
        """
    def pieces(self, grid: Grid, /) -> tuple[int, int, int]:
        """Return the addresses of what is sent and received, and the bytes of a node block."""
    def counted(self, grid: Grid, /) -> int:
        """Return how many node blocks no lower rank has."""
    def update_nodes(self, model: Model, grid: Grid, dt: float, /) -> tuple[NDArray[np.uint64], NDArray[Any]]:
        """Do what `grid_update` does up to contacts with bodies; return the node blocks near bodies that no
        lower rank has: their keys, rising (n,), and the values of their nodes, one block after another.
        """
    def meet_bodies(
        self, model: Model, grid: Grid, dt: float, keys: NDArray[np.uint64], values: NDArray[Any], /
    ) -> GridReport:
        """Do the rest, given what all ranks have found, by rising key; bodies get their velocities."""
    def border_homes(self, grid: Grid, /) -> int:
        """Return how many blocks here give to nodes of other ranks."""
    def take_ledger(self, grid: Grid, /) -> NDArray[np.uint8]:
        """Return the exchanges with solids since the last call, as rows of bytes."""
    def lightest(self, grid: Grid, /) -> float:
        """Return the mass of the lightest particle here [kg]."""
    def set_lightest(self, grid: Grid, mass: float, /) -> None:
        """Take over that of all ranks."""
    def unsort(self, grid: Grid, /) -> None:
        """Let the next step sort."""

_Model = Model
_State = State
_Grid = Grid
_ImplicitSolver = ImplicitSolver

class ParticleReport:
    """What a step of the discrete element method found."""

    speed: float
    """Largest speed of a particle [m/s]."""
    stiffest: float
    """Largest sum of the stiffness of a particle's contacts and bonds over its mass [1/s2]."""
    rate: float
    """Inverse of the longest step that is stable for the particles that do not sleep [1/s]."""
    finite: bool
    """Every particle has a finite place and velocity."""

class ParticleTotals:
    """Sums over the particles, in double precision and in a fixed order."""

    mass: float
    """[kg]"""
    momentum: list[float]
    """Sum of m v, (3,) [kg m/s]."""
    kinetic: float
    """Sum of m |v|^2 / 2 [J]."""
    elastic: float
    """Of bonds, contacts and the springs of their friction [J]."""
    potential: float
    """Sum of -m g . x [J]."""
    bonds: float
    """Number of bonds."""
    contacts: float
    """Number of contacts."""
    heat: float
    """Enthalpy above that of ice at the melting point [J]."""
    water: float
    """Mass that is liquid [kg]."""

class HeatModel:
    """What a scene says of heat."""

    def __init__(
        self,
        *,
        air: float,
        exchange: float,
        sun: float,
        towards: tuple[float, float, float],
        conductivity: float,
        speed: float,
        sinters: bool,
    ) -> None:
        """Take the values.

        air: its temperature [deg C]; exchange with it [W/(m2 K)]; sun: power that is absorbed where snow
        faces it [W/m2]; towards: the sun, a unit vector; conductivity, 0: as density and phase say [W/(m K)];
        speed: seconds of heat in one of motion; sinters: snow at rest grows stronger.
        """

class HeatReport:
    """What a pass over the heat of particles found."""

    taken: float
    """Heat from air and sun [J]."""
    rounds: int
    """Rounds in which the heat flowed."""
    finite: bool
    """Every particle has finite heat."""
    endless: bool
    """Whether it asks for so many rounds that it was not made."""

class GridHeatReport(HeatReport):
    """The same in the material point method, and what the particles make of it."""

    changed: bool
    """The share of water of some particle has changed."""
    woken: bool
    """Some of them slept, and will be woken by the next `sort` of all."""

class Particles(Protocol):
    """Particles of the discrete element method, and what is remembered of their pairs.

    Arrays are views of the core's memory, rows in an order that `prepare` may change.
    """

    x: Reals
    """Positions (n, 3) [m]."""
    v: Reals
    """Velocities (n, 3) [m/s]."""
    m: Reals
    """Masses (n,) [kg]."""
    V0: Reals
    """Volumes of snow at birth (n,) [m3]."""
    radius: Reals
    """Radii now (n,) [m]."""
    J_P: Reals
    """Volumes over those at birth (n,) [1]."""
    stiffness: Reals
    """Factors on the modulus (n,) [1]."""
    strength: Reals
    """Factors on the strain that bonds bear and on the yield pressure (n,) [1]."""
    liquid: Reals
    """Shares of water that size and strength follow (n,) [1]."""
    rest: Reals
    """Times near a place [s] and the places [m], (n, 4); in sleep infinite, and the forces [N]."""
    enthalpy: Array64
    """Heat above that of ice at the melting point (n,) [J], in double precision."""
    k: Reals
    """Modulus times radius at birth (n,) [N/m]; from `set_materials`."""
    bond: Reals
    """Strain that bonds bear (n,) [1]; from `set_materials`."""
    born: Reals
    """Radii at birth (n,) [m]; from `set_materials`."""
    material: NDArray[np.uint16]
    """Rows of the material table (n,)."""
    source: NDArray[np.uint16]
    """Numbers of the sources (n,): snow of one is bonded."""
    id: NDArray[np.uint32]
    """Birth numbers (n,)."""
    last_dt: float
    """Length of the last step [s], by which the springs of friction are still to be turned."""
    @property
    def count(self) -> int:
        """Number of particles n."""
    @property
    def bytes(self) -> int:
        """Memory [bytes]."""
    order: int
    """How wide the groups of rows were when they were last sorted, below 0: never; part of the state."""
    @property
    def drift(self) -> list[float]:
        """Velocity that all are expected to share until they are listed anew, (3,) [m/s]."""
    may_sleep: bool
    """Whether snow may fall asleep now."""
    @property
    def asleep(self) -> int:
        """Number of particles that sleep."""
    @property
    def is_due(self) -> bool:
        """Whether `renew` is needed before the next step."""
    @property
    def stiffest(self) -> float:
        """Largest k / m of a particle [1/s2]; from `set_materials`, as the next."""
    @property
    def largest_radius(self) -> float:
        """Of a particle at birth [m]."""
    def rate_of(self, stiffness: float) -> float:
        """Return the `ParticleReport.rate` of a particle whose springs are so stiff over its mass [1/s2].

        All act one way, with dampers as of `set_law`.
        """
    def set_law(self, damping: float, tangential: float, ice: float, hardening: float) -> None:
        """Set what all contacts share.

        damping: damper over stiffness [s]; tangential: stiffness along over that across [1]; ice: density at
        which nothing is compacted more [kg/m3]; hardening: rise of density for an e-fold yield pressure
        [kg/m3].
        """
    def set_materials(self, rows: Array64, packing: float) -> None:
        """Set the table, (k, 4): modulus [Pa], friction [1], bond strain [1], yield pressure [Pa].

        packing: share of the volumes that spheres fill at birth [1].

        Errors: ValueError if a particle names a row that is not there.
        """
    def set_sleep(self, way: float, after: float, slow: float) -> None:
        """Set when snow sleeps: it stays within `way` [m], 0: never, for `after` [s].

        slow: what hangs on it may swing up to this speed [m/s].
        """
    def set_heat(self, heat: HeatModel) -> None:
        """Set what is said of heat."""
    def pass_heat(self, dt: float, solids: _Model | None = None) -> HeatReport:
        """Let heat flow for dt [s] of motion, and change phases, sizes and bonds; needs `set_materials`.

        solids: what hides snow that it touches from air and sun.
        """
    def prepare(self, near: float, dt: float) -> None:
        """Get ready for steps of dt [s] after the state may have been written to.

        See who sleeps, sort the rows where they are in disorder, list all pairs within `near` [m].
        Errors: ValueError with the birth number of a particle that is lost.
        """
    def renew(self, solids: _Model, steps: int) -> None:
        """After step number `steps` list pairs of what moved, wake, put to sleep. Errors: as `prepare`."""
    def make_bonds(self, first: int, gap: float) -> None:
        """Bond the listed pairs of one source and of ids from `first` on whose gap is at most `gap` radii."""
    def with_particles(self, kept: NDArray[np.uint32], more: int) -> Particles:
        """Return others: those at the rows `kept`, which rise, with their pairs, then `more` fresh ones.

        `prepare` lists their pairs. What had a pair with one that is gone wakes.
        """
    def bond_newborn(self, first: int, gap: float) -> None:
        """Bond particles of birth numbers from `first` on to what they are born beside, as they lie.

        To those of their source across a gap of at most `gap` of the radii's sum, to others if they overlap.
        """
    def totals_of(self, solids: Model, rows: NDArray[np.uint32]) -> ParticleTotals:
        """Return what is lost with the particles at `rows`, added up in this order, pairs in full."""
    def relax(self) -> None:
        """Move overlapping particles apart once."""
    def stiffness_now(self) -> ParticleReport:
        """Report on the particles as they are."""
    def step(self, solids: _Model, dt: float) -> ParticleReport:
        """Advance by dt [s] among the solids of a model, with its gravity."""
    def totals(self, solids: _Model) -> ParticleTotals:
        """Add up the state."""
    def contacts(self) -> tuple[NDArray[np.uint32], NDArray[np.int32], Reals]:
        """Return begin (n + 1,); for each entry the row of the other particle; four numbers (k, 4) [m].

        Of a bond the stretch that it bears, above 0, and the overlap at rest; of a contact less the gap that
        its cohesion bridges, and the spring of its friction (3).
        """
    def set_contacts(
        self, near: float, begin: NDArray[np.uint32], row: NDArray[np.int32], values: Reals
    ) -> None:
        """List all pairs within `near` [m], with what `contacts` returned.

        Errors: ValueError if it is of other particles.
        """
    def take_exchanged(self, solids: int) -> Array64:
        """Return what snow and each of the solids exchanged since the last call, (solids, 7)."""

_Particles = Particles

class SolveReport:
    """How a solve ended."""

    iterations: int
    """Number of iterations."""
    residual: float
    """Of pressure: mean of |rho_0 - rho* - A p| / rho_0; of shear: |b - M a| / |b| [1]."""
    largest: float
    """Of pressure: the former of the particle that has most; of shear: 0 [1]."""
    converged: bool
    """The residual is within the tolerance."""

class SphReport:
    """What the end of a step of smoothed particles found."""

    speed: float
    """Largest speed of a particle at the end [m/s]."""
    strain_rate: float
    """Largest |grad v| [1/s]."""
    finite: bool
    """Every particle has a finite velocity."""
    taken: bool
    """The particles have moved."""

class SphTotals:
    """Sums over the snow, in double precision and in a fixed order."""

    mass: float
    """[kg]"""
    momentum: list[float]
    """Sum of m v, (3,) [kg m/s]."""
    kinetic: float
    """Sum of m |v|^2 / 2 [J]."""
    elastic: float
    """Of the stress, with the moduli that `find_densities` found [J]."""
    potential: float
    """Sum of -m g . x [J]."""

class Sph(Protocol):
    """Snow as smoothed particles, and the boundary particles of solids.

    Arrays are views of the core's memory, rows in an order that `find_pairs` changes.
    """

    x: Reals
    """Positions (n, 3) [m]."""
    v: Reals
    """Velocities (n, 3) [m/s]."""
    F_E: Reals
    """Elastic stretches in the axes of the world, symmetric (n, 3, 3) [1]."""
    m: Reals
    """Masses (n,) [kg]."""
    V0: Reals
    """Volumes at birth (n,) [m3]."""
    rho_birth: Reals
    """Rest densities at birth (n,) [kg/m3]; where one is 0, `find_densities` sets it to that of now."""
    J_P: Reals
    """Rest density at birth over that now (n,) [1]; from `find_densities`."""
    p_last: Reals
    """Pressures of the last step, from which `solve_pressure` starts (n,) [Pa]."""
    a_last: Reals
    """Accelerations by shear of the last step, from which `solve_shear` starts (n, 3) [m/s2]."""
    stiffness: Reals
    """Factors on E0 (n,) [1]."""
    strength: Reals
    """Factors on the critical strains (n,) [1]."""
    material: NDArray[np.uint16]
    """Rows of the material table (n,)."""
    source: NDArray[np.uint16]
    """Numbers of the sources (n,)."""
    id: NDArray[np.uint32]
    """Birth numbers (n,)."""
    rho0: Reals
    """Rest densities (n,) [kg/m3]; from `find_densities`."""
    rho: Reals
    """Densities, boundaries included (n,) [kg/m3]; from `find_densities`."""
    lam: Reals
    """Lame's first moduli, hardened (n,) [Pa]; from `find_densities`."""
    G: Reals
    """Shear moduli, hardened (n,) [Pa]; from `find_densities`."""
    L: Reals
    """Corrections of the kernel's gradient (n, 3, 3) [1]; from `correct_gradients`."""
    fill: Reals
    """How much of its kernel is filled, of water (n,) [1]; 1 of snow; from `find_densities`."""
    p: Reals
    """Pressures (n,) [Pa]; from `solve_pressure`."""
    given: Reals
    """Accelerations by gravity and friction (n, 3) [m/s2]; from `find_given`."""
    pressed: Reals
    """Accelerations by pressure (n, 3) [m/s2]; from `solve_pressure`."""
    sheared: Reals
    """Accelerations by shear (n, 3) [m/s2]; from `solve_shear`."""
    boundary_x: Reals
    """Positions of boundary particles (k, 3) [m], in an order that `find_pairs` changes."""
    boundary_v: Reals
    """Velocities of boundary particles (k, 3) [m/s]."""
    boundary_V: Reals
    """Volumes of boundary particles (k,) [m3]."""
    @property
    def count(self) -> int:
        """Number of particles n."""
    @property
    def support(self) -> float:
        """Distance at which the kernel ends [m]."""
    @property
    def pairs(self) -> list[int]:
        """Entries of snow with snow, two for each pair, and of snow with boundaries."""
    @property
    def boundary_kernels(self) -> int:
        """Kernels that the volumes of boundary particles have taken so far, their own among them."""
    @property
    def bytes(self) -> int:
        """Memory [bytes]."""
    def set_water(self, material: int, rho0: float, bulk_modulus: float, viscosity: float) -> None:
        """Say that the particles of a row of the material table are water.

        rho0 [kg/m3], bulk_modulus [Pa], viscosity [Pa s]. Errors: ValueError for values out of range.
        """
    def set_boundary(self, x: Array64, normal: Array64, solid: NDArray[np.int32]) -> None:
        """Take boundary particles, and find their volumes.

        x [m], normal (k, 3): in the frames of their solids; solid (k,): of each, rising.
        Errors: ValueError for arrays of other lengths or an order that does not rise.
        """
    def find_pairs(self, solids: _Model, dt: float = 0.0) -> None:
        """Sort snow and boundary by cell, and list the pairs within the support.

        dt [s]: of free fall of the bodies among the solids, whose velocities then count.
        Errors: ValueError with the birth number of a particle that is lost, or for a material or a solid that
        the model has not.
        """
    def find_densities(self, solids: _Model) -> None:
        """Find rho_0, rho, J_P, lam and G."""
    def correct_gradients(self, solids: _Model) -> None:
        """Find L; needs `find_densities`."""
    def find_given(self, solids: _Model, dt: float) -> None:
        """Find the accelerations by gravity and friction in a step of dt [s]."""
    def solve_pressure(
        self, solids: _Model, dt: float, tolerance: float, largest: float, most: int
    ) -> SolveReport:
        """Solve for the pressures at the end of a step of dt [s], in `most` iterations at most.

        tolerance, largest: residual at which it ends, the mean and that of any particle.
        """
    def solve_shear(self, dt: float, tolerance: float, most: int) -> SolveReport:
        """Solve for the accelerations by shear in a step of dt [s], in `most` iterations at most."""
    def advance(self, solids: _Model, dt: float, way: float, strain: float) -> SphReport:
        """Move the snow by dt [s], unless a particle would move by more than `way` [m] or dt |grad v| exceed
        `strain` [1].
        """
    def body_rate(self, solids: _Model) -> float:
        """Return the largest rate at which snow can change the velocity of a body [1/s]; 0 without any."""
    def stress_rate(self) -> float:
        """Return how fast planes of pressed snow swing against each other at most, as omega [1/s]; 0 if none.

        That of the gradients of the kernel under the largest principal pressure of any particle, which steps
        integrate explicitly; water is left out.
        """
    def velocity_gradient(self, u: Array64) -> Reals:
        """Return the gradients (n, 3, 3) [1/s] of velocities u (n, 3) [m/s], of solids at rest."""
    def totals(self, solids: _Model) -> SphTotals:
        """Add up the state."""
    def take_exchanged(self, solids: int) -> Array64:
        """Return what snow and each of the solids exchanged since the last call, (solids, 7)."""

_Sph = Sph

class Precision(Protocol):
    """The objects and stages of one precision; objects of the other one are a TypeError."""

    lanes: int
    """Numbers of this precision in a pack: as many as fill 64 bytes."""
    device_step_bytes: int
    """Size of the struct that a GPU's kernels are given."""
    device_control_bytes: int
    """Size of the struct by which a GPU chooses its steps."""
    def Model(
        self,
        dx: float,
        spline: str,
        transfer: str,
        flip_alpha: float,
        gravity: Array64,
        polypic_modes: int = 8,
        flip_damping: float | None = None,
        sleep_speed: float = 0.0,
        sleep_after: float = 0.0,
    ) -> _Model:
        """Make a model without snows and solids.

        dx: grid spacing [m]; spline and transfer: words of `splines` and `transfers`; gravity (3,) [m/s2];
        polypic_modes: 1, 4, 8 or 27; flip_alpha, flip_damping: see [numerics] of a scene, read by the
        transfers that name them in `options`; sleep_speed [m/s], sleep_after [s]: likewise, 0 for snow that
        never sleeps
        Errors: ValueError for an unknown word, or another number of modes.
        """
    def State(
        self, count: int, more_modes: int = 0, sleeps: bool = False, heat: bool = False, fine: bool = False
    ) -> _State:
        """Make `count` particles at rest; more_modes, sleeps, heat: as the model has.

        F_E = I; J_P, stiffness and strength 1; id 0 to count - 1; all else, the mass too, is 0.
        Errors: ValueError for more_modes below 0.
        """
    def Particles(self, count: int) -> _Particles:
        """Make `count` particles without mass or radius; J_P and factors are 1, id 0 to count - 1."""
    def Sph(self, count: int, support: float) -> _Sph:
        """Make particles at rest, not deformed, without mass; `support` of the kernel [m]."""
    def Grid(self) -> _Grid:
        """Make an empty grid: `sort` lays it out."""
    def ImplicitSolver(
        self,
        *,
        newton: bool,
        beta: float,
        project: bool,
        tolerance: float,
        most_iterations: int,
        midpoint: bool,
    ) -> _ImplicitSolver:
        """Make what finds the velocities at the end of a step from implicit equations.

        newton: backward Euler, else one linear system with `beta`; project: without negative second
        derivatives; tolerance: of the forces [1]; midpoint: the implicit midpoint rule
        """
    def stiffness(
        self, model: _Model, state: _State, grid: _Grid, dt: float, u: Reals, project: bool
    ) -> tuple[Reals, Reals]:
        """Return H u (n, blocks, 64, 3) and the diagonal of H (blocks, 64, 3) [kg], for tests.

        Of velocities u (n, blocks, 64, 3) of the nodes; H is dt^2 times the stiffness of snow as it lies on
        the grid, flow left out. Errors: ValueError as of `p2g`, and for other blocks than those of the grid.
        """
    def hessian_product(
        self,
        name: str,
        plasticity: str,
        constants: dict[str, float],
        F: Array64,
        J_P: Array64,
        dF: Array64,
        project: bool,
        flows: bool = False,
    ) -> Array64:
        """Return dP (n, 3, 3) [Pa] = (d2Psi/dF2) : dF of one snow in its present state, for F (n, 3, 3).

        flows: of what its return map makes of F, symmetric part, in place of the elastic energy;
        project: without the negative eigenvalues of d2Psi/dF2. Errors: ValueError for lengths that differ.
        """
    def learned_response(
        self,
        name: str,
        constants: dict[str, float],
        weights: Mapping[str, Sequence[float]],
        F0: Array64,
        J_P: Array64,
        F: Array64,
        dF: Array64,
        regularity: float | None = None,
    ) -> tuple[Array64, Array64]:
        """Return P (n, 3, 3) [Pa] at F of the energy that a network expands around F0, and its change by dF.

        J_P (n,): at the start of the step; regularity: r over the stiffness, or the law's own. Errors:
        ValueError for lengths that differ, and for a law that no network can take the place of.
        """
    def sort(self, model: _Model, state: _State, grid: _Grid, /) -> None:
        """Sort the rows of the state by block and cell, and lay out the grid.

        Errors: ValueError for a particle beyond the lattice.
        """
    def refresh(self, model: _Model, state: _State, /) -> Report:
        """Write `state.tau` from F_E and J_P, and report; nothing else changes.

        Errors: ValueError for a material that the model lacks.
        """
    ranks: Ranks
    """What a run on several ranks asks besides."""
    def give(self, model: _Model, state: _State, grid: _Grid, dt: float, /) -> None:
        """Scatter the particles at the border of a rank, for it and for others; then follows `p2g`."""
    def p2g(self, model: _Model, state: _State, grid: _Grid, dt: float, /) -> None:
        """Scatter mass, momentum and dt [s] times force to the nodes; needs a `current` grid.

        Errors: ValueError for a grid that is not current or of another state, or for other modes than the
        model's.
        """
    def volumes_from_grid(self, model: _Model, state: _State, grid: _Grid, /) -> None:
        """Write `state.V0` = m / rho, with rho from the masses that `p2g` left. Errors: as of `p2g`."""
    def grid_update(self, model: _Model, grid: _Grid, dt: float, /) -> GridReport:
        """Turn the momenta of `p2g` into velocities after dt [s], with gravity and contact.

        Errors: ValueError for a grid of another kind of transfer.
        """
    def g2p(self, model: _Model, state: _State, grid: _Grid, dt: float, commit: bool = True) -> Report:
        """Deform and move the particles by dt [s]; without `commit` the state is left as it is.

        Errors: as of `p2g`.
        """
    def totals(self, model: _Model, state: _State, /) -> Totals:
        """Add up the state as it stands.

        Errors: ValueError for a material that the model lacks, or for other modes than the model's.
        """
    def pass_heat(self, model: _Model, state: _State, dt: float) -> GridHeatReport:
        """Let heat flow for dt [s] of motion, and let phases and strength of the particles follow.

        Stresses are as before: `refresh` finds them anew. Errors: ValueError without heat.
        """
    def first_not_finite(self, state: _State, /) -> int:
        """Return the row with the lowest id that has a value that is not finite; -1 if there is none."""
    def inspect(self, model: _Model, state: _State) -> tuple[int, str, int, float]:
        """Return the row with the lowest id that has an impossible value, -1 if there is none, and its field.

        Then the row of the densest snow with plastic flow, -1 without any, and its density over that of ice
        or, if that is more, over its own at rest / 0.9.
        """
    def ice(self, z: Reals, speed: float = 0.0) -> tuple[Reals, Reals, Reals]:
        """Return pressure [Pa], energy [J/m3], modulus to come [Pa] of ice over J_ice.

        z = ln(J_ice / J) >= 0, which changes by speed [m/s] / dx in a second.
        """
    def svd(self, F: Reals) -> tuple[Reals, Reals, Reals]:
        """Return U (n, 3, 3), sigma (n, 3) and V (n, 3, 3) with F = U diag(sigma) V^T, of F (n, 3, 3).

        U and V are rotations, det = +1; sigma_0 >= sigma_1 >= |sigma_2|, which has the sign of det F.
        """
    def isotropic_function(self, F: Reals, y: Reals) -> tuple[Reals, Reals]:
        """Return e (n, 3), the eigenvalues of F^T F - I, and matrices (n, 3, 3) with the same eigenvectors.

        The eigenvalue that stands apart is the first. y: eigenvalues (n, 3) of the matrices, in that order.
        """
    def weights(self, spline: str, x: Reals) -> tuple[NDArray[np.int32], Reals, Reals]:
        """Return of positions x (n,) [cells] on one axis: first node (n,), weights and derivatives (n, k).

        Weights [1] of the k nodes from the first, and their derivatives by x [1/cells]; k is 3 for quadratic
        and 4 for cubic splines. Errors: ValueError for an unknown spline.
        """
    def function(self, name: Literal["exp", "expm1", "log1p", "sinh", "asinh"], x: Reals) -> Reals:
        """Return a function of x (n,) as the packs compute it, (n,); sinh and asinh for x >= 0 only.

        Errors: ValueError for another name.
        """
    def law(
        self,
        name: str,
        plasticity: str,
        constants: dict[str, float],
        F_trial: Reals,
        J_P: Reals,
        strength: Reals | None = None,
    ) -> tuple[Reals, Reals, Reals, Reals, Reals]:
        """Return the plastic update of n particles and what the new state has, as the step computes it.

        name: of the law; plasticity: "snow" or "none"; constants: by name, the usual ones where they are left
        out; F_trial (n, 3, 3), J_P (n,) and strength (n,) [1], 1 if left out; stiffness is 1. In this order:
        F_E (n, 3, 3) [1], J_P (n,) [1], Kirchhoff stress tau (n, 3, 3) [Pa], elastic energy per volume at
        rest (n,) [J/m3], largest acoustic modulus (n,) [Pa].
        Errors: ValueError for arrays of different lengths, an unknown law or plasticity, or a constant that
        no law has; those of other laws are left aside.
        """

class Choice:
    """One of the words that a scene may choose."""

    name: str
    """The word."""
    meaning: str
    """What it stands for: one sentence."""
    source: str
    """Where its equations come from."""
    cites: list[str]
    """Keys of the works behind it."""

class Constant:
    """What a law says about one of its constants, which is legal from low to high [unit]."""

    name: str
    """Its key."""
    usual: float
    """Its default [unit]."""
    unit: str
    """Its unit, in which all other numbers here are."""
    low: float
    """Lower end of what is legal [unit]."""
    high: float
    """Upper end of what is legal [unit]."""
    open_low: bool
    """The lower end itself is not legal."""
    open_high: bool
    """The upper end itself is not legal."""
    drawn: tuple[float, float]
    """What random trials take, on a logarithmic scale where it spans a factor of 100 [unit]."""
    is_plastic: bool
    """Elasticity alone does not use it."""
    is_threshold: bool
    """A particle's `strength` multiplies it."""
    source: str
    """Where the default is from."""
    meaning: str
    """What it is: one sentence."""

class Law(Choice):
    """A constitutive law. `constants` are numbers by name, the usual ones where they are left out."""

    constants: list[Constant]
    """Its constants, in its own order."""
    has_elastic_option: bool
    """Whether plasticity = "none" leaves its elasticity alone."""
    plasticity_cites: list[str]
    """Keys of the works behind its plastic flow, if they are not the law's own."""
    limit: str
    """Why its thresholds have a limit: the end of a sentence."""

    def most_strength(self, constants: dict[str, float]) -> float:
        """Largest factor that the thresholds may have [1]; below 1 the constants are not legal."""
    def max_compression(self, constants: dict[str, float], strongest: float) -> float:
        """How far one step may compress the snow, -dt tr grad v [1]; strongest: largest factor [1]."""
    def hardening_exponent(self, constants: dict[str, float]) -> float:
        """Largest exponent of its hardening [1]."""

class Transfer(Choice):
    """A way of velocities between particles and grid."""

    options: list[str]
    """Keys of [numerics] that it reads."""
    keeps_C: bool
    """The affine velocity travels with the particle."""
    has_change: bool
    """Force and momentum stay apart on the grid."""
    has_affine_change: bool
    """C changes by what changed on the grid, too."""
    damps: bool
    """All motions but translations fade."""
    has_bounded_energy: bool
    """No step gives the particles more than the grid had."""
    separate_position_velocity: bool
    """Whether particles move with a velocity other than their own."""

def laws() -> list[Law]:
    """Return all constitutive laws, the default first; new objects each time."""

def transfers() -> list[Transfer]:
    """Return all transfers, the default first; new objects each time."""

def splines() -> list[Choice]:
    """Return all splines, the default first; new objects each time."""

ice_density: float
"""Density of ice at 0 C [kg/m3]."""
displacement_limit: float
"""Longest way of a particle in a step [cells]."""
volume_ratio_limit: float
"""Smallest det(I + dt grad v) of a particle in a step [1]."""
geometry: Geometry
"""Shapes, in double precision but for the samples that they keep."""
heat: Heat
"""Laws of heat and sintering, in double precision."""
snowfall: Snowfall
"""Snow that falls, in double precision."""
f32: Precision
"""Single precision."""
f64: Precision
"""Double precision, for verification and wide worlds."""

def build_info() -> dict[str, Any]:
    """Return what this build is; a new dict each time.

    isa: level of instructions that it needs, simd: its vectors, compiler: words; lanes_f32, lanes_f64:
    numbers in a pack; openmp: whether it has threads; threads: as `threads` at this moment.
    """

def set_threads(n: int) -> None:
    """Use n threads in later calls from this thread of Python; others keep theirs.

    n: from 1 to 1024; ValueError for others. Without OpenMP it does nothing. Results do not depend on it.
    """

def threads() -> int:
    """Return how many threads calls from this thread of Python use: 1 without OpenMP."""
