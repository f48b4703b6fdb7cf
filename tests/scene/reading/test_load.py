"""Loading, overriding and writing scenes."""

from __future__ import annotations

import tomllib
from pathlib import Path

import pytest

from neve.scene.reading.load import load, scene_from, to_toml
from neve.scene.reading.presets import preset_about, presets
from neve.scene.schema.file_shapes import Text
from neve.scene.schema.roles import forms
from neve.scene.schema.scene import Collider, Scene, Source, Variation
from neve.scene.schema.shapes import Box

BOX = '[[sources]]\nshape = "box"\n'


@pytest.mark.parametrize("name", presets())
def test_preset_round_trip(name: str, tmp_path: Path) -> None:
    """A preset, written completely and loaded again, is equal; writing it again gives the same text."""
    scene = load(name)
    text = to_toml(scene)
    path = tmp_path / "scene.toml"
    path.write_text(text)
    assert load(path) == scene
    assert load(tmp_path) == scene
    assert to_toml(load(path)) == text


def test_written_scene_spells_out_every_default() -> None:
    """What to_toml writes holds every key of every section."""
    scene = scene_from({"sources": [{"shape": "box"}], "colliders": [{"shape": "plane"}]})
    written = tomllib.loads(to_toml(scene))
    assert set(written) == set(Scene.model_fields) - {"heat"}, "left out, there is none"
    assert set(written["numerics"]) == set(type(scene.numerics).model_fields)
    assert set(written["snow"]) == set(type(scene.snow).model_fields)
    assert set(written["sources"][0]) == set(forms(Source)["box"].model_fields) - {
        "structure",
        "variation",
        "profile",
    }, "left out, they follow the kind of the snow"
    assert set(written["colliders"][0]) == set(forms(Collider)["plane"].model_fields) - {"color", "finish"}, (
        "a colour or finish left out stays left out"
    )


def test_presets_are_all_there() -> None:
    """The scenes are there, each with one line that says what happens."""
    bodies = ["avalanche", "ball_on_snow", "boot", "castle", "roll", "walk", "wave", "wheel"]
    names = ["collide", "cube_on_snow", "plow", "snowball_wall", "snowballs_collide", "text_fall"]
    thawing = ["thaw"]
    contacts = ["melt", "walk_live", "wall_plough"]
    smoothed = ["bridge", "heap", "pressed", "weights"]
    snowed = ["car_overnight", "pine", "porch", "village"]
    assert presets() == sorted(
        [*bodies, *names, *thawing, *contacts, *smoothed, *snowed, "throw_ball", "throw_cube"]
    )
    for name in presets():
        about = preset_about(name)
        assert about == load(name).about
        assert about
        assert "\n" not in about


def test_overrides_reach_every_kind_of_key(tmp_path: Path) -> None:
    """Numbers, words, entries of lists, components of vectors (given or default), text without quotes."""
    path = tmp_path / "a.toml"
    path.write_text(BOX + "size = [1, 2, 3]\n")
    changes = [
        "numerics.dx=0.02",
        "numerics.transfer=flip",
        "numerics.dt=1e-4",
        "world.gravity.2=-1.62",
        "sources.0.size.1=0.5",
        "sources.0.spin.0=2",
        "sources.0.snow.xi=5",
        "sources.0.variation.stiffness=0.7",
        "about=a = b",
        'colliders=[{shape="plane"}]',
        "colliders.0.mode=sticky",
        "run.film=false",
        "numerics.dx=0.03",
    ]
    scene = load(path, changes)
    box = scene.sources[0]
    assert isinstance(box, Box)
    assert (scene.numerics.dx, scene.numerics.transfer, scene.numerics.dt) == (0.03, "flip", 1e-4)
    assert scene.world.gravity == (0.0, 0.0, -1.62)
    assert (box.size, box.spin) == ((1.0, 0.5, 3.0), (2.0, 0.0, 0.0))
    assert (box.snow.xi, box.variation) == (5.0, Variation(stiffness=0.7))
    assert (scene.about, scene.colliders[0].mode, scene.run.film) == ("a = b", "sticky", False)


def test_snow_of_a_source() -> None:
    """A source's snow is the scene's, with its own overrides."""
    scene = scene_from(
        {"snow": {"rho0": 300.0}, "sources": [{"shape": "box", "snow": {"xi": 5}}, {"shape": "box"}]}
    )
    first, second = scene.sources
    assert (scene.snow_of(first).rho0, scene.snow_of(first).xi) == (300.0, 5.0)
    assert scene.snow_of(second) == scene.snow


def test_font_is_relative_to_the_scene_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A font of a file lies beside the file; a font of an override is looked for from the current folder."""
    folder, elsewhere = tmp_path / "scenes", tmp_path / "fonts"
    for place in (folder, elsewhere):
        place.mkdir()
        (place / "a.ttf").write_bytes(b"a font")
    (folder / "a.toml").write_text('[[sources]]\nshape = "text"\nfont = "a.ttf"\n')
    monkeypatch.chdir(elsewhere)
    own, other = load(folder / "a.toml").sources[0], load("text_fall", ["sources.0.font=a.ttf"]).sources[0]
    assert isinstance(own, Text)
    assert isinstance(other, Text)
    assert own.font == str(folder / "a.ttf")
    assert other.font == str(elsewhere / "a.ttf")


def test_preset_wins_over_a_folder_of_the_same_name(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """`neve run plow` works beside a folder named plow."""
    (tmp_path / "plow").mkdir()
    monkeypatch.chdir(tmp_path)
    assert load("plow").about == preset_about("plow")


def test_file_with_a_byte_order_mark(tmp_path: Path) -> None:
    """Editors on Windows begin a file with a mark and end lines with two characters."""
    path = tmp_path / "a.toml"
    path.write_bytes(b"\xef\xbb\xbf" + BOX.replace("\n", "\r\n").encode())
    assert len(load(path).sources) == 1


def test_loading_leaves_the_tables_alone() -> None:
    """scene_from does not change what it is given."""
    tables = {"sources": [{"shape": "box", "size": [1, 1, 1]}]}
    scene_from(tables, ["sources.0.size.0=2", "numerics.dx=0.1"])
    assert tables == {"sources": [{"shape": "box", "size": [1, 1, 1]}]}
