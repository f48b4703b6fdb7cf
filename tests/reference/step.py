"""One explicit step in the ten stages of Stomakhin et al. 2013, section 4.1.

The dense grid covers the particles' bounding box: `Nodes.mass[i, j, k]` belongs to the node at
(low + (i, j, k)) dx. Six transfers. Force from the gradients of the weights: "flip" is the paper's (PIC/FLIP
blend), "pic" its end alpha = 0. Force in the MLS form, Q = -dt V0 D^-1 tau: "apic" carries the affine
velocity C = B D^-1, "polypic" more modes of the velocity (with 1 mode it is "pic"), "asflip" is the blend
with C, whose positions follow the particle's own velocity only where snow separates, and "aflip" the blend of
both velocity and C.
"""

from dataclasses import dataclass

import numpy as np

from reference import contact, ice, modes, snow, splines
from reference.snow import Snow, column


@dataclass
class Particles:
    """Everything a particle carries; `law` holds its material, one value per particle or one for all."""

    x: np.ndarray  # position [m] (n, 3)
    v: np.ndarray  # velocity [m/s] (n, 3)
    C: np.ndarray  # affine velocity [1/s] (n, 3, 3), used by "apic", "polypic", "asflip" and "aflip"
    F_E: np.ndarray  # elastic deformation gradient [1] (n, 3, 3)
    J_P: np.ndarray  # determinant of the plastic part [1] (n,)
    m: np.ndarray  # mass [kg] (n,)
    V0: np.ndarray  # volume at rest [m3] (n,)
    law: Snow
    more: np.ndarray | None = None  # further modes of "polypic" [m/s], in cells (n, count - 4, 3)
    lift: np.ndarray | None = None  # how far it has left surfaces with play, along their normals [m] (n, 3)

    @classmethod
    def at_rest(cls, x, m, V0, law, v=None):
        n = len(x)
        return cls(
            x=np.array(x, dtype=float),
            v=np.zeros((n, 3)) if v is None else np.array(v, dtype=float),
            C=np.zeros((n, 3, 3)),
            F_E=np.tile(np.eye(3), (n, 1, 1)),
            J_P=np.ones(n),
            m=np.broadcast_to(np.asarray(m, dtype=float), n).copy(),
            V0=np.broadcast_to(np.asarray(V0, dtype=float), n).copy(),
            law=law,
        )


@dataclass
class Nodes:
    """A dense box of grid nodes, scratch for one step."""

    low: np.ndarray  # number of the first node (3,)
    mass: np.ndarray  # [kg] (nx, ny, nz)
    v: np.ndarray  # velocity before forces [m/s] (nx, ny, nz, 3)
    v_new: np.ndarray  # after forces, gravity and collisions
    x: np.ndarray  # node positions [m]


@dataclass(frozen=True)
class Method:
    """The choices that one run makes."""

    dx: float
    spline: str = "quadratic"
    transfer: str = "apic"
    alpha: float = 0.95
    gravity: tuple[float, float, float] = (0.0, 0.0, -9.81)
    damping: float | None = None  # alpha = exp(-damping dt) instead of `alpha` [1/s]
    modes: int = 8  # of "polypic"

    @property
    def count(self):
        """Velocity modes that a particle carries."""
        return {"pic": 1, "flip": 1, "apic": 4, "asflip": 4, "aflip": 4, "polypic": self.modes}[self.transfer]

    @property
    def affine(self):
        return self.count > 1

    def flip_share(self, dt):
        return self.alpha if self.damping is None else np.exp(-self.damping * dt)


def step(p, method, dt, bodies=(), first=False):
    """Advance the particles by dt [s] in place and return the grid used.

    `first` marks the first step of a run, which takes V0 from the grid's density.
    """
    ijk, w, grad_w = splines.stencil(method.spline, p.x, method.dx)
    s = modes.basis(w, ijk - p.x[:, None, :] / method.dx, method.count)
    nodes = rasterize(p, method, ijk, w, s)  # 1
    at = tuple(np.moveaxis(ijk - nodes.low, -1, 0))
    if first:
        p.V0 = volumes(p, method, nodes, at, w)  # 2
    f = forces(p, method, nodes, at, ijk, w, grad_w)  # 3
    update_grid_velocities(nodes, method, f, dt)  # 4
    collide_nodes(p, nodes, at, w, bodies, dt, method.dx)  # 5
    # 6: explicit, v^{n+1} = v*
    separates = ~contact.touches(p.x, bodies, method.dx)
    grad_v, J_trial = update_deformation(p, method, nodes, at, w, grad_w, dt)  # 7
    separates &= J_trial >= np.exp(-0.001)
    path = update_velocities(p, method, nodes, at, w, s, grad_v, dt, separates)  # 8
    p.v, path = contact.follow(p.v, path, p.x, bodies, dt, method.dx)  # 9
    before, p.x = p.x, p.x + dt * path  # 10
    if method.transfer == "polypic" and method.count == 27:
        p.more = modes.moved(p.more, *(square_norms(method, x) for x in (before, p.x)))
    return nodes


