"""Solids of several shells: whichever way each looks, however they touch, whatever was left open."""

import warnings

import meshes
import numpy as np
import pytest

from neve.geometry.inside import volume
from neve.geometry.sdf import of_triangles
from neve.geometry.triangles import tidied
from neve.sampling import fill
from neve.scene.schema.scene import Numerics, Source


def box(low, high, inward=False, other=False):
    """Corners and faces of a box; `other`: cut along the other diagonals; `inward`: inside out."""
    corners = np.array(
        [[x, y, z] for z in (low[2], high[2]) for y in (low[1], high[1]) for x in (low[0], high[0])]
    )
    faces = [
        t
        for a, b, c, d in meshes.SIDES
        for t in (((a, b, d), (b, c, d)) if other else ((a, b, c), (a, c, d)))
    ]
    faces = np.array(faces)
    return corners.astype(float), faces[:, ::-1] if inward else faces


def joined(*parts):
    """Corners and faces of all parts, each with corners of its own."""
    begin = np.cumsum([0, *(len(corners) for corners, _ in parts)])
    faces = [faces + n for (_, faces), n in zip(parts, begin, strict=False)]
    return np.concatenate([corners for corners, _ in parts]), np.concatenate(faces)


def volume_and_phi(surface, points):
    """The volume, and the signed distance at points."""
    return surface.volume, surface.tree.signed_distance(np.array(points, dtype=float))


UNIT, BESIDE, FAR = ((0, 0, 0), (1, 1, 1)), ((1, 0, 0), (2, 1, 1)), ((3, 0, 0), (4, 1, 0.5))
HOLLOW, PEBBLE = ((0.2, 0.2, 0.2), (0.8, 0.8, 0.8)), ((0.4, 0.4, 0.4), (0.6, 0.6, 0.6))
EDGE, CORNER = ((1, 1, 0), (2, 2, 1)), ((1, 1, 1), (2, 2, 2))
SHELLS = {  # boxes, volume, points inside, points outside
    "apart": ([UNIT, FAR], 1.5, [(0.5, 0.5, 0.5), (3.5, 0.5, 0.25)], [(2, 0.5, 0.5)]),
    "one face": (
        [UNIT, BESIDE],
        2.0,
        [(0.5, 0.5, 0.5), (1.5, 0.5, 0.5), (1.01, 0.5, 0.5)],
        [(2.1, 0.5, 0.5)],
    ),
    "one edge": ([UNIT, EDGE], 2.0, [(0.5, 0.5, 0.5), (1.5, 1.5, 0.5)], [(0.5, 1.5, 0.5), (1.5, 0.5, 0.5)]),
    "one corner": (
        [UNIT, CORNER],
        2.0,
        [(0.5, 0.5, 0.5), (1.5, 1.5, 1.5)],
        [(0.5, 1.5, 0.5), (1.5, 0.5, 1.5)],
    ),
    "half a face": (
        [UNIT, ((1, 0.5, 0), (2, 1.5, 1))],
        2.0,
        [(0.5, 0.5, 0.5), (1.5, 1, 0.5)],
        [(1.5, 0.2, 0.5)],
    ),
}


@pytest.mark.parametrize("turned", [(), (0,), (1,), (0, 1)], ids=["out", "first in", "second in", "both in"])
@pytest.mark.parametrize("other", [False, True], ids=["same diagonals", "other diagonals"])
@pytest.mark.parametrize("what", SHELLS)
def test_boxes_add_up(what, other, turned):
    """Boxes apart and touching, whichever is inside out: closed, their volumes, what is in and out."""
    boxes, volume, inside, outside = SHELLS[what]
    parts = [box(*b, inward=k in turned, other=other and k == 1) for k, b in enumerate(boxes)]
    surface = tidied(*joined(*parts))
    assert surface.open_edges == 0
    found, phi = volume_and_phi(surface, inside + outside)
    assert found == pytest.approx(volume)
    assert (phi[: len(inside)] < 0).all()
    assert (phi[len(inside) :] > 0).all()


