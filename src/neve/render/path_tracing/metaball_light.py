"""Light in metaballs as in 1997: along the ray, once scattered from the sun, twice forward, and from the sky.

L = int e^{-tau(s)} sigma_s rho [p(theta) E_sun (e^{-tau_sun} + S2) + L_sky] ds, with rho the field of the
balls, p the phase function of Cornette and Shanks, S2 the light that comes scattered once already, by the
snow within a few cells (the "reference pattern"), and L_sky a sum over directions of the upper half. Light
that is scattered more often is not followed: `HIGHER` stands for it.

Source: Nishita, Iwasaki, Dobashi and Nakamae 1997 [M]; our quadrature.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from neve.render.lighting import sun_color, sun_direction
from neve.render.path_tracing.daylight import sky_toward
from neve.render.path_tracing.optics import cornette_shanks
from neve.surface.grains import loneliness
from neve.surface.metaballs import RADIUS, Metaballs

if TYPE_CHECKING:
    from neve._surface import Field
    from neve.render.path_tracing.lens import Lens
    from neve.render.path_tracing.looks import Medium
    from neve.render.path_tracing.tracer import Layers
    from neve.scene.schema.scene import Light

Array = NDArray[np.float64]
Floats = NDArray[np.float32]

G = 0.5
"""Mean forwardness of a scattering (the g of Cornette and Shanks)."""
HIGHER = 5.0
"""Light of all orders over that of the first two, in thick snow: what the exposure makes up for."""
PATTERN = 2
"""Cells that the pattern of the second scattering reaches."""
SKY = 14
"""Directions from which the sky's light is taken."""
MOST = 12_000_000
"""Cells of the box of lights; they are made larger until it has no more."""
FINE, COARSE = 0.4, 0.6
"""Cells of the density, and of the light, in radii of a ball."""


@dataclass(frozen=True)
class Lit:
    """Hold the light in a box of cells.

    field: the density, 1 in packed snow. corner (3,) and cell [m]: of the box. sun (nx, ny, nz): share of the
    sun's light with that scattered once; sky (nx, ny, nz, 3): light of the sky times the phase function
    """

    field: Field
    corner: Array
    cell: float
    sun: Floats
    sky: Floats


def together(x: NDArray[Any], spacing: float) -> NDArray[Any]:
    """Return the particles (m, 3) of `x` (n, 3) [m] that fit in one box of cells of light.

    They are all of them, unless crumbs that have flown far away would make its cells larger: then the lone
    ones outside the box of all others are left out.
    """
    if not len(x) or _cells(x, RADIUS * spacing) <= MOST:
        return x
    others = x[loneliness(x, spacing) < 1.0]
    if not len(others):
        return x
    return np.asarray(x[((x >= others.min(axis=0)) & (x <= others.max(axis=0))).all(axis=1)])


def _cells(x: NDArray[Any], radius: float) -> float:
    """Return how many of the smallest cells the box of balls at `x` (n, 3) [m] would have."""
    size = (x.max(axis=0) - x.min(axis=0)).astype(np.float64) + 2.0 * radius
    return float(np.prod(size / (COARSE * radius)))


def lit(balls: Metaballs, medium: Medium, light: Light, eye: Array) -> Lit:
    """Return the light in balls of density seen from `eye` (3,) [m]. medium: packed snow."""
    extinction = medium.extinction
    centres = balls.centres
    low = centres.min(axis=0) - balls.radius
    size = centres.max(axis=0) + balls.radius - low
    cell = max(COARSE * balls.radius, float(np.cbrt(np.prod(size.astype(np.float64)) / MOST)))
    field = balls.field(FINE * balls.radius)
    shape = tuple(int(n) for n in np.ceil(size / cell).astype(int) + 1)
    places = [low[k] + cell * (np.arange(shape[k]) + 0.5) for k in range(3)]
    grid = np.stack(np.meshgrid(*places, indexing="ij"), axis=-1).reshape(-1, 3).astype(np.float32)
    rho = field.sample(grid)
    full = np.flatnonzero(rho > 1e-4)
    reach = float(np.linalg.norm(size))
    sun = np.zeros(len(grid), np.float32)
    toward = np.asarray(sun_direction(light))
    sun[full] = transmitted(field, grid[full], toward, extinction, cell, reach)
    once = (rho * sun).reshape(shape)
    sun = sun.reshape(shape) + _second(once, toward, medium, cell)
    sky = np.zeros((len(grid), 3), np.float32)
    view = eye - grid[full]
    view /= np.linalg.norm(view, axis=1, keepdims=True)
    for direction, solid_angle in _directions():
        share = transmitted(field, grid[full], direction, extinction, 2.0 * cell, reach)
        phase = cornette_shanks(-(view @ direction), G)
        sky[full] += (share * phase)[:, None] * (sky_toward(light, direction[None])[0] * solid_angle).astype(
            np.float32
        )
    return Lit(field, low.astype(np.float64), cell, sun.astype(np.float32), sky.reshape(*shape, 3))


