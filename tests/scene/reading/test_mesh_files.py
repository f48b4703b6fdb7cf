"""Mesh files: every format, units and axes, what is mended, what is refused, what is warned of."""

from __future__ import annotations

import re
import warnings
from math import pi
from pathlib import Path
from typing import Any

import meshes
import numpy as np
import pytest
import trimesh

from neve.geometry.mesh import read_mesh
from neve.geometry.sdf import SolidMesh, grid_bytes, of_triangles, solid_mesh, thinnest
from neve.geometry.triangles import Triangles, tidied
from neve.scene.errors import SceneError, SceneWarning
from neve.scene.reading.load import load, scene_from
from neve.scene.schema.file_shapes import Mesh
from neve.scene.schema.scene import Collider

NAME = "colliders.0"


def surface_of(mesh: Any) -> Triangles:
    """Return a mesh of trimesh in order."""
    return tidied(np.asarray(mesh.vertices), np.asarray(mesh.faces))


def refusal(part: Mesh, dx: float = 0.05) -> str:
    """Return the sentence with which `part` is refused, after checking that it is one and names the file."""
    with pytest.raises(SceneError) as caught:
        solid_mesh(part, dx, NAME)
    text = str(caught.value)
    assert text.startswith(NAME)
    assert text.endswith(".")
    assert "\n" not in text
    assert not re.search(r"[.!] [A-Z]", text), "more than one sentence"
    return text


@pytest.mark.parametrize("suffix", [".obj", ".ply", ".stl", ".glb", ".gltf"])
def test_every_format_holds_the_same_body(suffix: str, tmp_path: Path) -> None:
    """A box written in each format reads back as 8 corners and 12 faces, closed, of its volume and bounds.

    STL, PLY and GLB hold single precision: eps = 1.2e-7 of coordinates below 1.
    """
    if suffix == ".gltf":
        for name, data in trimesh.exchange.gltf.export_gltf(trimesh.Scene(meshes.box(0.4, 0.6, 0.8))).items():
            (tmp_path / name).write_bytes(data)
        path = str(tmp_path / "model.gltf")
    else:
        path = meshes.written(meshes.box(0.4, 0.6, 0.8), tmp_path / f"a{suffix}")
    surface = read_mesh(Collider.of("mesh", file=path), NAME)
    assert (len(surface.vertices), len(surface.faces), surface.open_edges) == (8, 12, 0)
    assert surface.low == pytest.approx([-0.2, -0.3, -0.4], rel=2.4e-7)
    assert surface.high == pytest.approx([0.2, 0.3, 0.4], rel=2.4e-7)
    assert surface.volume == pytest.approx(0.4 * 0.6 * 0.8, rel=1e-6)


def test_scene_graph_of_a_glb(tmp_path: Path) -> None:
    """Two nodes with one mesh, one of them moved, turned and mirrored: both are there, and each counts.

    The mirror turns the faces inside out, and they are turned back: otherwise the volumes would cancel.
    """
    scene = trimesh.Scene()
    scene.add_geometry(meshes.box(1.0, 1.0, 1.0), node_name="here", geom_name="box")
    place = np.array([[0, -2.0, 0, 5], [1, 0, 0, 0], [0, 0, -1, 0], [0, 0, 0, 1]])
    assert np.linalg.det(place) < 0
    scene.graph.update(frame_to="there", matrix=place, geometry="box")
    surface = read_mesh(Collider.of("mesh", file=meshes.written(scene, tmp_path / "a.glb")), NAME)
    assert surface.low == pytest.approx([-0.5, -0.5, -0.5])
    assert surface.high == pytest.approx([6.0, 0.5, 0.5])
    assert surface.volume == pytest.approx(1.0 + 2.0)


def test_units_scale_and_up(tmp_path: Path) -> None:
    """25.4 mm are an inch; `scale` comes on top; y up becomes z up, and what was towards the viewer is -y."""
    path = meshes.written(meshes.box(1.0, 2.0, 3.0), tmp_path / "a.obj")
    for unit, metres in {"m": 1.0, "cm": 0.01, "mm": 0.001, "in": 0.0254, "ft": 0.3048}.items():
        surface = read_mesh(Collider.of("mesh", file=path, unit=unit, scale=2.0), NAME)  # type: ignore[arg-type]
        assert surface.high == pytest.approx(np.array([1.0, 2.0, 3.0]) * metres)
    (tmp_path / "corner.obj").write_text(
        "v 0 0 0\nv 1 0 0\nv 0 2 0\nv 0 0 3\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"
    )
    surface = read_mesh(Collider.of("mesh", file=str(tmp_path / "corner.obj"), up="y"), NAME)
    assert {tuple(v) for v in surface.vertices} == {(0, 0, 0), (1, 0, 0), (0, 0, 2), (0, -3, 0)}
    assert surface.volume == pytest.approx(1.0), "a turn, not a mirror"