def square_norms(method, x):
    """Return the norms of the square modes at positions x [m], axis by axis (n, 3)."""
    spline = method.spline
    place = (splines.OFFSET[spline], splines.NODES[spline], x / method.dx)
    return modes.square_norm(lambda r: splines.value(spline, r), *place)


def scatter(nodes, at, values):
    """Sum values (n, K, ...) of particle-node pairs onto the grid."""
    out = np.zeros(nodes.mass.shape + values.shape[2:])
    np.add.at(out, at, values)
    return out


def rasterize(p, method, ijk, w, s):
    """Stage 1. m_i = sum w m_p and v_i = sum w m_p v_p(x_i) / m_i with all that a particle knows of v_p."""
    low, high = ijk.min((0, 1)), ijk.max((0, 1))
    shape = tuple(high - low + 1)
    grid_x = method.dx * (low + np.stack(np.meshgrid(*map(np.arange, shape), indexing="ij"), -1))
    nodes = Nodes(low, np.zeros(shape), np.zeros((*shape, 3)), np.zeros((*shape, 3)), grid_x)
    at = tuple(np.moveaxis(ijk - low, -1, 0))
    nodes.mass = scatter(nodes, at, w * p.m[:, None])
    c = np.concatenate([p.v[:, None], method.dx * np.swapaxes(p.C, 1, 2), rest(p, method)], axis=1)
    v_ip = modes.field(s, c[:, : method.count])
    momentum = scatter(nodes, at, (w * p.m[:, None])[..., None] * v_ip)
    nodes.v = momentum / np.where(nodes.mass > 0, nodes.mass, 1.0)[..., None]
    return nodes


def rest(p, method):
    """The modes beyond v and C, none at first."""
    shape = (len(p.x), max(method.count - 4, 0), 3)
    return np.zeros(shape) if p.more is None or p.more.shape != shape else p.more


def volumes(p, method, nodes, at, w):
    """Stage 2. V0_p = m_p / rho_p with rho_p = sum_i w m_i / dx^3."""
    return p.m * method.dx**3 / (w * nodes.mass[at]).sum(1)


def forces(p, method, nodes, at, ijk, w, grad_w):
    """Stage 3. f_i = -sum V0 tau grad_w; in the MLS form grad_w is replaced by w D^-1 (x_i - x_p)."""
    if method.affine:
        D = splines.MOMENT[method.spline] * method.dx**2
        grad_w = w[..., None] * (method.dx * ijk - p.x[:, None, :]) / D
    pressure = ice.volume(p) * ice.pressure(ice.beyond(p))
    tau = snow.kirchhoff(p.F_E, p.J_P, p.law) - column(pressure) * np.eye(3)
    return -scatter(nodes, at, np.einsum("p,pab,pkb->pka", p.V0, tau, grad_w))


def update_grid_velocities(nodes, method, f, dt):
    """Stage 4. v* = v + dt (f / m + g) where there is mass."""
    has_mass = nodes.mass > 0
    nodes.v_new = nodes.v.copy()
    acceleration = f[has_mass] / nodes.mass[has_mass, None] + np.asarray(method.gravity)
    nodes.v_new[has_mass] += dt * acceleration


def collide_nodes(p, nodes, at, w, bodies, dt, dx):
    """Stage 5. The contact law at every node inside a collider, and what it makes of the particles' lift."""
    lift = np.zeros_like(p.x) if p.lift is None else p.lift
    mass = np.where(nodes.mass > 0, nodes.mass, 1.0)[..., None]
    s = scatter(nodes, at, (w * p.m[:, None])[..., None] * lift[:, None]) / mass
    s_new = np.zeros_like(s)
    some = nodes.mass > 0
    nodes.v_new[some], s_new[some] = contact.respond(
        nodes.v_new[some], s[some], nodes.x[some], bodies, dt, dx
    )
    change = np.where(some[..., None], s_new - s, 0.0)
    p.lift = lift + np.einsum("pk,pka->pa", w, change[at])


