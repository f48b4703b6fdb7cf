"""`neve render`: what it refuses, what it keeps, and that a picture shows the snow."""

import importlib.util
import shutil

import numpy as np
import pytest
from PIL import Image

from neve.cli import main
from neve.cli.render import Told
from neve.film.pictures import exr_key, png_key
from neve.film.sharing import jobs_for
from neve.io.frames import read_frame, write_frame
from neve.run import run_scene
from neve.scene.schema.scene import Camera, Collider, Heat, Numerics, Run, Scene, Source

needs_mitsuba = pytest.mark.skipif(
    importlib.util.find_spec("mitsuba") is None, reason="pip install mitsuba mitsuba-oidn"
)
SMALL = ("--size", "48x32", "--quality", "draft", "--spp", "1", "--quiet")


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """A short run: a ball of snow above the ground."""
    folder = tmp_path_factory.mktemp("film") / "run"
    scene = Scene(
        sources=(Source.of("sphere", center=(0.0, 0.0, 0.6), radius=0.4),),
        colliders=(Collider.of("plane"), Collider.of("box", center=(0.0, 1.0, 0.4), size=(1.0, 0.2, 0.8))),
        numerics=Numerics(dx=0.1),
        camera=Camera(position=(0.0, -4.0, 1.0), target=(0.0, 0.0, 0.5), fov=30),
        run=Run(duration=0.1, fps=20, film=False),
    )
    run_scene(scene, folder, threads=1, quiet=True)
    return folder


@pytest.fixture
def folder(made, tmp_path):
    """A copy of it."""
    shutil.copytree(made, tmp_path / "run")
    return tmp_path / "run"


def code(*arguments):
    """Exit code of a command line."""
    with pytest.raises(SystemExit) as end:
        main([str(a) for a in arguments])
    return end.value.code


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (("--size", "big"), "--size: big is not of the form 1280x720"),
        (("--size", "8x8"), "each side has 16 to 16384 pixels"),
        (("--frame", "1", "--frames", "0:2"), "choose one of the two"),
        (("--frames", "90:"), "holds the frames 0 to 2, and none of those asked for"),
        (("--set", "snow.xi=3"), "can change its camera and light alone"),
        (("--set", "camera.fov=0"), "camera.fov"),
        (("--set", "camera={fov=0}"), "camera.fov"),
        (("--aperture", "-1"), "is not a radius"),
        (("--jobs", "0"), "--jobs: 0 is not a whole number of 1 or more"),
        (("--spp", "0"), "--spp: 0 is not a whole number of 1 or more"),
        (("--frames", "3:999999999"), "holds the frames 0 to 2, and none of those asked for"),
        (("--look", "metaballs", "--aperture", "0.1"), "the look metaballs is drawn through a pinhole"),
        (
            ("--phase", "cornette_shanks"),
            "--phase cornette_shanks: it is for the look reference, not diffuse",
        ),
        (("--look", "reference", "--snow", "wet"), "the look reference is made of the snow of Stomakhin"),
    ],
)
def test_wrong_arguments_are_one_sentence(folder, capsys, arguments, said):
    """Exit code 2, one line that says what is allowed, and nothing written."""
    assert code("render", folder, *arguments) == 2
    told = capsys.readouterr().err
    assert said in told
    assert told.count("\n") == 1
    assert not (folder / "render").exists()


def test_no_run_is_one_sentence(tmp_path, capsys):
    """A folder that is no run."""
    assert code("render", tmp_path) == 2
    assert "holds no Neve run" in capsys.readouterr().err


def test_without_mitsuba_it_says_what_to_install(folder, capsys, monkeypatch):
    """Mitsuba is optional: without it the command says how to get it."""
    monkeypatch.setitem(__import__("sys").modules, "mitsuba", None)
    assert code("render", folder, "--frame", "0", *SMALL) == 2
    assert "pip install mitsuba mitsuba-oidn" in capsys.readouterr().err
    assert not (folder / "render").exists()


@needs_mitsuba
def test_pictures_are_kept_and_made_again_where_they_must(folder, capsys):
    """The same command makes nothing anew; a lost picture, another camera and --force do."""
    assert code("render", folder, *SMALL) == 0
    assert "render.mp4: 3 new pictures" in capsys.readouterr().out
    before = (folder / "render/000001.png").read_bytes()
    (folder / "render/000002.png").unlink()
    for arguments, new in (
        ((), 1),
        (("--frame", "1", "--force"), 1),
        (("--frame", "0", "--set", "camera.fov=31"), 1),
        ((), 1),
    ):
        assert code("render", folder, *SMALL, *arguments) == 0
        assert f": {new} new pictures" in capsys.readouterr().out
    assert (folder / "render/000001.png").read_bytes() == before


