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
    press_rate: float
    leap: float
    squeeze: float
    finite: bool
    drifted: bool
    culprit: int
    refused: bool

class Ahead:
    speed: float
    spread: float
    change: float
    finite: bool

class Totals:
    mass: float
    momentum: list[float]
    kinetic: float
    affine: float
    elastic: float
    potential: float

class Model(Protocol):
    dx: float
    more_modes: int
    def add_snow(self, law: str, plasticity: str, constants: dict[str, float]) -> None: ...
    def add_solid(self, shape: str, half: Array64, mode: str, mu_c: float) -> None: ...
    def place_solid(
        self, index: int, centre: Array64, rotation: Array64, velocity: Array64, omega: Array64
    ) -> None: ...

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
    def grid_update(self, model: _Model, grid: _Grid, dt: float, /) -> Ahead: ...
    def g2p(self, model: _Model, state: _State, grid: _Grid, dt: float, commit: bool = True) -> Report: ...
    def totals(self, model: _Model, state: _State, /) -> Totals: ...
    def first_not_finite(self, state: _State, /) -> int: ...
    def svd(self, F: Reals) -> tuple[Reals, Reals, Reals]: ...
    def weights(
        self, spline: Literal["quadratic", "cubic"], x: Reals
    ) -> tuple[NDArray[np.int32], Reals, Reals]: ...
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

most_leap: float
least_squeeze: float
f32: Precision
f64: Precision

def build_info() -> dict[str, Any]: ...
def set_threads(n: int) -> None: ...
def threads() -> int: ...
