"""What pages may say, and what the panel makes of the scene's fields."""

import json

import pytest

from neve.scene.errors import SceneError
from neve.scene.reading.load import load
from neve.scene.reading.presets import presets
from neve.scene.schema.material import used
from neve.scene.schema.scene import Scene, Variation
from neve.viewer import safety
from neve.viewer.protocol import commands
from neve.viewer.tools import change, edit, panel

GOOD = [
    {"do": "play"},
    {"do": "acknowledge", "version": 3},
    {"do": "set", "path": "snow.xi", "value": 12.5},
    {"do": "set", "path": "world.gravity", "value": [0, 0, -1.6]},
    {"do": "throw", "origin": [0, 0, 1], "direction": [1, 0, 0], "speed": 9, "radius": 0.2},
    {"do": "move", "name": "colliders.1", "position": [0, 0, 1], "rotation": [0, 0, 45], "done": True},
    {"do": "picture", "camera": {"position": [1, 1, 1], "target": [0, 0, 0], "width": 640, "height": 360}},
]
RUBBISH = [
    "", "{", "null", "[]", "42", '"play"', '{"do": "rm"}', '{"do": "play", "now": true}', b"\xff\xfe\x00",
    '{"do": "seek", "frame": -1}', '{"do": "seek", "frame": 1e400}', '{"do": "speed", "factor": NaN}',
    '{"do": "throw", "origin": [0, 0, Infinity], "direction": [1, 0, 0]}',
    '{"do": "throw", "origin": [0, 0], "direction": [1, 0, 0]}',
    '{"do": "picture", "camera": {"position": [1,1,1], "target": [0,0,0], "width": 100000, "height": 9}}',
    "[" * 10_000, json.dumps({"do": "open", "scene": "x" * 300}), "x" * 100_000,
]  # fmt: skip


@pytest.mark.parametrize("sent", GOOD, ids=lambda sent: sent["do"])
def test_commands_are_read(sent):
    """Each comes back as the command of its name with its values."""
    command = commands.read(json.dumps(sent))
    assert command is not None
    assert command.do == sent["do"]


@pytest.mark.parametrize("message", RUBBISH, ids=range(len(RUBBISH)))
def test_rubbish_is_dropped(message):
    """What is no command is None, never an exception."""
    assert commands.read(message) is None


@pytest.mark.parametrize("name", presets())
def test_panel_tells_all_values_of_all_scenes(name):
    """Each field that the panel shows has meaning, unit, control and the scene's own value."""
    scene = load(name)
    sections = {s["path"]: s for s in panel.panel(scene)}
    assert set(panel.SECTIONS) <= set(sections)
    for section in sections.values():
        for field in section["fields"]:
            assert field["text"]
            assert field["allowed"]
            assert field["control"] in ("number", "choice", "switch", "vector", "list", "text")
    shown = [f["name"] for f in sections["snow"]["fields"]]
    assert sorted(shown) == sorted(
        ["kind", "law", "plasticity", *used(scene.snow.law, scene.snow.plasticity)]
    )
    E0 = next(f for f in sections["snow"]["fields"] if f["name"] == "E0")
    field = Scene.model_fields["snow"].annotation.model_fields["E0"]
    assert E0["value"] == scene.snow.E0
    assert E0["unit"] == "Pa"
    assert E0["text"] == field.description
    assert E0["gt"] == 0
    assert json.dumps(panel.panel(scene))


def test_panel_values_can_be_set_back():
    """Setting every shown field to its own value gives an equal scene: it takes what it shows."""
    scene = load("throw_ball")
    for section in panel.panel(scene):
        for field in section["fields"]:
            if field["path"] not in ("snow.kind", "snow.law"):
                assert change.changed(scene, field["path"], field["value"]) == scene


def test_wrong_values_get_the_sentence_of_the_scene():
    """Range, rule between fields, unknown key and wrong kind are each told in one sentence."""
    scene = load("collide", ['snow={kind="reference"}'])
    for path, value, told in [
        ("snow.nu", 0.7, "snow.nu = 0.7 is not allowed"),
        ("snow.xi", 80.0, "xi theta_c and xi theta_s at most 0.5"),
        ("snow.hardness", 1.0, "snow.hardness is not a known key"),
        ("snow.E0", "soft", "snow.E0"),
        ("numerics.transfer", "apicc", "did you mean"),
        ("colliders.7.mu_c", 0.1, "colliders.7.mu_c is not in this scene"),
        ("sources", 3.0, "sources"),
        ("..", 3.0, "is not in this scene"),
    ]:
        with pytest.raises(SceneError) as error:
            change.changed(scene, path, value)
        assert told in str(error.value)
        assert "\n" not in str(error.value)


def test_another_kind_of_snow_brings_its_constants():
    """kind and law replace the whole table, as in a file that names nothing else."""
    scene = load("throw_ball")
    assert change.changed(scene, "snow.kind", "powder").snow.kind == "powder"
    assert change.changed(scene, "snow.law", "cam_clay").snow.rho0 == 250.0


def test_what_acts_at_once():
    """Constants, friction, gravity and transfer act on a run; what the state was made of waits."""
    scene = load("throw_ball")
    assert all(
        change.is_live(scene, path)
        for path in ("snow.E0", "colliders.0.mu_c", "world.gravity", "numerics.transfer", "sources.0.snow.xi")
    )
    assert not any(
        change.is_live(scene, path)
        for path in ("numerics.dx", "numerics.seed", "sources.0.radius", "run.fps")
    )


