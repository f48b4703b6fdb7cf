"""A solver of fifty lines is run, filmed, viewed, resumed and logged, with nothing changed outside of it."""

import csv
from types import SimpleNamespace

import numpy as np
import pytest
from PIL import Image
from viewer.conftest import converse

import neve
from neve.build import coupled
from neve.colliders.motion import pose
from neve.compare.film import STILL
from neve.compare.page import PAGE
from neve.compare.run import TABLE, chosen_methods, compare
from neve.io.errors import RunError
from neve.io.frames import read_frame
from neve.io.log import read_log
from neve.io.npz import read_npz
from neve.registry import METHODS
from neve.run import run_scene
from neve.run.outputs.fragments import count_run
from neve.sampling import fill
from neve.scene.errors import SceneError
from neve.scene.reading.load import load, scene_from, to_toml
from neve.solver import Field, Solver, StepSummary
from neve.viewer.encode import encode
from neve.viewer.exports.replay import replay_page
from neve.viewer.modes import Colors, Scale
from neve.viewer.players.recorded import Recorded
from neve.viewer.players.snapshot import of_simulation
from neve.viewer.protocol.state import unframed
from neve.viewer.show import prepare
from neve.viewer.tools.change import is_live

G = 9.81
BALL = {"shape": "sphere", "radius": 0.3, "center": [0, 0, 2]}
FLOOR = {"colliders": [{"shape": "plane"}]}
RADIUS, MASS = 0.02, 0.01


class Grains(Solver):
    """Grains of RADIUS [m] and MASS [kg] that fly, v += g dt, x += v dt, and that planes and spheres stop."""

    fields = (
        Field("x", (3,), "m", "float64", "position"),
        Field("v", (3,), "m/s", "float64", "velocity"),
        Field("id", (), "", "int64", "number"),
    )
    stages = ("fly",)
    solids = ()
    log_columns = ("grains", "height")

    def __init__(self, scene, saved=None):
        super().__init__(scene, saved)
        self.solids, self.rigid = coupled(scene)
        if saved is not None and self.rigid:
            self.rigid.restore(saved)
        if saved is None:
            x = np.concatenate([fill(s, scene.numerics, i).x for i, s in enumerate(scene.sources)])
            saved = {"x": x, "v": np.zeros_like(x), "id": np.arange(len(x))}
        self.state = SimpleNamespace(**{field.name: np.array(saved[field.name]) for field in self.fields})

    def poses(self, time):
        return [pose(c, time) for c in self.scene.colliders] + (self.rigid.poses() if self.rigid else [])

    @property
    def radius(self):
        return np.full(self.count, RADIUS)

    def save(self):
        return super().save() | (self.rigid.save() if self.rigid else {})

    def step(self, steps, time, remaining):
        dt = min(1e-3, remaining)
        with self.timer.stage("fly"):
            self.state.v += dt * np.array(self.scene.world.gravity)
            self.state.x += dt * self.state.v
        return StepSummary(dt, "grains", 0)

    def end_step(self, steps, time, dt):
        exchanged = np.zeros((len(self.solids), 7))
        for row, solid, at in zip(exchanged, self.solids, self.poses(time), strict=True):
            arm = self.state.x - at.position
            far = np.linalg.norm(arm, axis=1, keepdims=True)
            normal = at.rotation[:, 2] + 0 * arm if solid.endless else arm / far
            depth = solid.half[0] + RADIUS - (arm * normal).sum(axis=1)
            speed = ((self.state.v - at.velocity) * normal).sum(axis=1)
            push = np.where((depth > 0) & (speed < 0), -speed, 0)[:, None] * normal
            self.state.v += push
            row[:3], row[3:6] = -MASS * push.sum(axis=0), -MASS * np.cross(arm, push).sum(axis=0)
            row[6] = MASS * push.sum(axis=0) @ at.velocity
        if self.rigid:
            self.rigid.advance(dt, exchanged[len(self.scene.colliders) :], time - dt)
        return exchanged

    def diagnostics(self, exchanged):
        return {"grains": self.count, "height": float(self.state.x[:, 2].mean())}


@pytest.fixture(autouse=True)
def _registered(monkeypatch):
    monkeypatch.setitem(METHODS.entries, "grains", Grains)


def scene(more=(), **run):
    return scene_from(
        {
            "numerics": {"method": "grains", "dx": 0.1},
            "sources": [BALL],
            "run": {"duration": 0.1, "fps": 50, **run},
            **dict(more),
        },
        where="test",
    )


def test_it_moves_by_its_own_equation():
    """After n steps of dt a grain has fallen by g dt^2 n (n + 1) / 2, and kept its place across."""
    sim = neve.Simulation(scene())
    before = np.array(sim.state.x)
    sim.advance(0.1)
    assert (sim.steps, sim.time, sim.stats.bound) == (100, pytest.approx(0.1), "grains")
    fallen = before[:, 2] - sim.state.x[:, 2]
    np.testing.assert_allclose(fallen, G * 1e-6 * 100 * 101 / 2, rtol=1e-9)
    np.testing.assert_array_equal(before[:, :2], sim.state.x[:, :2])
    assert sim.stats.stage_seconds["fly"] > 0
    assert sim.bytes == sim.count * 7 * 8


