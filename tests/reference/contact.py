"""Collision objects of section 8: a signed distance phi, its normal, a rigid motion, and a contact law."""

from dataclasses import dataclass, field

import numpy as np

SKIN = 1e-4  # share of a cell within which a body holds a point: a wall on a row of nodes holds them
STRIDE = 0.05  # cells: least step of the search close to a surface
PLAY = 0.1  # cells by which snow may leave a surface with mode slip and friction
PUSH = 0.1  # cells that a particle inside a body is moved towards its surface in a step


@dataclass(frozen=True)
class Body:
    """A collider at one instant.

    Its own frame sits at its centre; a plane's sits at its point, with local z as the normal.
    """

    shape: str  # "plane" | "box" | "sphere" | "cylinder" (axis local z)
    mode: str = "separate"  # "separate" | "slip" | "sticky"
    mu_c: float = 0.5
    size: tuple[float, ...] = ()  # box: three edges; sphere: radius; cylinder: radius, height [m]
    position: np.ndarray = field(default_factory=lambda: np.zeros(3))
    rotation: np.ndarray = field(default_factory=lambda: np.eye(3))
    velocity: np.ndarray = field(default_factory=lambda: np.zeros(3))
    omega: np.ndarray = field(default_factory=lambda: np.zeros(3))
    belt: np.ndarray = field(default_factory=lambda: np.zeros(3))  # of plane and box: of the surface past it

    def distance(self, x):
        """Return phi [m] (n,), negative inside, and the normal n = grad phi (n, 3)."""
        phi, n = SHAPES[self.shape]((x - self.position) @ self.rotation, self.size)
        return phi, n @ self.rotation.T

    def velocity_at(self, x):
        return self.velocity + np.cross(self.omega, x - self.position)

    def surface_velocity_at(self, x, n):
        return self.velocity_at(x) + self.belt - (n @ self.belt)[:, None] * n

    @property
    def has_play(self):
        return self.mode == "slip" and self.mu_c > 0

    def margin(self, dx):
        """How far outside nodes count as held: a layer of them, however thin the body is [m]."""
        thickness = {
            "plane": lambda size: np.inf,
            "box": min,
            "sphere": lambda size: 2 * size[0],
            "cylinder": lambda size: min(2 * size[0], size[1]),
        }[self.shape](self.size)
        return max(0.0, (dx - thickness) / 2)


def plane(p, size):
    return p[:, 2], np.broadcast_to([0.0, 0.0, 1.0], p.shape)


def sphere(p, size):
    r = np.linalg.norm(p, axis=-1)
    return r - size[0], p / np.maximum(r, 1e-300)[:, None]


def box(p, size):
    q = np.abs(p) - np.asarray(size) / 2  # distance beyond each pair of faces
    return beyond(q, np.sign(p)[..., None] * np.eye(3))


def cylinder(p, size):
    radius, height = size
    r = np.hypot(p[:, 0], p[:, 1])
    outward = np.stack([p[:, 0], p[:, 1], 0 * r], -1) / np.maximum(r, 1e-300)[:, None]
    up = np.sign(p[:, 2])[:, None] * np.array([0.0, 0.0, 1.0])
    q = np.stack([r - radius, np.abs(p[:, 2]) - height / 2], -1)
    return beyond(q, np.stack([outward, up], axis=1))


def beyond(q, axes):
    """Combine face distances q (n, k) along unit axes (n, k, 3).

    Inside the nearest face counts, outside the nearest point.
    """
    inside = q.max(-1)
    out = np.maximum(q, 0)
    outside = np.linalg.norm(out, axis=-1)
    nearest = np.take_along_axis(axes, q.argmax(-1)[:, None, None], axis=1)[:, 0]
    to_point = np.einsum("nk,nkd->nd", out, axes) / np.maximum(outside, 1e-300)[:, None]
    is_in = inside <= 0
    return np.where(is_in, inside, outside), np.where(is_in[:, None], nearest, to_point)


def half_a_step_on(body, x, n, v_rel, dt):
    """Where the body of normal n at x faces snow that moves with v_rel, dt / 2 later.

    Returns its normal there, over its part along n (n, 3), and the speed along it that the surface there has
    gained by turning (n,). dt: [s] (n, 1). A face that is flat has n, and so has one across an edge.
    """
    if body.shape in ("plane", "box"):
        return n, np.zeros(len(n))
    v_t = v_rel - (v_rel * n).sum(-1, keepdims=True) * n
    there = body.distance(x + dt / 2 * v_t)[1] + dt / 2 * np.cross(body.omega, n)
    cosine = (there * n).sum(-1, keepdims=True)
    edge = cosine <= 0.9
    there = there / np.where(edge, 1, cosine)
    v_of_centre = v_rel + np.cross(body.omega, x - body.position)
    gained = (dt / 2 * np.cross(body.omega, v_of_centre) * there).sum(-1, keepdims=True)
    return np.where(edge, n, there), np.where(edge, 0, gained)[:, 0]


SHAPES = {"plane": plane, "box": box, "sphere": sphere, "cylinder": cylinder}


