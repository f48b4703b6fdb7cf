"""Collision objects of section 8: a signed distance phi, its normal, a rigid motion, and a contact law."""

from dataclasses import dataclass, field

import numpy as np


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

    def distance(self, x):
        """Return phi [m] (n,), negative inside, and the normal n = grad phi (n, 3)."""
        phi, n = SHAPES[self.shape]((x - self.position) @ self.rotation, self.size)
        return phi, n @ self.rotation.T

    def velocity_at(self, x):
        return self.velocity + np.cross(self.omega, x - self.position)


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


SHAPES = {"plane": plane, "box": box, "sphere": sphere, "cylinder": cylinder}


def respond(v, x, bodies, skin=0.0):
    """Return the velocities after contact of points at x with velocity v (n, 3), one body after another.

    A body holds what is no more than `skin` [m] outside.
    """
    v = v.copy()
    for body in bodies:
        phi, n = body.distance(x)
        touching = phi <= skin
        if touching.any():
            v_co = body.velocity_at(x[touching])
            v[touching] = v_co + relative(v[touching] - v_co, n[touching], body.mode, body.mu_c)
    return v


def touches(x, bodies, skin=0.0):
    """Whether some body holds the point (n,)."""
    held = np.zeros(len(x), bool)
    for body in bodies:
        held |= body.distance(x)[0] <= skin
    return held


def relative(v_rel, n, mode, mu_c):
    """Apply one contact law to velocities relative to the body.

    sticky: v_rel = 0.
    separate: only if v_n < 0. slip: v_n = 0 always, so the snow never lifts off.
    Coulomb, when pressed (v_n < 0): the tangential part loses mu_c |v_n|, and stops if it has less.
    """
    if mode == "sticky":
        return np.zeros_like(v_rel)
    v_n = (v_rel * n).sum(-1, keepdims=True)
    v_t = v_rel - v_n * n
    speed = np.linalg.norm(v_t, axis=-1, keepdims=True)
    grip = mu_c * np.maximum(-v_n, 0)
    slid = v_t * np.where(speed > grip, 1 - grip / np.maximum(speed, 1e-300), 0.0)
    return slid if mode == "slip" else np.where(v_n < 0, slid, v_rel)