def test_it_knows_no_heat():
    """One sentence says which methods do."""
    with pytest.raises(SceneError, match='"grains" knows no heat; use "mpm" or "particles", or leave'):
        neve.Simulation(scene({"heat": {}}))


def test_it_is_compared(tmp_path, monkeypatch):
    """`neve compare` takes it beside the others by itself: a run, a panel, a row."""
    assert chosen_methods(None)[-1] == "grains"

    def load(method):
        given = scene(film=False)
        return given.model_copy(update={"numerics": given.numerics.model_copy(update={"method": method})})

    monkeypatch.setattr("neve.compare.film.PANEL", (160, 90))

    compare(load, ["mpm", "grains"], tmp_path, frames=2, threads=1, quiet=True)
    times = [
        [read_frame(tmp_path / method / "frames", k).time for k in range(3)] for method in ("mpm", "grains")
    ]
    assert times[0] == times[1]
    known = list(csv.DictReader((tmp_path / TABLE).read_text().splitlines()))
    assert [row["method"] for row in known] == ["mpm", "grains"]
    assert known[0]["particles"] == known[1]["particles"]
    assert int(known[1]["steps"]) == 40
    assert float(known[1]["height [m]"]) == pytest.approx(float(known[0]["height [m]"]), abs=0.02)
    assert known[1]["kinetic [J]"] == known[1]["mass [kg]"] == "nan"
    page = (tmp_path / PAGE).read_text()
    assert "<th>grains</th>" in page
    assert "not known" in page
    with Image.open(tmp_path / STILL) as still:
        assert still.size == (320, 90)


def test_it_fills_a_run_folder(tmp_path):
    """Frames, a log with its own columns, a film and a picture."""
    sim = run_scene(scene(), tmp_path / "run", quiet=True)
    rows = read_log(tmp_path / "run/log.csv", "grains")
    assert list(rows[0])[7:] == ["grains", "height", "seconds_fly", "seconds_write", "seconds_film"]
    assert [int(row["grains"]) for row in rows] == [sim.count] * 6
    assert float(rows[-1]["height"]) == pytest.approx(sim.state.x[:, 2].mean(), rel=1e-15)
    frame = read_frame(tmp_path / "run/frames", 5)
    np.testing.assert_array_equal(frame.x, sim.state.x.astype(np.float32))
    arrays = read_npz(tmp_path / "run/frames/000005.npz")
    assert list(arrays) == ["x", "v", "id", "solid_position", "solid_rotation", "time"]
    assert (frame.J_P, frame.material) == (None, None)
    for name in ("preview.mp4", "preview.png"):
        assert (tmp_path / "run" / name).stat().st_size > 1000


def test_it_is_resumed_to_the_same_bytes(tmp_path):
    """Stopped after two of five frames and resumed: each frame and the state are those of a run in one go."""
    run_scene(scene(film=False), tmp_path / "whole", quiet=True)
    run_scene(scene(film=False), tmp_path / "parts", frames=2, quiet=True)
    run_scene(scene(film=False), tmp_path / "parts", quiet=True, resume=True)
    for name in [f"frames/{i:06d}.npz" for i in range(6)] + ["checkpoint"]:
        assert (tmp_path / "whole" / name).read_bytes() == (tmp_path / "parts" / name).read_bytes(), name


def test_another_method_does_not_resume_it(tmp_path):
    """The sentence names the key, and what it was."""
    run_scene(scene(film=False), tmp_path / "run", frames=1, quiet=True)
    text = (tmp_path / "run/scene.toml").read_text()
    (tmp_path / "other.toml").write_text(text.replace('method = "grains"', 'method = "mpm"'))
    with pytest.raises(RunError, match=r"numerics\.method is 'grains' there and 'mpm' now"):
        run_scene(load(tmp_path / "other.toml"), tmp_path / "run", resume=True, quiet=True)


def test_it_is_viewed(tmp_path):
    """The page gets positions within half a step of its 16 bits, and the colours it has columns for."""
    sim = neve.Simulation(scene())
    sim.advance(0.05)
    snapshot = of_simulation(sim, {"speed"}, {}, 0, {}, 1)
    head, body = unframed(encode(snapshot, Colors("speed"), Scale(), 0))
    q = np.frombuffer(body, "<u2").reshape(-1, 4)
    seen = np.array(head["low"]) + np.array(head["step"]) * q[:, :3]
    np.testing.assert_allclose(seen, sim.state.x, atol=0.51 * max(head["step"]) + 1e-6)
    np.testing.assert_allclose(snapshot.values["speed"], G * 0.05, rtol=1e-5)


