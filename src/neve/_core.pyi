"""Types of the compiled core; `f32` and `f64` are the same interface in two precisions.

This is the contract of a device (see neve.backend). Units are SI, positions and vectors in world axes, arrays
in C order; n is the number of particles. "real" is float32 in `f32` and float64 in `f64`.
"""

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
    finite: bool
    """Every particle has finite x, v, F_E, J_P and stress."""
    drifted: bool
    """Some particle left the reach of its block: `sort` before the next `p2g`."""
    offending_id: int
    """Lowest id among the particles that make the step unacceptable; 2^32 - 1 if there is none."""
    rejected: bool
    """Not finite, or beyond `displacement_limit` or `volume_ratio_limit`."""

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

class TriangleMesh:
    def __init__(self, vertices: Array64, faces: NDArray[np.int32]) -> None: ...
    @property
    def triangles(self) -> int: ...
    @property
    def skipped(self) -> int: ...
    @property
    def closed(self) -> bool: ...
    @property
    def inverted(self) -> bool: ...
    @property
    def area(self) -> float: ...
    @property
    def volume(self) -> float: ...
    @property
    def low(self) -> Array64: ...
    @property
    def high(self) -> Array64: ...
    def distance(self, points: Array64) -> Array64: ...
    def closest(self, points: Array64) -> tuple[Array64, Array64, NDArray[np.int32]]: ...
    def winding(self, points: Array64, exact: bool = False) -> Array64: ...
    def signed_distance(self, points: Array64) -> Array64: ...
    def ray(self, origins: Array64, directions: Array64) -> tuple[Array64, NDArray[np.int32]]: ...

class SdfGrid:
    @staticmethod
    def build(mesh: TriangleMesh, spacing: float, band: float, thickness: float = 0.0) -> SdfGrid: ...
    @staticmethod
    def bytes_for(mesh: TriangleMesh, spacing: float, band: float, thickness: float = 0.0) -> int: ...
    @staticmethod
    def from_arrays(arrays: dict[str, NDArray[Any]]) -> SdfGrid: ...
    def arrays(self) -> dict[str, NDArray[Any]]: ...
    def sample(self, points: Array64) -> tuple[Array64, Array64]: ...
    @property
    def bytes(self) -> int: ...
    @property
    def spacing(self) -> float: ...
    @property
    def band(self) -> float: ...
    @property
    def thickness(self) -> float: ...
    @property
    def openness(self) -> float: ...
    @property
    def low(self) -> Array64: ...
    @property
    def high(self) -> Array64: ...

class HeightField:
    def __init__(self, heights: NDArray[np.float32], size: Array64 | tuple[float, float]) -> None: ...
    def sample(self, points: Array64) -> tuple[Array64, Array64]: ...
    @property
    def heights(self) -> NDArray[np.float32]: ...
    @property
    def size(self) -> tuple[float, float]: ...
    @property
    def low(self) -> float: ...
    @property
    def high(self) -> float: ...
    @property
    def bytes(self) -> int: ...

_TriangleMesh = TriangleMesh
_SdfGrid = SdfGrid
_HeightField = HeightField

class Geometry(Protocol):
    TriangleMesh: type[_TriangleMesh]
    SdfGrid: type[_SdfGrid]
    HeightField: type[_HeightField]
    @staticmethod
    def shapes() -> tuple[str, ...]:
        """Return the words of all shapes, those with a formula before those with samples."""

