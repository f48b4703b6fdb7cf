"""Outputs of one's own: registered by name, asked for by a scene, or given as objects."""

import csv
from dataclasses import dataclass

import pytest

import neve
from neve.io.errors import RunError
from neve.run import run, run_scene
from neve.run.outputs import registry
from neve.scene.errors import SceneError
from neve.scene.reading.load import load, to_toml
from neve.schedule import EveryFrames


@pytest.fixture(autouse=True)
def only_here(monkeypatch):
    """What a test registers is forgotten after it."""
    registry.kinds()
    monkeypatch.setattr(registry, "_kinds", dict(registry._kinds))


@pytest.fixture
def peak():
    """An output that writes the greatest height times a factor."""

    @neve.register_output("peak")
    @dataclass
    class Peak:
        name: str = "peak.csv"
        factor: float = 1.0

        def write(self, context):
            context.add_row(self.name, {"height": self.factor * float(context.content.x[:, 2].max())})

        def close(self, context):
            pass

    return Peak


ASKED = """
[[outputs]]
kind = "peak"
every_frames = 3

[[outputs]]
kind = "peak"
name = "b.csv"
factor = 2.0
"""


@pytest.fixture
def asking(peak, scene_file):
    """The small scene of eight frames with two tables of one's own."""
    scene_file.write_text(scene_file.read_text() + ASKED)
    return load(scene_file)


def rows(path):
    with open(path, newline="") as file:
        return list(csv.DictReader(file))


def test_scene_asks_for_it(fake, asking, tmp_path):
    """Each entry has its table, schedule and options; the scene of the folder asks for the same."""
    out = tmp_path / "ball"
    run(fake.Simulation(asking), out, quiet=True)
    single, double = rows(out / "peak.csv"), rows(out / "b.csv")
    assert [row["frame"] for row in single] == ["0", "3", "6"]
    assert [row["frame"] for row in double] == [str(k) for k in range(9)]
    for row in single:
        assert float(double[int(row["frame"])]["height"]) == 2.0 * float(row["height"])
    assert load(out) == asking
    assert load(out).outputs[1].options() == {"name": "b.csv", "factor": 2.0}


@pytest.mark.parametrize("stop", [1, 3, 4])
def test_resumed_rows_are_the_same(fake, asking, tmp_path, stop):
    """A stopped and resumed run has the same tables; rows beyond the checkpoint are written again."""
    straight, parted = tmp_path / "straight", tmp_path / "parted"
    run(fake.Simulation(asking), straight, quiet=True)
    run(fake.Simulation(asking), parted, frames=stop, quiet=True)
    with open(parted / "b.csv", "a") as file:
        file.write(f"{stop + 1},0.3,7.0\n{stop + 2},0.")
    run_scene(asking, parted, resume=True, quiet=True)
    for name in ("peak.csv", "b.csv"):
        assert (parted / name).read_bytes() == (straight / name).read_bytes()


def test_object_in_a_run(fake, peak, scene, tmp_path):
    """An object has the schedule that it carries, or every frame; its table goes when the run is replaced."""
    out = tmp_path / "ball"
    seldom = peak("seldom.csv")
    seldom.schedule = EveryFrames(4)
    run(fake.Simulation(scene), out, quiet=True, outputs=[seldom, peak("often.csv")])
    assert [row["frame"] for row in rows(out / "seldom.csv")] == ["0", "4", "8"]
    assert len(rows(out / "often.csv")) == 9
    run(fake.Simulation(scene), out, frames=1, force=True, quiet=True)
    assert not [name for name in ("often.csv", "seldom.csv") if (out / name).exists()]