@pytest.mark.parametrize(
    ("inward", "volume", "middle", "hollow"),
    [
        ((False, True), 1 - 0.216, 1, 1),
        ((True, False), 1 - 0.216, 1, 1),
        ((False, True, False), 1 - 0.216 + 0.008, -1, 1),
        ((True, False, True), 1 - 0.216 + 0.008, -1, 1),
        ((False, True, True), 1 - 0.216 + 0.008, -1, 1),
        ((True, False, False), 1 - 0.216 + 0.008, -1, 1),
    ],
)
def test_hollows_stay_hollow(inward, volume, middle, hollow):
    """A hollow, and a pebble in it, whichever way the whole and the pebble look; a box beside, inside out."""
    parts = [box(*b, inward=i) for b, i in zip((UNIT, HOLLOW, PEBBLE), inward, strict=False)]
    surface = tidied(*joined(*parts, box(*FAR, inward=not inward[0])))
    found, phi = volume_and_phi(
        surface, [(0.5, 0.5, 0.5), (0.3, 0.5, 0.5), (0.1, 0.5, 0.5), (3.5, 0.5, 0.25)]
    )
    assert found == pytest.approx(volume + 0.5)
    assert np.sign(phi).tolist() == [middle, hollow, -1, -1]


def bricks(shape, step=(1.0, 0.5, 0.25), shift=0.0, turned=0):
    """A wall of bricks, each a box of its own; every second row moved; every `turned`th inside out."""
    parts = []
    for n, (i, j, k) in enumerate(np.ndindex(*shape)):
        low = np.array([i + shift * (k % 2), j, k]) * step
        parts.append(
            box(low, low + step, inward=bool(turned) and n % turned == 0, other=n % 3 == 0 and shift > 0)
        )
    return parts


@pytest.mark.parametrize("turned", [0, 3])
@pytest.mark.parametrize("shift", [0.0, 0.5, 0.3])
def test_walls_of_bricks_are_solid(shift, turned):
    """3 x 3 x 4 bricks, in line and staggered, some inside out: V = 36 bricks; no gap between them."""
    surface = tidied(*joined(*bricks((3, 3, 4), shift=shift, turned=turned)))
    assert surface.open_edges == 0
    rng = np.random.default_rng(5)
    points = rng.uniform([0.6, 0.05, 0.05], [2.9, 1.45, 0.95], (200, 3))
    found, phi = volume_and_phi(surface, points)
    assert found == pytest.approx(36 * 0.125)
    assert (phi < 0).all()


def test_grid_of_distances_of_staggered_bricks():
    """What snow meets: negative throughout the wall, and 0.1 m from its sides phi is 0.1 m."""
    sdf = of_triangles(tidied(*joined(*bricks((2, 2, 2), shift=0.5))), 0.1, 0.2).sdf
    phi, _ = sdf.sample(np.random.default_rng(6).uniform([0.6, 0.1, 0.1], [1.9, 0.9, 0.4], (200, 3)))
    assert np.asarray(phi).max() < 0
    assert np.asarray(sdf.sample(np.array([[1.2, 0.5, 0.6], [1.2, 1.1, 0.3]]))[0]) == pytest.approx(
        0.1, abs=1e-6
    )


def test_bricks_in_line_have_no_walls():
    """Whole faces that two bricks share are gone: only the outside of the wall is left."""
    surface = tidied(*joined(*bricks((3, 3, 4))))
    assert surface.area == pytest.approx(2 * (3 * 1.5 + 3 * 1 + 1.5 * 1))
    assert surface.tree.distance(np.array([[1.5, 0.75, 0.5]]))[0] == pytest.approx(0.5)