def test_soups_are_put_in_order() -> None:
    """Loose triangles, any of them turned round or repeated, some of no area, become the ball that they were.

    The volume is that of the polyhedron, summed in another order: rounding.
    """
    ball = meshes.ball(0.5)
    rng = np.random.default_rng(1)
    corners = np.asarray(ball.vertices)[ball.faces].reshape(-1, 3)
    faces = rng.permutation(np.arange(len(corners)).reshape(-1, 3))
    faces = np.where(rng.random((len(faces), 1)) < 0.5, faces[:, ::-1], faces)
    faces = np.concatenate([faces, faces[:40, ::-1], [[0, 0, 1], [5, 5, 5]]])
    surface = tidied(corners, faces)
    assert (len(surface.vertices), len(surface.faces)) == (len(ball.vertices), len(ball.faces))
    assert surface.open_edges == 0
    assert surface.volume == pytest.approx(ball.volume, rel=1e-12)


def test_cavities_and_inside_out_meshes() -> None:
    """A ball with a cavity keeps it, whichever way the whole is turned; volumes are the polyhedra's."""
    outer, inner = meshes.ball(1.0), meshes.ball(0.5)
    volume = outer.volume - inner.volume
    inner.invert()
    for hollow in (
        surface_of(meshes.joined(outer, inner)),
        surface_of(meshes.joined(outer, inner)).flipped(),
    ):
        surface = tidied(hollow.vertices, hollow.faces)
        assert surface.volume == pytest.approx(volume, rel=1e-12)
        mesh = of_triangles(surface, 0.1, 0.2)
        phi, _ = mesh.sdf.sample(np.array([[0.0, 0.0, 0.0], [0.6, 0.0, 0.0], [1.1, 0.0, 0.0]]))
        assert phi == pytest.approx([0.5, -0.1, 0.1], abs=0.02), "facets of the ball lie up to 0.5 % inside"


def test_distance_and_normal_of_a_ball(tmp_path: Path) -> None:
    """The distance grid of a ball of 1280 facets: phi = |x| - r and n = x / |x| at points near the surface.

    The facets' middles lie r (1 - cos a) inside, with a the angle from middle to corner, below 0.10 rad here:
    0.0025 m of 0.5 m. The blend between samples adds h^2 / 8 times the curvature 2 / r: 0.0003 m at h =
    0.025 m. The normal turns by at most the angle a within a facet, and the blend smooths it.
    """
    mesh = solid_mesh(
        Collider.of("mesh", file=meshes.written(meshes.ball(0.5), tmp_path / "a.ply")), 0.05, NAME
    )
    assert mesh.spacing == 0.025
    rng = np.random.default_rng(2)
    direction = rng.standard_normal((500, 3))
    direction /= np.linalg.norm(direction, axis=1)[:, None]
    radius = rng.uniform(0.42, 0.58, 500)
    phi, normal = mesh.sdf.sample(direction * radius[:, None])
    error = np.asarray(phi) - (radius - 0.5)
    assert error.min() >= -0.0003 - 1e-4
    assert error.max() <= 0.0025 + 0.0003 + 1e-4
    assert np.einsum("ij,ij->i", normal, direction).min() > np.cos(0.10)


def test_small_holes_are_closed_and_told(tmp_path: Path) -> None:
    """A ball that lacks 5 of 1280 faces is taken with a warning; phi off the hole is that of the ball."""
    path = meshes.written(meshes.without(meshes.ball(0.5), 5), tmp_path / "a.stl")
    with pytest.warns(SceneWarning, match=r"colliders\.0\.file = .* has small holes \(\d+ edges"):
        mesh = solid_mesh(Collider.of("mesh", file=path), 0.1, NAME)
    phi, _ = mesh.sdf.sample(np.array([[0.0, 0.0, 0.0], [0.0, 0.0, 0.45], [0.0, 0.0, -0.7]]))
    assert phi == pytest.approx([-0.5, -0.05, 0.2], abs=0.01)


def test_closed_meshes_are_silent(tmp_path: Path) -> None:
    """Nothing is said of a body that is closed and large enough."""
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        solid_mesh(Collider.of("mesh", file=meshes.written(meshes.ball(0.5), tmp_path / "a.glb")), 0.1, NAME)


OPEN = {
    "sheet": meshes.sheet(1.0),
    "box without a lid": meshes.without(meshes.box(1.0, 1.0, 1.0), 2),
    "box without half a face": meshes.without(meshes.box(1.0, 1.0, 1.0), 1),
    "cup": trimesh.Trimesh(
        meshes.ball(0.5).vertices,
        meshes.ball(0.5).faces[meshes.ball(0.5).triangles_center[:, 2] < 0],
        process=False,
    ),
}


