"""Types of the compiled core; `f32` and `f64` are the same interface in two precisions."""

from typing import Any, Literal, Protocol

import numpy as np
from numpy.typing import NDArray

Reals = NDArray[np.floating[Any]]
Array64 = NDArray[np.float64]

class Report:
    wave: float
    speed: float
    fastest: float
    strain_rate: float
    compression_rate: float
    max_displacement: float
    min_volume_ratio: float
    finite: bool
    drifted: bool
    offending_id: int
    rejected: bool

class GridReport:
    speed: float
    max_velocity_difference: float
    max_velocity_change: float
    finite: bool

class Totals:
    mass: float
    momentum: list[float]
    kinetic: float
    affine: float
    elastic: float
    potential: float

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
    dx: float
    more_modes: int
    keeps_C: bool
    """Whether particles carry an affine velocity."""

    def max_compression(self, strongest: float) -> float:
        """Return how far one step may compress any of the snows, -dt tr grad v [1]; see `Law`."""
    def add_snow(self, law: str, plasticity: str, constants: dict[str, float]) -> None: ...
    def add_solid(self, shape: str, half: Array64, mode: str, mu_c: float) -> None: ...
    def add_mesh_solid(self, grid: SdfGrid, mode: str, mu_c: float, thickness: float = ...) -> None: ...
    def add_terrain_solid(self, field: HeightField, mode: str, mu_c: float) -> None: ...
    def surface(self, index: int, points: Array64) -> tuple[Array64, Array64]: ...
    def place_solid(
        self, index: int, centre: Array64, rotation: Array64, velocity: Array64, omega: Array64
    ) -> None: ...
    def make_dynamic(self, index: int) -> None: ...
    def set_body_dynamics(self, mobility: Array64, free: Array64) -> None: ...

class State(Protocol):
    count: int
    @property
    def bytes(self) -> int: ...
    @property
    def x(self) -> Reals: ...
    @property
    def v(self) -> Reals: ...
    @property
    def C(self) -> Reals: ...
    @property
    def modes(self) -> Reals: ...
    @property
    def F_E(self) -> Reals: ...
    @property
    def tau(self) -> Reals: ...
    @property
    def J_P(self) -> Reals: ...
    @property
    def m(self) -> Reals: ...
    @property
    def V0(self) -> Reals: ...
    @property
    def stiffness(self) -> Reals: ...
    @property
    def strength(self) -> Reals: ...
    @property
    def material(self) -> NDArray[np.uint16]: ...
    @property
    def id(self) -> NDArray[np.uint32]: ...

class Grid(Protocol):
    @property
    def current(self) -> bool: ...
    @property
    def blocks(self) -> int: ...
    @property
    def homes(self) -> int: ...
    @property
    def bytes(self) -> int: ...
    def take_exchanged(self, solids: int, /) -> Array64: ...
    def nodes(self) -> tuple[NDArray[np.int32], Reals, Reals]: ...

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
        flip_damping: float = -1.0,
    ) -> _Model: ...
    def State(self, count: int, more_modes: int = 0) -> _State: ...
    def Grid(self) -> _Grid: ...
    def sort(self, model: _Model, state: _State, grid: _Grid, /) -> None: ...
    def refresh(self, model: _Model, state: _State, /) -> Report: ...
    def p2g(self, model: _Model, state: _State, grid: _Grid, dt: float, /) -> None: ...
    def volumes_from_grid(self, model: _Model, state: _State, grid: _Grid, /) -> None: ...
    def grid_update(self, model: _Model, grid: _Grid, dt: float, /) -> GridReport: ...
    def g2p(self, model: _Model, state: _State, grid: _Grid, dt: float, commit: bool = True) -> Report: ...
    def totals(self, model: _Model, state: _State, /) -> Totals: ...
    def first_not_finite(self, state: _State, /) -> int: ...
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
volume_ratio_limit: float
geometry: Geometry
f32: Precision
f64: Precision

def build_info() -> dict[str, Any]: ...
def set_threads(n: int) -> None: ...
def threads() -> int: ...