@needs_mitsuba
def test_a_camera_that_moves_draws_anew_what_it_sees_otherwise(folder, capsys):
    """A turntable shows the first frame from where the camera stands anyhow, a camera that follows does not;
    with the same camera nothing is drawn again."""
    turning = ("--set", "camera.turntable=90")
    follows = ("--set", "camera.follow=snow", "--set", "camera.offset=[0.0,0.0,0.5]")
    for arguments, new in (((), 3), (turning, 2), (turning, 0), (follows, 3), (follows, 0)):
        assert code("render", folder, *SMALL, *arguments) == 0
        assert f": {new} new pictures" in capsys.readouterr().out
    seen = np.asarray(Image.open(folder / "render/000002.png")).astype(float).mean(axis=2)
    assert seen[22:26, 21:27].mean() > 1.5 * seen[22:26, :6].mean()  # the ball, 7 pixels below the middle
    assert code("render", folder, *SMALL, "--set", "camera.follow=bodies.0") == 2
    assert 'camera.follow = "bodies.0" is not allowed' in capsys.readouterr().err


@needs_mitsuba
def test_the_lens_of_the_scene_is_that_of_the_picture(folder, capsys):
    """camera.aperture is --aperture, which counts if both are there; camera.focus moves what is sharp."""
    wide, near = ("--set", "camera.aperture=0.1"), ("--set", "camera.aperture=0.1", "--set", "camera.focus=3")
    for arguments, new in (
        (("--aperture", "0.1"), 1),
        (wide, 0),
        (near, 1),
        ((*near, "--aperture", "0"), 1),
        (("--set", "camera.focus=3"), 0),
    ):
        assert code("render", folder, *SMALL, "--frame", "0", *arguments) == 0
        assert f": {new} new pictures" in capsys.readouterr().out
    assert code("render", folder, *SMALL, *wide, "--look", "metaballs") == 2
    assert "camera.aperture: the look metaballs is drawn through a pinhole" in capsys.readouterr().err


@needs_mitsuba
def test_what_lies_at_the_focus_is_sharp():
    """An edge at the distance of `focus` is sharp, one at that of the target is blurred over the image of
    the lens: 2 r f |1 - focus / d| / focus pixels, f the focal length in pixels."""
    from neve.render.path_tracing.engine import mitsuba
    from neve.render.path_tracing.lens import Lens

    mi = mitsuba()
    view = Camera(position=(0.0, -4.0, 0.0), target=(0.0, 0.0, 0.0), fov=20)
    seen = {}
    for depth in (2.0, 4.0):
        lens = Lens(view, 64, 16, aperture=0.04, focus=2.0)
        film = {"type": "hdrfilm", "width": 64, "height": 16, "rfilter": {"type": "box"}}
        to = mi.ScalarTransform4f().translate([5.0, depth - 4.0, 0.0])
        half = {"type": "rectangle", "to_world": to.rotate([1, 0, 0], 90).scale([5.0, 5.0, 5.0])}
        half |= {"emitter": {"type": "area", "radiance": {"type": "rgb", "value": [1.0, 1.0, 1.0]}}}
        parts = {"type": "scene", "integrator": {"type": "path"}, "half": half}
        scene = mi.load_dict(parts | {"sensor": lens.sensor(mi, film, 256, 1)})
        row = np.array(mi.render(scene))[..., 0].mean(axis=0)
        seen[depth] = int(((row > 0.02) & (row < 0.98)).sum())
    assert seen[2.0] <= 1
    blur = 2 * 0.04 * lens.focal * (1 - 2.0 / 4.0) / 2.0
    assert blur * 0.7 < seen[4.0] <= blur + 2


@needs_mitsuba
def test_processes_draw_the_same_pictures(folder, capsys):
    """Frames drawn by two processes are those of one, byte for byte, with a camera that must see all frames;
    what is there already is kept."""
    moving = ("--set", "camera.follow=snow", "--set", "camera.shutter=0.5")
    assert code("render", folder, *SMALL, *moving, "--out", folder / "one", "--jobs", "1") == 0
    assert code("render", folder, *SMALL, *moving, "--out", folder / "two", "--jobs", "2") == 0
    names = sorted(path.name for path in (folder / "one").glob("*.png"))
    assert len(names) == 3
    for name in names:
        assert (folder / "two" / name).read_bytes() == (folder / "one" / name).read_bytes()
    capsys.readouterr()
    assert code("render", folder, *SMALL, *moving, "--out", folder / "two", "--jobs", "2") == 0
    assert ": 0 new pictures" in capsys.readouterr().out