@pytest.mark.parametrize("what", OPEN)
def test_open_meshes_need_a_thickness(what: str, tmp_path: Path) -> None:
    """What has no inside is refused, with the way out; with a thickness it is a body around its faces."""
    path = meshes.written(OPEN[what], tmp_path / "a.ply")
    assert "is open" in (told := refusal(Collider.of("mesh", file=path)))
    assert "close it, or set colliders.0.thickness" in told
    mesh = solid_mesh(Collider.of("mesh", file=path, thickness=0.1), 0.05, NAME)
    corner = np.asarray(OPEN[what].triangles[-1]).mean(axis=0)
    assert mesh.sdf.sample(corner[None])[0] == pytest.approx([-0.05], abs=0.01)


def test_sheet_with_thickness() -> None:
    """phi = |z| - t / 2 above and below a sheet: exact but for single precision where it is linear."""
    mesh = of_triangles(surface_of(meshes.sheet(1.0)), 0.025, 0.1, thickness=0.1)
    z = np.array([-0.2, -0.1, -0.06, 0.06, 0.1, 0.2])
    phi, normal = mesh.sdf.sample(np.stack([np.full(6, 0.11), np.full(6, -0.07), z], axis=1))
    assert phi == pytest.approx(np.abs(z) - 0.05, abs=1e-6)
    assert np.asarray(normal)[:, 2] == pytest.approx(np.sign(z), abs=1e-6)


FLAT = "v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\nf 1 1 2\n"
CORNER = "v nan 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"
# Name and content of a file -> what the sentence says.
BAD: list[tuple[str, bytes, str]] = [
    ("empty.obj", b"", "holds no triangles"),
    ("empty.ply", b"", "cannot be read: it does not begin with the word ply"),
    ("empty.stl", b"", "holds no triangles"),
    ("empty.glb", b"", "cannot be read: it is no glTF: its text is no JSON"),
    ("letter.obj", b"Dear snow,\nfall well.\n", "holds no triangles"),
    ("letter.glb", b"Dear snow,\nfall well.\n" * 20, "cannot be read: it is no glTF"),
    ("letter.gltf", b"{}", "it is no glTF, or of 1.0: export it as glTF 2.0"),
    ("points.obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\n", "holds no triangles"),
    ("flat.obj", FLAT.encode(), "has no area"),
    ("nan.obj", CORNER.encode(), "no finite numbers"),
    ("inf.obj", CORNER.replace("nan", "inf").encode(), "no finite numbers"),
    ("far.obj", CORNER.replace("nan", "1e30").encode(), "reaches beyond 1e6 m"),
    (
        "lost.obj",
        CORNER.replace("nan", "0").replace("2 3 4", "2 3 9").encode(),
        "the face of line 8 names a corner that is not there, of 4",
    ),
]


@pytest.mark.parametrize(("name", "content", "words"), BAD, ids=[name for name, _, _ in BAD])
def test_bad_files_are_one_sentence(name: str, content: bytes, words: str, tmp_path: Path) -> None:
    """Whatever lies in the file: one sentence with key, file and what is wrong."""
    (tmp_path / name).write_bytes(content)
    told = refusal(Collider.of("mesh", file=str(tmp_path / name)))
    assert told.startswith(f'colliders.0.file = "{tmp_path / name}" ')
    assert words in told