def update_deformation(p, method, nodes, at, w, grad_w, dt):
    """Stage 7. F_E trial = (I + dt grad v) F_E, then the return map.

    Return grad v (the new C, if there is one) and the determinant of the trial.
    """
    v_i = nodes.v_new[at]
    classic = np.einsum("pka,pkb->pab", v_i, grad_w)
    grad_v = affine(p, method, nodes, at, w, v_i) if method.affine else classic
    trial = (np.eye(3) + dt * grad_v) @ p.F_E
    p.F_E, p.J_P = snow.return_map(trial, p.J_P, p.law)
    return grad_v, np.linalg.det(trial)


def affine(p, method, nodes, at, w, v_i):
    """C = B D^-1 with B = sum w v_i (x_i - x_p)^T [1/s]."""
    B = np.einsum("pk,pka,pkb->pab", w, v_i, nodes.x[at] - p.x[:, None, :])
    return B / (splines.MOMENT[method.spline] * method.dx**2)


def update_velocities(p, method, nodes, at, w, s, grad_v, dt, separates):
    """Stage 8. PIC, or PIC + alpha (v_p - sum w v_i^n), the FLIP blend; C and further modes beside it.

    In "aflip" the blend of C is the same: its PIC is grad v, and sum w v_i^n (x_i - x_p)^T D^-1 what it had.
    In "asflip" C is that PIC, shortened to the energy that the blends of PIC and of increments would have.
    Return the velocity that positions follow: for "asflip" that of PIC where snow does not separate.
    """
    pic = np.einsum("pk,pka->pa", w, nodes.v_new[at])
    own = np.zeros_like(pic)
    if method.transfer in ("flip", "asflip", "aflip"):
        own = method.flip_share(dt) * (p.v - np.einsum("pk,pka->pa", w, nodes.v[at]))
    if method.transfer == "polypic":
        p.more = modes.coefficients(w, s, nodes.v_new[at])[:, 4:]
    if method.affine:
        share = method.flip_share(dt) if method.transfer in ("aflip", "asflip") else 0.0
        own_C = p.C - affine(p, method, nodes, at, w, nodes.v[at])
        p.C = scaled_down(grad_v, own_C, share) if method.transfer == "asflip" else grad_v + share * own_C
    p.v = pic + own
    return pic + own * separates[:, None] if method.transfer == "asflip" else p.v


def scaled_down(grad_v, own_C, share):
    """C of "asflip": grad v, no longer than ((1 - alpha) |grad v|^2 + alpha |C + dC|^2)^1/2."""
    whole, kept = ((A**2).sum((1, 2)) for A in (grad_v, grad_v + own_C))
    allowed = (1 - share) * whole + share * kept
    s = np.sqrt(np.minimum(1.0, allowed / np.where(whole > 0, whole, 1.0)))
    return np.where(whole > 0, s, 1.0)[:, None, None] * grad_v


def kinetic(p, method):
    """Return 1/2 sum m |v|^2 and 1/2 sum m sum_r <s_r, s_r> |c_r|^2 of all modes but the first [J]."""
    ijk, w, _ = splines.stencil(method.spline, p.x, method.dx)
    c = np.concatenate([method.dx * np.swapaxes(p.C, 1, 2), rest(p, method)], axis=1)[:, : method.count - 1]
    s = modes.basis(w, ijk - p.x[:, None, :] / method.dx, method.count)
    own = modes.norms(w, s).astype(float)[:, 1:, None] * c**2
    return 0.5 * p.m @ (p.v**2).sum(1), 0.5 * p.m @ own.sum((1, 2))


def momentum(p):
    """sum m v [kg m/s] (3,)."""
    return (p.m[:, None] * p.v).sum(0)


def angular_momentum(p, method):
    """sum x cross m v [kg m2/s] (3,), and the part that an affine velocity carries, B = C D.

    Further modes carry none: they are orthogonal to the linear ones.
    """
    L = np.cross(p.x, p.m[:, None] * p.v).sum(0)
    if method.affine:
        B = p.C * (splines.MOMENT[method.spline] * method.dx**2)
        axial = np.stack([B[:, 2, 1] - B[:, 1, 2], B[:, 0, 2] - B[:, 2, 0], B[:, 1, 0] - B[:, 0, 1]], -1)
        L = L + (p.m[:, None] * axial).sum(0)
    return L


__all__ = ["Method", "Nodes", "Particles", "angular_momentum", "kinetic", "momentum", "step"]