class Model(Protocol):
    """The constants of one run, and its solids where they are."""

    dx: float
    """Grid spacing [m]."""
    more_modes: int
    """Velocity modes that a particle has beyond v and C."""
    keeps_C: bool
    """Whether particles carry an affine velocity."""

    def max_compression(self, strongest: float) -> float:
        """Return how far one step may compress any of the snows, -dt tr grad v [1]; see `Law`."""
    def add_snow(self, law: str, plasticity: str, constants: dict[str, float]) -> None:
        """Add a row to the material table, with the constants of the law by name, in their units."""
    def add_solid(self, shape: str, half: Array64, mode: str, mu_c: float) -> None:
        """Add a solid, at rest at the origin until it is placed.

        half: half extents in its own axes, (3,) [m]; mode of contact; mu_c: friction [1]
        """
    def add_mesh_solid(self, grid: SdfGrid, mode: str, mu_c: float, thickness: float = ...) -> None:
        """Add a solid of sampled distances; thickness: of its thinnest parts [m]."""
    def add_terrain_solid(self, field: HeightField, mode: str, mu_c: float) -> None:
        """Add ground under a height map."""
    def surface(self, index: int, points: Array64) -> tuple[Array64, Array64]:
        """Return signed distances (n,) [m], below 0 inside, and normals (n, 3) at points (n, 3) [m]."""
    def place_solid(
        self, index: int, centre: Array64, rotation: Array64, velocity: Array64, omega: Array64
    ) -> None:
        """Put solid `index` somewhere until it is placed anew.

        centre (3,) [m]; rotation (3, 3) from its own axes to the world's [1]; velocity of the centre (3,)
        [m/s]; omega (3,) [1/s]
        """
    def make_dynamic(self, index: int) -> None:
        """Let snow move solid `index`; the order of the calls is the order of the bodies."""
    def set_body_dynamics(self, mobility: Array64, free: Array64) -> None:
        """Say how the b bodies move in the next step.

        mobility (6 b, 6 b): impulses [N s] and moments [N m s] to changes of velocity [m/s] and of omega
        [1/s]; free (b, 6): accelerations by all but the snow [m/s2, 1/s2]
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
    def v(self) -> Reals:
        """Velocity [m/s], (n, 3)."""
    @property
    def C(self) -> Reals:
        """Affine velocity [1/s], (n, 3, 3): row a is grad v_a; zero with transfers that have none."""
    @property
    def modes(self) -> Reals:
        """Further modes of the velocity [m/s], (n, more_modes, 3)."""
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
        """Blocks that own particles since `sort`."""
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

_Model = Model
_State = State
_Grid = Grid

class Precision(Protocol):
    lanes: int
    def Model(
        self,
        dx: float,
        spline: str,
        transfer: str,
        flip_alpha: float,
        gravity: Array64,
        polypic_modes: int = 8,
        flip_damping: float | None = None,
    ) -> _Model: ...
    def State(self, count: int, more_modes: int = 0) -> _State: ...
    def Grid(self) -> _Grid: ...
    def sort(self, model: _Model, state: _State, grid: _Grid, /) -> None:
        """Sort the rows of the state by block and cell, and lay out the grid.

        Errors: ValueError for a particle beyond the lattice.
        """
    def refresh(self, model: _Model, state: _State, /) -> Report:
        """Write `state.tau` from F_E and J_P, and report; nothing else changes."""
    def p2g(self, model: _Model, state: _State, grid: _Grid, dt: float, /) -> None:
        """Scatter mass, momentum and dt [s] times force to the nodes; needs a `current` grid."""
    def volumes_from_grid(self, model: _Model, state: _State, grid: _Grid, /) -> None:
        """Write `state.V0` = m / rho, with rho from the masses that `p2g` left."""
    def grid_update(self, model: _Model, grid: _Grid, dt: float, /) -> GridReport:
        """Turn the momenta of `p2g` into velocities after dt [s], with gravity and contact."""
    def g2p(self, model: _Model, state: _State, grid: _Grid, dt: float, commit: bool = True) -> Report:
        """Deform and move the particles by dt [s]; without `commit` the state is left as it is."""
    def totals(self, model: _Model, state: _State, /) -> Totals:
        """Add up the state as it stands."""
    def first_not_finite(self, state: _State, /) -> int:
        """Return the row with the lowest id that has a value that is not finite; -1 if there is none."""
    def svd(self, F: Reals) -> tuple[Reals, Reals, Reals]: ...
    def weights(self, spline: str, x: Reals) -> tuple[NDArray[np.int32], Reals, Reals]: ...
    def function(self, name: Literal["exp", "expm1", "log1p", "sinh", "asinh"], x: Reals) -> Reals: ...
    def law(
        self,
        name: str,
        plasticity: str,
        constants: dict[str, float],
        F_trial: Reals,
        J_P: Reals,
        strength: Reals | None = None,
    ) -> tuple[Reals, Reals, Reals, Reals, Reals]: ...

class Choice:
    """One of the words that a scene may choose."""

    name: str
    meaning: str
    source: str
    cites: list[str]
    """Keys of the works behind it."""

class Constant:
    """What a law says about one of its constants, which is legal from low to high [unit]."""

    name: str
    usual: float
    """Its default [unit]."""
    unit: str
    low: float
    high: float
    open_low: bool
    """The lower end itself is not legal."""
    open_high: bool
    drawn: tuple[float, float]
    """What random trials take, on a logarithmic scale where it spans a factor of 100 [unit]."""
    is_plastic: bool
    """Elasticity alone does not use it."""
    is_threshold: bool
    """A particle's `strength` multiplies it."""
    source: str
    meaning: str

class Law(Choice):
    """A constitutive law. `constants` are numbers by name, the usual ones where they are left out."""

    constants: list[Constant]
    has_elastic_option: bool
    """Whether plasticity = "none" leaves its elasticity alone."""
    plasticity_cites: list[str]
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
    has_change: bool
    damps: bool
    has_bounded_energy: bool

def laws() -> list[Law]: ...
def transfers() -> list[Transfer]: ...
def splines() -> list[Choice]: ...

displacement_limit: float
"""Longest way of a particle in a step [cells]."""
volume_ratio_limit: float
"""Smallest det(I + dt grad v) of a particle in a step [1]."""
geometry: Geometry
f32: Precision
f64: Precision

def build_info() -> dict[str, Any]: ...
def set_threads(n: int) -> None: ...
def threads() -> int: ...