def test_damaged_files_are_one_sentence(tmp_path: Path) -> None:
    """A file cut short, in each binary format."""
    for suffix in (".ply", ".stl", ".glb"):
        path = Path(meshes.written(meshes.ball(0.5), tmp_path / f"a{suffix}"))
        path.write_bytes(path.read_bytes()[: path.stat().st_size // 2])
        assert refusal(Collider.of("mesh", file=str(path))).startswith(f'colliders.0.file = "{path}" ')


def test_names_of_files(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A mesh lies beside its scene; one that is missing, of another kind or not Neve's own is told."""
    meshes.written(meshes.box(1, 1, 1), tmp_path / "a.ply")
    text = '[[sources]]\nshape = "box"\n[[colliders]]\nshape = "mesh"\n'
    path = tmp_path / "scene.toml"
    path.write_text(f'{text}file = "a.ply"\n')
    monkeypatch.chdir(tmp_path.parent)
    mesh = load(path).colliders[0]
    assert isinstance(mesh, Mesh)
    assert mesh.file == str(tmp_path / "a.ply")
    for line, words in {
        "": "colliders.0.file must name a mesh: a file that ends in",
        'file = "b.ply"': 'b.ply" is not a file; name a .obj, .ply, .stl, .glb or .gltf file',
        'file = "a.blend"': 'must end in ".obj", ".ply", ".stl", ".glb" or ".gltf"',
        'file = "neve:nothing"': 'colliders.0.file = "neve:nothing" does not come with Neve',
        "file = 3": "colliders.0.file = 3 is not allowed: use text in quotes",
        'file = "a.ply"\nunits = "cm"': "did you mean unit?",
        'file = "a.ply"\nunit = "inch"': '"in"',
        'file = "a.ply"\nscale = 0': "colliders.0.scale = 0 is not allowed: use a number from 1e-09",
        'file = "a.ply"\nthickness = -1': "colliders.0.thickness = -1 is not allowed",
    }.items():
        path.write_text(f"{text}{line}\n")
        with pytest.raises(SceneError) as caught:
            load(path)
        assert words in str(caught.value)
        assert str(caught.value).startswith(str(path))


def test_small_body_is_told(tmp_path: Path) -> None:
    """A mesh in metres that is read as centimetres is too small; the scale that is named is enough."""
    path = meshes.written(meshes.box(0.09, 0.02, 0.02), tmp_path / "a.ply")
    with pytest.warns(
        SceneWarning, match=r"is 0\.09 m large, less than two cells .*scale = (\S+) or"
    ) as told:
        solid_mesh(Collider.of("mesh", file=path), 0.05, NAME)
    found = re.search(r"scale = (\S+) or", str(told[0].message))
    assert found
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        solid_mesh(Collider.of("mesh", file=path, scale=float(found[1])), 0.05, NAME)


def test_spacing_follows_thin_parts_and_memory(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Half a cell; half of a thin plate; what `detail` says; coarser, and told, where memory ends."""
    thick = meshes.written(meshes.box(1, 1, 1), tmp_path / "a.ply")
    plate = meshes.written(meshes.box(1, 1, 0.03), tmp_path / "b.ply")
    assert thinnest(surface_of(meshes.box(1, 1, 0.03))) == pytest.approx(0.03, rel=1e-3)
    assert solid_mesh(Collider.of("mesh", file=thick), 0.1, NAME).spacing == 0.05
    thin: SolidMesh = solid_mesh(Collider.of("mesh", file=plate), 0.1, NAME)
    assert thin.spacing == pytest.approx(0.015, rel=1e-3)
    assert thin.sdf.sample(np.array([[0.1, 0.2, 0.0]]))[0][0] < -0.005, "the plate is there"
    assert solid_mesh(Collider.of("mesh", file=thick, detail=0.08), 0.1, NAME).spacing == 0.08
    assert "detail = 1e-05 would take" in refusal(Collider.of("mesh", file=thick, detail=1e-5))
    monkeypatch.setattr("neve.geometry.sdf.DEFAULT_BYTES", 2**20)
    with pytest.warns(
        SceneWarning, match=r"colliders\.0\.detail is \S+ m, because 0\.025 m would take \d+ MB"
    ):
        coarse = solid_mesh(Collider.of("mesh", file=thick), 0.05, NAME)
    assert coarse.sdf.bytes < 2**20


def test_bytes_are_known_before(tmp_path: Path) -> None:
    """The estimate holds within a factor of two for a ball, a box and a sheet: bricks lie by chance."""
    for mesh, thickness in ((meshes.ball(0.5), 0.0), (meshes.box(1, 1, 0.5), 0.0), (meshes.sheet(1.0), 0.05)):
        surface = surface_of(mesh)
        grid = of_triangles(surface, 0.04, 0.1, thickness).sdf
        assert 0.5 < grid_bytes(surface, 0.04, 0.1, thickness) / grid.bytes < 2.0


def test_volume_is_exact() -> None:
    """The divergence theorem on an icosahedron of edge a: 5 (3 + sqrt 5) / 12 a^3, wherever it lies."""
    ball = meshes.ball(1.0, fineness=0)
    edge = float(ball.edges_unique_length.mean())
    volume = 5 * (3 + 5**0.5) / 12 * edge**3
    assert surface_of(ball).volume == pytest.approx(volume, rel=1e-12)
    moved = tidied(np.asarray(ball.vertices) + np.array([100.0, -50.0, 7.0]), np.asarray(ball.faces))
    assert moved.volume == pytest.approx(volume, rel=1e-12)
    assert surface_of(meshes.ball(1.0)).volume == pytest.approx(4 / 3 * pi, rel=0.01), (
        "facets lie inside the ball"
    )


def test_mesh_in_a_scene() -> None:
    """A scene needs the file that it names."""
    with pytest.raises(SceneError, match="colliders\\.0\\.file must name a mesh"):
        scene_from({"sources": [{"shape": "box"}], "colliders": [{"shape": "mesh"}]})