def test_entries_are_added_moved_and_deleted():
    """Every shape of every list can be added at a point and deleted again."""
    scene = load("throw_ball")
    for kind, shape in [
        ("colliders", "box"),
        ("colliders", "sphere"),
        ("sources", "cylinder"),
        ("sources", "layer"),
    ]:
        new_scene, source = edit.added(scene, commands.Add(do="add", kind=kind, shape=shape, at=(1, 2, 0)))
        assert (source is not None) == (kind == "sources")
        name = f"{kind}.{len(getattr(new_scene, kind)) - 1}"
        assert getattr(new_scene, kind)[-1].center[:2] == (1.0, 2.0)
        assert edit.deleted(new_scene, name) == scene
    new_scene, _ = edit.added(scene, commands.Add(do="add", kind="colliders", shape="box", at=(0, 0, 0)))
    move = commands.Move(do="move", name="colliders.1", position=(3, 0, 1), rotation=(0, 0, 30))
    moved = edit.placed(new_scene, move).colliders[1]
    assert moved.center == (3.0, 0.0, 1.0)
    assert moved.rotation == (0.0, 0.0, 30.0)
    for bad in ("colliders.9", "camera.0", "colliders", "colliders.-1", "../x"):
        with pytest.raises(SceneError, match="not in this scene"):
            edit.deleted(scene, bad)
    with pytest.raises(SceneError, match="sources"):
        edit.deleted(scene, "sources.0")  # a scene without snow is no scene


def test_tables_in_entries_are_shown_made_and_taken_away():
    """A list of tables grows by its last entry, a second later; an optional table comes and goes."""
    scene, _ = edit.added(
        load("ball_on_snow", ["bodies=[]"]),
        commands.Add(do="add", kind="colliders", shape="box", at=(0, 0, 0)),
    )
    path = "colliders.1.keyframes"
    grown = edit.enlarged(edit.enlarged(scene, path), path)
    assert [k.t for k in grown.colliders[1].keyframes] == [0.0, 1.0]
    told = {s["path"]: s for s in panel.panel(grown)}
    assert (told[path]["parent"], told[path]["can"]) == ("colliders.1", "add")
    assert (told[f"{path}.1"]["parent"], told[f"{path}.1"]["can"]) == (path, "delete")
    set_ = change.changed(grown, f"{path}.1.position", [0, 0, 2])
    assert set_.colliders[1].keyframes[1].position == (0.0, 0.0, 2.0)
    assert edit.deleted(edit.deleted(grown, f"{path}.1"), f"{path}.0") == scene

    even = edit.deleted(scene, "sources.0.variation")
    assert even.sources[0].variation is None
    assert edit.enlarged(even, "sources.0.variation").sources[0].variation == Variation()
    factors = change.changed(
        change.changed(edit.enlarged(scene, "sources.0.profile"), "sources.0.profile.at", [0.0, 0.1]),
        "sources.0.profile.stiffness", [1, 2],
    )  # fmt: skip
    assert factors.sources[0].profile.stiffness == (1.0, 2.0)
    assert change.changed(scene, "sources.0.snow.kind", "powder").sources[0].snow.kind == "powder"
    for bad in ("colliders.1.size", "colliders.1", "numerics.dx", "colliders.1.nothing", "sources.9.profile"):
        with pytest.raises(SceneError, match=r"not in this scene|not a table"):
            edit.enlarged(scene, bad)
    for bad in ("colliders.1.size", "colliders.1.center", "world.gravity", "camera", path):
        with pytest.raises(SceneError, match="not in this scene"):
            edit.deleted(scene, bad)


@pytest.mark.parametrize(
    ("header", "host", "allowed"),
    [
        ("127.0.0.1:8420", "127.0.0.1", True),
        ("LocalHost", "127.0.0.1", True),
        ("[::1]:8420", "127.0.0.1", True),
        ("192.168.1.7:8420", "0.0.0.0", True),
        ("snow.example:8420", "127.0.0.1", False),
        ("snow.example", "0.0.0.0", False),
        ("snow.example", "snow.example", True),
        ("localhost.evil.example", "127.0.0.1", False),
        ("", "127.0.0.1", False),
        ("[::1", "127.0.0.1", False),
        ("127.0.0.1:80:80", "127.0.0.1", False),
    ],
)
def test_host_names(header, host, allowed):
    """Numbers and this machine's names are right; a name that some page made point here is not."""
    assert safety.host_allowed(header, host) == allowed


def test_origins():
    """A browser's page must come from this server; a program says nothing."""
    assert safety.same_origin([], "127.0.0.1:1")
    assert safety.same_origin(["http://127.0.0.1:1"], "127.0.0.1:1")
    assert not safety.same_origin(["http://127.0.0.1:2"], "127.0.0.1:1")
    assert not safety.same_origin(["null"], "127.0.0.1:1")
    assert not safety.same_origin(["http://evil.example"], "127.0.0.1:1")
    assert not safety.same_origin(["http://127.0.0.1:1"] * 2, "127.0.0.1:1")