def transmitted(
    field: Field, places: Floats, direction: Array, extinction: float, step: float, reach: float
) -> Floats:
    """Return the share (n,) of light from `direction` at places (n, 3): exp(-sigma_t int rho ds)."""
    depth = np.zeros(len(places), np.float32)
    unit = direction.astype(np.float32)
    for k in range(int(reach / step) + 1):
        now = np.flatnonzero(depth < 8.0)
        if not len(now):
            break
        depth[now] += np.float32(extinction * step) * field.sample(
            places[now] + unit * np.float32((k + 0.5) * step)
        )
    return np.asarray(np.exp(-depth))


def composed(found: Lit, medium: Medium, light: Light, lens: Lens, behind: Layers) -> Floats:
    """Return the picture (h, w, 3), linear: snow before what lies behind, whose light it takes away."""
    right, up, forward = lens.axes
    rows, columns = np.mgrid[0 : lens.height, 0 : lens.width] + 0.5
    a, b = (columns - 0.5 * lens.width) / lens.focal, (0.5 * lens.height - rows) / lens.focal
    rays = forward + a[..., None] * right + b[..., None] * up
    rays = (rays / np.linalg.norm(rays, axis=-1, keepdims=True)).reshape(-1, 3)
    assert behind.depth is not None
    assert behind.sky is not None
    depth = np.where(behind.depth > 0, behind.depth, np.inf).ravel().astype(np.float64)
    near, far = _clipped(found, lens.eye, rays)
    hit = np.flatnonzero(np.minimum(far, depth) > near)
    out, left = np.zeros((len(rays), 3)), np.ones(len(rays))
    light_in, through = _marched(
        found, medium, light, lens.eye, rays[hit], near[hit], np.minimum(far, depth)[hit]
    )
    out[hit], left[hit] = HIGHER * light_in, through
    solid = np.flatnonzero(np.isfinite(depth) & (depth < 50.0 * lens.distance))
    sun = np.ones(len(rays))
    ground = (lens.eye + rays[solid] * depth[solid, None]).astype(np.float32)
    reach = float(np.linalg.norm(np.array(found.sun.shape) * found.cell)) + 2.0 * lens.distance
    sun[solid] = transmitted(
        found.field, ground, np.asarray(sun_direction(light)), medium.extinction, found.cell, reach
    )
    back = behind.sun.reshape(-1, 3) * sun[:, None] + behind.sky.reshape(-1, 3)
    return (out + left[:, None] * back).reshape(lens.height, lens.width, 3).astype(np.float32)