def test_a_wall_inside_is_taken_out():
    """Two boxes as one surface that still has the face between them, once: 2 m3."""
    corners, faces = tidied(*joined(box(*UNIT), box(*BESIDE))).vertices, None
    surface = tidied(*joined(box(*UNIT), box(*BESIDE)))
    at = [
        int(np.flatnonzero((corners == p).all(axis=1))[0])
        for p in ((1, 0, 0), (1, 1, 0), (1, 1, 1), (1, 0, 1))
    ]
    faces = np.concatenate([surface.faces, [[at[0], at[1], at[2]], [at[0], at[2], at[3]]]])
    mended = tidied(corners, faces)
    assert (mended.open_edges, mended.volume) == (0, pytest.approx(2.0))


def rounded_apart(corners, faces, by, seed=0):
    """Each triangle with corners of its own, which lie up to `by` from where they were."""
    rng = np.random.default_rng(seed)
    loose = corners[faces].reshape(-1, 3)
    return loose + by * rng.uniform(-0.5, 0.5, loose.shape), np.arange(len(loose)).reshape(-1, 3)


@pytest.mark.parametrize("by", [1e-9, 1e-7, 1e-6, 5e-6])
def test_corners_apart_by_rounding(by, tmp_path):
    """A plate of 1 x 1 x 0.02 m weighs what it is, to the rounding times its area, in a grid of 0.1 m."""
    corners, faces = rounded_apart(*box((0, 0, 0), (1, 1, 0.02)), by)
    (tmp_path / "plate.obj").write_text(
        "\n".join(
            [
                *(f"v {x:.9f} {y:.9f} {z:.9f}" for x, y, z in corners.tolist()),
                *(f"f {a} {b} {c}" for a, b, c in (faces + 1).tolist()),
            ]
        )
    )
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        made = fill(Source.of("mesh", file=str(tmp_path / "plate.obj")), Numerics(dx=0.1), 0)
    assert made.volume.sum() == pytest.approx(0.02, abs=2 * by)
    assert np.abs(made.x[:, 2] - 0.01).max() < 0.01


def test_small_parts_are_not_welded():
    """Two plates 1e-7 m apart stay two, each closed; a ball of tiny triangles keeps them all."""
    surface = tidied(*joined(box((0, 0, 0), (1, 1, 0.1)), box((0, 0, 0.1 + 1e-7), (1, 1, 0.2))))
    assert surface.volume == pytest.approx(0.2)
    ball = meshes.ball(1e-3, 4)
    assert len(tidied(np.asarray(ball.vertices) + 1.0, np.asarray(ball.faces)).faces) == len(ball.faces)


def test_corners_on_the_edges_of_other_faces():
    """A side of a box cut finer than its neighbours, as voxel exports have it: closed, 1 m3."""
    corners, faces = box(*UNIT)
    kept = faces[~(corners[faces][:, :, 0] == 1).all(axis=1)]
    grid = np.array([[1.0, y / 3, z / 2] for y in range(4) for z in range(3)])
    fine = [
        t
        for y in range(3)
        for z in range(2)
        for a in [3 * y + z]
        for t in ((a, a + 3, a + 4), (a, a + 4, a + 1))
    ]
    surface = tidied(*joined((corners, kept), (grid, np.array(fine))))
    assert surface.open_edges == 0
    assert surface.volume == pytest.approx(1.0)


def test_faces_sewn_with_triangles_of_no_area():
    """A corner on an edge that a triangle without area takes in: closed, as the file meant it."""
    corners, faces = box(*UNIT)
    corners = np.concatenate([corners, [[0.5, 0.0, 0.0]]])  # on the edge from 0 to 1
    face = next(i for i, f in enumerate(faces.tolist()) if {0, 1} <= set(f))
    a, b, c = (
        int(v)
        for v in np.roll(
            faces[face],
            -next(k for k in range(3) if {int(faces[face][k]), int(faces[face][(k + 1) % 3])} == {0, 1}),
        )
    )
    faces = np.concatenate([np.delete(faces, face, axis=0), [[a, 8, c], [8, b, c], [a, b, 8]]])
    surface = tidied(corners, faces)
    assert (surface.open_edges, surface.volume) == (0, pytest.approx(1.0))