def respond(v, lift, x, bodies, dt, dx):
    """Return velocities and lifts after contact of nodes at x with velocity v (n, 3), one body after another.

    A body holds what is no more than SKIN dx and its margin outside. lift: how far snow has left surfaces
    with play, along their normals [m] (n, 3).
    """
    v, lift = v.copy(), lift.copy()
    for body in bodies:
        phi, n = body.distance(x)
        on = phi <= SKIN * dx + body.margin(dx)
        n = n[on]
        v_co = body.surface_velocity_at(x[on], n)
        ahead = half_a_step_on(body, x[on], n, v[on] - v_co, np.full((on.sum(), 1), dt))
        if not body.has_play:
            v[on] = v_co + relative(v[on] - v_co, n, ahead, body.mode, body.mu_c)
            continue
        left, most = (lift[on] * n).sum(-1), PLAY * dx
        s = np.clip(left, 0, most)
        v[on] = v_co + relative(v[on] - v_co, n, ahead, "slip", body.mu_c, (-s / dt, (most - s) / dt))
        now = np.clip(s + dt * (((v[on] - v_co) * ahead[0]).sum(-1) - ahead[1]), 0, most)
        lift[on] += (now - left)[:, None] * n
    return v, lift


def turned(v, x, n, ahead, body):
    """Return velocities v (n, 3) of particles at x after contact with a surface of normal n of the body.

    ahead: of half_a_step_on().

    What leaves a surface with play is held by the nodes.
    """
    v_co = body.surface_velocity_at(x, n)
    return v_co + relative(v - v_co, n, ahead, "separate" if body.has_play else body.mode, body.mu_c)


def follow(v, path, x, bodies, dt, dx):
    """Return velocities and mean velocities on the way of particles at x that would move along `path` for dt.

    A particle in a body's skin is met at the start, and brought up to PUSH dx nearer to the surface per step
    if it is inside; one that would come into the skin is met there and turned for the rest of the step.
    """
    v, path = v.copy(), path.copy()
    for body in bodies:
        phi, n = body.distance(x)
        way = (path - body.velocity_at(x)) * dt
        for p in range(len(x)):
            at, normal = (0.0, n[p]) if phi[p] <= SKIN * dx else first_touch(body, x[p], way[p], dx)
            if at is None:
                continue
            place, normal = (x[p] + at * way[p])[None], normal[None]
            v_rel, left = path[p : p + 1] - body.velocity_at(place), np.full((1, 1), (1 - at) * dt)
            ahead = half_a_step_on(body, place, normal, v_rel, left)
            after, slid = (turned(u[p : p + 1], place, normal, ahead, body)[0] for u in (v, path))
            out = min(max(-phi[p], 0.0), PUSH * dx) if phi[p] <= SKIN * dx else 0.0
            v[p], path[p] = after, at * path[p] + (1 - at) * slid + normal[0] * out / dt
    return v, path


def first_touch(body, x, way, dx):
    """Return at which share of the step x, moving by `way` relative to the body, meets its skin; the normal.

    Sphere tracing: phi is never more than the way that is free; near the surface steps are STRIDE dx at
    least, and one that ends inside is cut back. (None, None) if the way ends before.
    """
    skin, length = SKIN * dx, max(np.linalg.norm(way), 1e-300)
    before, phi = 0.0, body.distance(x[None])[0][0]
    at = min((phi - skin / 2) / length, 1.0)
    if phi >= length + skin:
        return None, None
    for _ in range(16):
        near, n = (a[0] for a in body.distance((x + at * way)[None]))
        if near <= skin:
            share = min(max((phi - skin / 2) / max(phi - near, 1e-300), 0.0), 1.0)
            return before + (at - before) * share, n
        if at >= 1:
            return None, None
        before, phi = at, near
        at = min(at + max(phi - skin / 2, STRIDE * dx) / length, 1.0)
    return before, n


def touches(x, bodies, dx):
    """Whether some body has the point in its skin (n,)."""
    held = np.zeros(len(x), bool)
    for body in bodies:
        held |= body.distance(x)[0] <= SKIN * dx
    return held


def relative(v_rel, n, ahead, mode, mu_c, play=(0.0, 0.0)):
    """Apply one contact law to velocities relative to the body.

    v_n is the speed along the surface's normal half a step on, ahead of half_a_step_on(), but no more than
    an elastic bounce would take along n, and of its sign.

    sticky: v_rel = 0.
    separate: only if v_n < 0. slip: v_n ends within the play, so the snow never lifts off.
    Coulomb, when pressed (v_n < 0, or the lower end of the play): the tangential part loses mu_c times what
    v_n changes by, and stops if it has less.
    """
    least, most = (np.broadcast_to(a, len(v_rel))[:, None] for a in play)
    if mode == "sticky":
        return np.zeros_like(v_rel)
    bounce = 2 * (v_rel * n).sum(-1, keepdims=True)
    v_n = (v_rel * ahead[0]).sum(-1, keepdims=True) - ahead[1][:, None]
    v_n = np.clip(v_n, np.minimum(bounce, 0), np.maximum(bounce, 0))
    v_t = v_rel - v_n * n
    speed = np.linalg.norm(v_t, axis=-1, keepdims=True)
    grip = mu_c * np.maximum((least if mode == "slip" else 0.0) - v_n, 0)
    slid = v_t * np.where(speed > grip, 1 - grip / np.maximum(speed, 1e-300), 0.0)
    if mode == "slip":
        return slid + np.clip(v_n, least, most) * n
    return np.where(v_n < 0, slid, v_rel)