@needs_mitsuba
def test_a_film_says_that_heat_runs_faster(folder):
    """White letters on dark edges stand in the lower left corner if heat goes faster than motion, and only
    there; without heat nothing is written."""
    from neve.scene.reading.load import load, to_toml

    small = (*SMALL[2:], "--size", "160x90", "--frame", "0")
    heated = load(folder).model_copy(update={"heat": Heat(heat_speed=50.0)})
    assert code("render", folder, *small, "--out", folder / "plain") == 0
    (folder / "scene.toml").write_text(to_toml(heated), encoding="utf-8")
    assert code("render", folder, *small, "--out", folder / "said") == 0
    plain, said = (
        np.asarray(Image.open(folder / name / "000000.png")).astype(int) for name in ("plain", "said")
    )
    rows, columns = np.nonzero((plain != said).any(axis=2))
    assert len(rows) > 100
    assert (said[rows, columns] > 240).all(axis=1).sum() > 20
    assert rows.min() > 0.85 * 90
    assert columns.max() < 0.8 * 160


def test_frames_are_drawn_side_by_side_as_cores_and_memory_allow(monkeypatch):
    """One on each core; no more than frames, than processes that fit into 95 % of the free memory, than a
    million paths of light each; one at least."""
    gigabyte = 10**9
    monkeypatch.setattr("neve.system.memory.free", lambda: 8 * gigabyte)
    assert jobs_for(24, 16, 10**9, 0.5 * gigabyte) == 15
    assert jobs_for(24, 4, 10**9, 0.5 * gigabyte) == 4
    assert jobs_for(3, 16, 10**9, 0.5 * gigabyte) == 3
    assert jobs_for(24, 16, 10**9, 2.0 * gigabyte) == 3
    assert jobs_for(24, 16, 10**9, 20 * gigabyte) == 1
    assert jobs_for(24, 16, 2_500_000, gigabyte) == 2
    assert jobs_for(24, 16, 1000, gigabyte) == 1
    monkeypatch.setattr("neve.system.memory.free", lambda: None)
    assert jobs_for(24, 16, 10**9, gigabyte) == 16


@needs_mitsuba
def test_light_is_never_that_of_another_picture(folder):
    """An EXR goes when its PNG is made anew without one, stays with the picture that it belongs to, and is
    made where it lacks."""
    linear, camera = folder / "render/000000.exr", ("--set", "camera.fov=31")
    for arguments, there in (
        (("--exr",), True),
        ((), True),
        (camera, False),
        ((*camera, "--exr"), True),
        ((), False),
        (("--exr",), True),
    ):
        assert code("render", folder, *SMALL, "--frame", "0", *arguments) == 0
        assert linear.exists() is there
    key = png_key(linear.with_suffix(".png"))
    assert exr_key(linear) == key is not None


@needs_mitsuba
def test_files_of_others_stay(folder, capsys):
    """A picture of another maker is refused before any is made; what a killed render left goes."""
    out = folder / "mine"
    out.mkdir()
    Image.new("RGB", (4, 4)).save(out / "000001.png")
    mine = (out / "000001.png").read_bytes()
    left = out / ".000000.exr.12-3.part.exr"
    left.write_bytes(b"half")
    assert code("render", folder, *SMALL, "--out", out) == 2
    assert "000001.png is no picture that neve render made" in capsys.readouterr().err
    assert [path.name for path in out.iterdir()] == ["000001.png"]
    assert (out / "000001.png").read_bytes() == mine


@needs_mitsuba
def test_a_film_of_some_frames_is_not_the_film(folder):
    """It has their numbers in its name, and the film of all frames stays."""
    assert code("render", folder, *SMALL) == 0
    whole = (folder / "render/render.mp4").read_bytes()
    assert code("render", folder, *SMALL, "--frames", "1:") == 0
    assert (folder / "render/render_000001-000002.mp4").is_file()
    assert (folder / "render/render.mp4").read_bytes() == whole


@needs_mitsuba
def test_a_frame_with_other_solids_is_one_sentence(folder, capsys):
    """Poses belong to the solids of the scene, one each."""
    content = read_frame(folder / "frames", 1)
    write_frame(
        folder / "frames",
        1,
        content._replace(
            solid_position=content.solid_position[:1], solid_rotation=content.solid_rotation[:1]
        ),
    )
    assert code("render", folder, *SMALL, "--frame", "1") == 2
    assert "000001.npz has 1 solids, and the scene of the run 2" in capsys.readouterr().err