def test_thin_plates_with_holes_keep_their_volume():
    """A plate of 1 x 1 x 0.02 m of small faces, some of them missing: a flat hole does not count."""
    n = 6
    x = np.linspace(0, 1, n + 1)
    corners = np.array([[a, b, c] for c in (0.0, 0.02) for a in x for b in x])
    at = lambda i, j, k: (k * (n + 1) + i) * (n + 1) + j  # noqa: E731
    quads = [
        (at(i, j, 0), at(i, j + 1, 0), at(i + 1, j + 1, 0), at(i + 1, j, 0))
        for i in range(n)
        for j in range(n)
    ]
    quads += [
        (at(i, j, 1), at(i + 1, j, 1), at(i + 1, j + 1, 1), at(i, j + 1, 1))
        for i in range(n)
        for j in range(n)
    ]
    for i in range(n):
        quads += [(at(i, 0, 0), at(i + 1, 0, 0), at(i + 1, 0, 1), at(i, 0, 1))]
        quads += [(at(i + 1, n, 0), at(i, n, 0), at(i, n, 1), at(i + 1, n, 1))]
        quads += [(at(0, i + 1, 0), at(0, i, 0), at(0, i, 1), at(0, i + 1, 1))]
        quads += [(at(n, i, 0), at(n, i + 1, 0), at(n, i + 1, 1), at(n, i, 1))]
    faces = np.array([t for a, b, c, d in quads for t in ((a, b, c), (a, c, d))])
    surface = tidied(corners, faces[1:])
    assert surface.open_edges == 3
    assert surface.closed_volume == pytest.approx(0.02)
    assert tidied(corners, np.delete(faces, [5, 60], axis=0)).closed_volume == pytest.approx(0.02)


def test_doubled_faces_are_single():
    """Every face twice, the second time turned round: a solid, 1 m3, not nothing."""
    corners, faces = box(*UNIT)
    for doubled in (np.concatenate([faces, faces]), np.concatenate([faces, faces[:, ::-1]])):
        assert tidied(corners, doubled).volume == pytest.approx(1.0)


@pytest.mark.parametrize("shift", [0.75, 0.96, 0.99, 1.0])
def test_overlaps_count_once(shift):
    """Two unit cubes, one moved along the diagonal of a face by `shift` each way: V = 2 - (1 - shift)^2.

    Lines cross the overlap exactly; across them its two edges are one at random in squares of 1 / 48 of the
    box: 0.3 % of the whole at most.
    """
    low = np.array([shift, shift, 0.0])
    surface = tidied(*joined(box(*UNIT), box(low, low + 1)))
    assert volume(surface) == pytest.approx(2 - (1 - shift) ** 2, rel=3e-3 if shift < 1 else 1e-12)


def test_turned_boxes_that_overlap():
    """A cube and one turned by 45 degrees about z at its middle: an octagon of area 8 (sqrt 2 - 1) common to
    both squares of area 4: V = 2 (8 - 8 (sqrt 2 - 1))."""
    corners, faces = box((-1, -1, -1), (1, 1, 1))
    c = np.sqrt(0.5)
    turned = corners @ np.array([[c, c, 0], [-c, c, 0], [0, 0, 1]])
    for other in (faces, faces[:, ::-1]):
        surface = tidied(*joined((corners, faces), (turned, other)))
        assert volume(surface) == pytest.approx(2 * (8 - 8 * (np.sqrt(2) - 1)), rel=3e-3)


def test_holes_are_not_welded_shut():
    """A ball that lacks five faces keeps its hole, also 100 km away, and beside a loose corner far off."""
    ball = meshes.without(meshes.ball(0.5), 5)
    for shift in (0.0, 1e5):
        corners = np.concatenate([np.asarray(ball.vertices) + shift, [[1e6, 0.0, 0.0]]])
        surface = tidied(corners, np.asarray(ball.faces))
        assert (len(surface.faces), surface.open_edges > 0) == (len(ball.faces), True)
        assert surface.closed_volume == pytest.approx(meshes.ball(0.5).volume, rel=0.01)