def _marched(
    found: Lit, medium: Medium, light: Light, eye: Array, rays: Array, near: Array, far: Array
) -> tuple[Array, Array]:
    """Return the light scattered into rays (n, 3) between near and far [m] and the share that passes (n,)."""
    from scipy.ndimage import map_coordinates

    toward, albedo = np.asarray(sun_direction(light)), np.asarray(medium.albedo)
    phase = cornette_shanks(rays @ toward, G)
    sun = np.asarray(sun_color(light)) * math.pi
    total, left = np.zeros((len(rays), 3)), np.ones(len(rays))
    step = found.field.cell_size
    # Rays begin at different places, or the steps show as rings.
    shift = (0.5 + 0.618034 * np.arange(len(rays))) % 1.0
    for k in range(int(np.max(far - near, initial=0.0) / step) + 1):
        at = near + (k + shift) * step
        now = np.flatnonzero((at < far) & (left > 3e-3))
        if not len(now):
            continue
        x = eye + rays[now] * at[now, None]
        rho = found.field.sample(x.astype(np.float32))
        some = rho > 1e-3
        now, x, rho = now[some], x[some], rho[some].astype(np.float64)
        if not len(now):
            continue
        q = ((x - found.corner) / found.cell - 0.5).T
        direct = map_coordinates(found.sun, q, order=1, mode="nearest", prefilter=False)
        sky = np.stack(
            [
                map_coordinates(found.sky[..., c], q, order=1, mode="nearest", prefilter=False)
                for c in range(3)
            ],
            axis=1,
        )
        passed = np.exp(-medium.extinction * step * rho)
        source = albedo * (phase[now, None] * direct[:, None] * sun + sky)
        total[now] += (left[now] * (1.0 - passed))[:, None] * source
        left[now] *= passed
    return total, left


def _second(once: Floats, toward: Array, medium: Medium, cell: float) -> Floats:
    """Return the light that arrives scattered once, in units of the sun's, from cells around.

    S2(x) = sum_q sigma_s rho T_sun (x + q) p(cos) e^{-sigma_t |q| / 2} cell^3 / |q|^2, with the angle between
    the sun's rays and the way from x + q to x; half of the way is snow, as it is where light comes from.
    """
    from scipy.ndimage import correlate

    span = np.arange(-PATTERN, PATTERN + 1)
    q = np.stack(np.meshgrid(span, span, span, indexing="ij"), axis=-1) * cell
    far = np.linalg.norm(q, axis=-1)
    with np.errstate(divide="ignore", invalid="ignore"):
        cosine = (q @ toward) / far  # light travels along -toward, and from x + q to x along -q
        weight = cornette_shanks(cosine, G) * np.exp(-0.5 * medium.extinction * far) * cell**3 / far**2
    weight[far == 0] = 0.0
    scattering = medium.extinction * sum(medium.albedo) / 3.0
    # What the sum cannot resolve, the cell itself, is a ball of the same volume around the place.
    own = 1.0 - math.exp(-scattering * cell * (3.0 / (4.0 * math.pi)) ** (1.0 / 3.0))
    total = correlate(once, (scattering * weight).astype(np.float32), mode="constant")
    return np.asarray(np.minimum(total + own * once, 3.0), np.float32)


def _directions() -> list[tuple[Array, float]]:
    """Return directions spread over the upper half and the solid angle of each [sr]."""
    k = np.arange(SKY) + 0.5
    z, turn = 1.0 - k / SKY, math.pi * (1.0 + math.sqrt(5.0)) * k
    flat = np.sqrt(1.0 - z * z)
    found = np.stack([flat * np.cos(turn), flat * np.sin(turn), z], axis=1)
    return [(direction, 2.0 * math.pi / SKY) for direction in found]


def _clipped(found: Lit, eye: Array, rays: Array) -> tuple[Array, Array]:
    """Return where rays (n, 3) from `eye` enter and leave the box [m]."""
    high = found.corner + np.array(found.sun.shape) * found.cell
    safe = np.where(np.abs(rays) > 1e-9, rays, 1e-9)
    a, b = (found.corner - eye) / safe, (high - eye) / safe
    near = np.minimum(a, b).max(axis=1)
    return np.maximum(near, 0.0), np.maximum(a, b).min(axis=1)


def metaballs_before(behind: Layers, balls: Metaballs, medium: Medium, light: Light, lens: Lens) -> Layers:
    """Return the layers of a picture with metaballs before what lies behind; medium: packed snow."""
    seen = behind.sun
    if len(balls.centres):
        seen = composed(lit(balls, medium, light, lens.eye), medium, light, lens, behind)
    elif behind.sky is not None:
        seen = seen + behind.sky
    return replace(behind, sun=seen, sky=None, albedo=None, normal=None, snow=None)
