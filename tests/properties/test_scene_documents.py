"""Any document is a scene that survives writing and reading, or is refused in one sentence with its key."""

import contextlib
import math
import re
import tomllib

import pytest
import tomli_w
from hypothesis import assume, given
from hypothesis import strategies as st
from properties.documents import FILE_SHAPES, SPOILERS, documents, places, spoilt

import neve
from neve.cli import main
from neve.scene.errors import SceneError
from neve.scene.reading.load import scene_from, to_toml
from neve.scene.schema.scene import Scene
from neve.solver import Blowup

PARTICLES = 300


def told(error, where):
    """The sentence of a refusal: one line, of the file, with a key of the scene."""
    sentence = str(error)
    assert sentence.startswith(where), sentence
    assert "\n" not in sentence, sentence
    said = sentence.removeprefix(where)
    assert any(name in said for name in Scene.model_fields) or "is not a known key" in said, sentence
    assert not re.search(r"Traceback|Error\b|pydantic|<class|object at 0x", said), sentence
    return sentence


def scene_or_sentence(tables):
    """The scene of a document, or None for one that is refused as it should be."""
    try:
        return scene_from(tables, where="there.toml")
    except SceneError as error:
        told(error, "there.toml: ")
        return None


@given(documents)
def test_a_scene_survives_writing_and_reading(tables):
    """load(write(scene)) = scene, and what is written once more is the same text."""
    tables.setdefault("sources", [{"shape": "sphere"}])
    scene = scene_or_sentence(tables)
    assume(scene is not None)
    text = to_toml(scene)
    again = scene_from(tomllib.loads(text))
    assert again == scene
    assert to_toml(again) == text


@given(documents)
def test_a_scene_is_built_or_refused(tables):
    """A scene of few particles is built and goes a step, or is refused in a sentence."""
    tables["sources"] = tables.get("sources") or [{"shape": "sphere"}]
    for name in ("sources", "emitters", "colliders", "bodies"):
        tables[name] = [entry for entry in tables.get(name, []) if entry.get("shape") not in FILE_SHAPES]
    tables.pop("robots", None)
    scene = scene_or_sentence(tables)
    assume(scene is not None)
    scene = coarse(scene)
    assume(scene is not None)
    with contextlib.suppress(Blowup):
        try:
            sim = neve.Simulation(scene, threads=1)
        except SceneError as error:
            told(error, "")
            return
        assert sim.count > 0 or scene.is_open
        sim.advance(scene.run.duration, lambda: True)


def coarse(scene):
    """The scene with about PARTICLES particles at most, if its dx can be chosen so."""
    from neve.sampling.regions import region

    volume = sum(region(source, scene.numerics, "x").volume for source in scene.sources)
    size = max((2 * max(part.half_extents()) for part in (*scene.sources, *scene.emitters)), default=0.0)
    dx = max((volume / PARTICLES) ** (1 / 3), size / 50, scene.numerics.dx)
    if not dx <= 1000:
        return None
    numerics = scene.numerics.model_copy(update={"dx": dx, "particles_per_cell": 1})
    return scene.model_copy(update={"numerics": numerics})


@given(spoilt())
def test_a_spoilt_document_is_refused_in_one_sentence(tables):
    """Wrong types, missing keys, unknown words, nan, denormals, huge numbers, dates: never a traceback."""
    scene_or_sentence(tables)


@given(tables=spoilt())
def test_a_spoilt_file_is_refused_by_the_command_line(tables, tmp_path_factory, capsys):
    """`neve cite FILE`: exit code 0 with a scene, else 2 and one line that names the file."""
    path = tmp_path_factory.getbasetemp() / "spoilt.toml"
    try:
        path.write_text(tomli_w.dumps(tables), encoding="utf-8")
        tomllib.loads(path.read_text(encoding="utf-8"))
    except ValueError:  # what TOML cannot say
        return
    capsys.readouterr()
    with pytest.raises(SystemExit) as stop:
        main(["cite", str(path)])
    out, err = capsys.readouterr()
    if stop.value.code == 0:
        assert (err, out[:1]) == ("", "@")
        return
    assert (stop.value.code, out, err.count("\n")) == (2, "", 1)
    assert err.startswith(f"neve: {path}: ")


def texts(value):
    """A value as it stands after the equals sign of --set."""
    with contextlib.suppress(ValueError, TypeError):
        return tomli_w.dumps({"v": value}).partition("=")[2].strip() or "{}"
    return str(value)


ALL = scene_from({"sources": [{"shape": "sphere"}], "colliders": [{"shape": "plane"}]}).model_dump(
    mode="json"
)
PATHS = st.sampled_from([".".join(map(str, path)) for path in places(ALL)]) | st.text(max_size=12)


@given(PATHS, SPOILERS.map(texts) | st.text(max_size=20), st.sampled_from(["throw_ball", "wheel"]))
def test_any_override_is_a_scene_or_a_sentence(key, value, preset):
    """`--set KEY=VALUE` for keys of the schema and others, and values of any kind."""
    text = f"{key}={value}"
    try:
        scene = neve.load(preset, [text])
    except SceneError as error:
        sentence = str(error)
    else:
        assert math.isfinite(scene.numerics.dx)
        return
    assert sentence.startswith(("--set ", f"preset {preset}: "))
    assert "\n" not in sentence.removeprefix(f"--set {text}")