def test_wrong_options_are_one_sentence(peak, scene_file):
    """Options of one's own are checked as all others are, without conversions."""
    for entry, words in {
        'factor = "2"': 'outputs.0.factor = "2" is not allowed: use a number',
        "faktor = 2.0": "outputs.0.faktor is not a known key of the output peak (did you mean factor?)",
        'name = "../peak.csv"': "it must be the name of a file",
        'name = "log.csv"': "it must not be log.csv, which the output log writes",
    }.items():
        path = scene_file.with_name("wrong.toml")
        path.write_text(f'{scene_file.read_text()}\n[[outputs]]\nkind = "peak"\n{entry}\n')
        with pytest.raises(SceneError) as error:
            load(path)
        assert words in str(error.value)


def test_what_cannot_be_registered():
    """The name of an output that comes with Neve, and a parameter without default, are refused."""
    with pytest.raises(ValueError, match='"film" is an output that comes with Neve'):

        @neve.register_output("film")
        class Film:
            pass

    with pytest.raises(ValueError, match='give "name" a default'):

        @neve.register_output("bare")
        class Bare:
            def __init__(self, name):
                self.name = name

    with pytest.raises(ValueError, match='"mute" needs a method write and close'):

        @neve.register_output("mute")
        class Mute:
            pass

    for parameter in ("kind", "file", "every_frames", "_hidden"):

        class Clash:
            def write(self, context):
                pass

            close = write

        exec(f"def made(self, {parameter}='a'): pass\nClash.__init__ = made", {"Clash": Clash})
        with pytest.raises(ValueError, match=f'call "{parameter}" otherwise'):
            neve.register_output("clash")(Clash)
    assert not {"bare", "mute", "clash"} & set(registry.kinds())


class Writer:
    """An output that does what a test says."""

    def __init__(self, *rows):
        self.rows = rows

    def write(self, context):
        for name, row in self.rows:
            context.add_row(name, row)

    def close(self, context):
        pass


@pytest.mark.parametrize(
    "name", ["scene.toml", "run.json", "checkpoint", "log.csv", "../r.csv", "a/b.csv", ""]
)
def test_table_over_a_file_of_the_run(fake, scene, tmp_path, name):
    """A table has a name of its own and lies in the run folder."""
    with pytest.raises(RunError, match="cannot be a table of a run"):
        run(fake.Simulation(scene), tmp_path / "ball", quiet=True, outputs=[Writer((name, {"a": 1}))])
    assert not (tmp_path / "r.csv").exists()


def test_rows_with_other_columns(fake, scene, tmp_path):
    """The rows of a table have the same columns."""
    writer = Writer(("own.csv", {"a": 1}), ("own.csv", {"b": 2}))
    with pytest.raises(RunError, match="a row cannot have others"):
        run(fake.Simulation(scene), tmp_path / "ball", quiet=True, outputs=[writer])


@pytest.mark.parametrize("key", ["frame", "time"])
def test_a_row_has_one_frame_and_one_time(fake, scene, tmp_path, key):
    """A value of one's own does not take the place of the number or the time of the frame."""

    class Rows:
        def write(self, context):
            context.add_row("own.csv", {key: 7})

        def close(self, context):
            pass

    with pytest.raises(RunError, match=f"cannot have a value {key} of its own"):
        run(fake.Simulation(scene), tmp_path / "out", outputs=[Rows()], quiet=True)


@pytest.mark.parametrize("name", ["", "a b", "../a", "1", "a\n", "."])
def test_names_that_are_none(name, peak):
    """An output has a name of letters and digits, and no two classes the same one."""
    with pytest.raises(ValueError, match="is no name of an output"):
        neve.register_output(name)(peak)
    with pytest.raises(ValueError, match="is registered already"):
        neve.register_output("peak")(Writer)
    neve.register_output("peak")(peak)


def test_scene_in_python(peak, scene):
    """A scene takes entries made in Python, and writes them as tables."""
    entry = registry.kinds()["peak"].options(every_seconds=0.1, factor=3.0)
    changed = scene.model_copy(update={"outputs": (entry,)})
    assert 'kind = "peak"' in to_toml(changed)
    assert "every_seconds = 0.1" in to_toml(changed)