def test_time_left_is_that_of_new_pictures(monkeypatch, capsys):
    """Two kept and two made in 20 s, six to go: a minute; while none is new nothing is known."""
    now = iter([0.0, 0.1, 20.0])
    monkeypatch.setattr("time.monotonic", lambda: next(now))
    told = Told(quiet=False)
    told(2, 10, 0)
    told(4, 10, 2)
    monkeypatch.undo()
    first, second = capsys.readouterr().err.splitlines()
    assert first == "render: picture 2 of 10"
    assert second == "render: picture 4 of 10, 1:00 min left"


@needs_mitsuba
@pytest.mark.parametrize(
    "more",
    [
        ("--look", "diffuse", "--snow", "wet"),
        ("--look", "medium", "--aperture", "0.02"),
        ("--look", "metaballs"),
    ],
    ids=lambda more: more[1],
)
def test_snow_is_where_the_camera_puts_it(folder, more):
    """The ball is bright and the sky above it is not; light that is written as EXR is what the PNG shows."""
    out = folder / "shown"
    assert code("render", folder, *SMALL, *more, "--frame", "0", "--spp", "8", "--exr", "--out", out) == 0
    image = np.asarray(Image.open(out / "000000.png")).astype(float)
    assert image.shape == (32, 48, 3)
    ball, earth = image[12:15, 21:27].mean(), image[28:, :8].mean()
    assert ball > 1.5 * earth
    import mitsuba

    light = np.array(mitsuba.Bitmap(str(out / "000000.exr")))[..., :3]
    assert light.shape == (32, 48, 3)
    assert np.corrcoef(light.mean(axis=2).ravel(), image.mean(axis=2).ravel())[0, 1] > 0.8


@needs_mitsuba
@pytest.mark.parametrize(
    "camera",
    [
        {"position": (0.0, 0.0, 5.0), "target": (0.0, 0.0, 0.0), "up": (0.0, 1.0, 0.0)},
        {"position": (0.0, -4.0, 0.0), "target": (0.0, 0.0, 0.0)},
        {"position": (0.0, -4.0, -1.0), "target": (0.0, 0.0, 0.5)},
        {"position": (0.0, -4.0, 0.5), "target": (0.0, 0.0, 6.0), "fov": 160.0},
    ],
    ids=["from above", "in the ground's plane", "from below", "wide"],
)
def test_ground_is_there_from_any_side(camera):
    """From wherever the camera looks at it, the ground is a mesh of finite places on and below its plane, but
    for hills far away."""
    from neve.render.path_tracing.engine import mitsuba
    from neve.render.path_tracing.ground import ground
    from neve.render.path_tracing.lens import Lens

    lens = Lens(Camera(**camera), 64, 36)
    mesh = ground(lens, np.zeros(3), np.eye(3), 0.05, "ground")
    places = np.array(mitsuba().traverse(mesh)["vertex_positions"]).reshape(-1, 3)
    assert np.isfinite(places).all()
    near = np.hypot(*(places[:, :2] - lens.eye[:2]).T) < 10 * lens.distance
    assert np.abs(places[near, 2]).max() < 0.1
    assert np.hypot(*places[:, :2].T).max() > 100 * lens.distance


def test_slope_is_as_fine_as_level_ground():
    """A hillside fills the picture of an upright camera, which leans in the slope's own frame, with a vertex
    for every second pixel: 16 in each 8 by 8 pixels, less a row of 4 that may lie on the edge."""
    from neve.render.path_tracing.engine import mitsuba
    from neve.render.path_tracing.ground import ground
    from neve.render.path_tracing.lens import Lens

    lens = Lens(Camera(position=(3.6, -3.2, 1.2), target=(-0.2, 0.0, 0.6), fov=29.0), 64, 64)
    normal, along = np.array([0.53, 0.0, 0.848]), np.array([0.0, 1.0, 0.0])
    rotation = np.stack([along, np.cross(normal, along), normal], axis=1)
    mesh = ground(lens, np.zeros(3), rotation, 0.05, "ground")
    places = np.array(mitsuba().traverse(mesh)["vertex_positions"]).reshape(-1, 3)
    u, v, depth = lens.project(places)
    count, _, _ = np.histogram2d(v[depth > 0], u[depth > 0], bins=8, range=[[0, 64], [0, 64]])
    assert count.min() >= 12