def test_a_page_plays_it(tmp_path):
    """Over the socket: grains as large as the solver says, a frame on command, and the floor beneath."""
    (tmp_path / "grains.toml").write_text(to_toml(scene(FLOOR)))

    async def talk(page, port):
        told = page.message("scene")
        assert told["spacing"] == pytest.approx(2 * RADIUS)
        assert [mode["name"] for mode in told["modes"]] == ["snow", "speed"]
        assert [solid["name"] for solid in told["solids"]] == ["colliders.0"]
        await page.send(do="frame")
        await page.until(lambda p: p.head["frame"] == 1)
        assert page.head["time"] == pytest.approx(1 / 50)

    converse(prepare(str(tmp_path / "grains.toml"), out=str(tmp_path / "out"), threads=1), talk)


def test_its_picture_has_its_grain_size(tmp_path, monkeypatch):
    """Grains of twice the radius make another picture of the same places."""
    pictures = []
    for radius in (RADIUS, RADIUS, 2 * RADIUS):
        monkeypatch.setattr(Grains, "radius", radius)
        folder = tmp_path / f"run{len(pictures)}"
        run_scene(scene(film=False, duration=0.02), folder, quiet=True)
        pictures.append((folder / "preview.png").read_bytes())
    assert pictures[0] == pictures[1] != pictures[2]


def test_a_floor_stops_it():
    """Grains that reach a plane stay on it, and it has taken the momentum that gravity gave them."""
    sim = neve.Simulation(scene({**FLOOR, "sources": [BALL | {"center": [0, 0, 0.4]}]}))
    sim.advance(0.5)
    z, v = sim.state.x[:, 2], sim.state.v[:, 2]
    assert z.min() > RADIUS - 0.01
    assert (v == 0).sum() > 0.1 * sim.count
    assert sim.exchanged[0, 2] == pytest.approx(-MASS * (sim.count * G * 0.5 + v.sum()), rel=1e-9)


def test_a_body_loses_what_it_gives():
    """Without gravity a body that flies into grains loses what they gain; resumed it does so bit by bit."""
    body = {"shape": "sphere", "radius": 0.2, "density": 400, "center": [0, 0, 1.4], "velocity": [0, 0, 2]}
    flying = scene({"world": {"gravity": [0, 0, 0]}, "bodies": [body]})
    sim = neve.Simulation(flying)
    before = sim.solver.rigid.momentum
    sim.advance(0.1)
    half = neve.Simulation.restore(flying, sim.arrays())
    sim.advance(0.1)
    half.advance(0.1)
    gained = MASS * sim.state.v.sum(axis=0)
    assert gained[2] > 0.05 * before[2]
    np.testing.assert_allclose(sim.solver.rigid.momentum + gained, before, atol=1e-9 * before[2])
    np.testing.assert_array_equal(half.state.x, sim.state.x)


def test_its_run_is_played(tmp_path):
    """A recorded run of it has its frames."""
    sim = run_scene(scene(film=False), tmp_path / "run", quiet=True)
    from neve.io.run_folder import RunFolder

    player = Recorded(RunFolder(tmp_path / "run"))
    player._begin()
    assert len(player.latest.x) == sim.count
    assert player.color_modes() == ["snow", "speed"]
    assert len(replay_page(RunFolder(tmp_path / "run"))) > 10_000


def test_what_it_lacks_is_one_sentence(tmp_path):
    """Fragments need masses; a change in a run needs a solver that can; a word needs to be registered."""
    with pytest.raises(RunError, match=r'numerics\.method = "grains" has no m or V0 or J_P'):
        run_scene(scene(film=False, fragments=True), tmp_path / "run", quiet=True)
    run_scene(scene(film=False), tmp_path / "flown", frames=1, quiet=True)
    with pytest.raises(RunError, match=r'numerics\.method = "grains" has no m or V0 or J_P'):
        count_run(tmp_path / "flown")
    sim = neve.Simulation(scene())
    with pytest.raises(SceneError, match=r'"grains" cannot add snow in a run'):
        sim.add(sim.scene.sources[0])
    with pytest.raises(SceneError, match=r'"grains" cannot change its scene in a run'):
        sim.change(sim.scene)
    with pytest.raises(SceneError, match=r"numerics\.method cannot change while a run goes on"):
        sim.change(load("throw_ball"))


def test_each_solver_says_what_is_fixed():
    """The spacing of MPM's grid and particles cannot change in a run; grains have none, so theirs could."""
    assert not is_live(load("throw_ball"), "numerics.dx")
    assert is_live(scene(), "numerics.dx")
    assert not is_live(scene(), "numerics.precision")


@pytest.mark.parametrize(
    ("key", "allowed"), [("method", 'use "mpm", "particles", "sph" or "grains"'), ("device", r'use "cpu"')]
)
def test_a_bad_word_says_what_is_allowed(tmp_path, key, allowed):
    """One sentence with key, value and the registered words."""
    path = tmp_path / "scene.toml"
    chosen = getattr(scene().numerics, key)
    path.write_text(to_toml(scene()).replace(f'{key} = "{chosen}"', f'{key} = "fem"'))
    with pytest.raises(SceneError, match=rf'numerics\.{key} = "fem" is not allowed.*: {allowed}'):
        load(path)
