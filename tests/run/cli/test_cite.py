"""What a scene asks to cite."""

import re

import pytest

from neve.cli import cite
from neve.cli.cite import METHODS, WORKS, bibtex, methods
from neve.scene.reading.load import load
from neve.scene.schema.scene import Numerics, Snow


def test_every_choice_of_a_scene_has_its_works():
    """Each law, spline and transfer that a scene may choose stands in the registry."""
    fields = [Snow.model_fields["law"], Numerics.model_fields["spline"], Numerics.model_fields["transfer"]]
    words = [word for field in fields for word in field.annotation.__args__]
    assert set(words) <= METHODS.keys()


def test_every_method_has_works_and_every_work_a_method():
    """No key without an entry, no entry that nothing uses."""
    assert {key for keys in METHODS.values() for key in keys} == WORKS.keys()


DOI_NOT_SEEN = {
    "akinci2012",
    "bernhardt2010",
    "calonne2011",
    "fearing2000",
    "gast2015",
    "gissler2020",
    "goswami2019",
    "li2022",
    "szabo2007",
    "takahashi2014",
}
"""Works whose DOI was in no source at hand: none is guessed."""


@pytest.mark.parametrize("key", WORKS)
def test_entries_are_bibtex(key):
    """An entry carries its key, balanced braces, an author, a title, a year and a DOI if there is one."""
    entry = WORKS[key]
    assert re.match(rf"@(article|inproceedings)\{{{key},\n", entry)
    assert entry.count("{") == entry.count("}")
    fields = dict(re.findall(r"^  (\w+) += \{((?:[^{}]|\{[^}]*\})*)\}", entry, re.M))
    assert {"author", "title", "year"} <= fields.keys()
    assert len({"journal", "booktitle"} & fields.keys()) == 1
    assert key.endswith(fields["year"])
    if "doi" in fields:
        assert fields["doi"].startswith("10.")
    else:
        assert int(fields["year"]) < 1980 or key in DOI_NOT_SEEN


def test_scene_cites_how_it_is_filled(scene_file):
    """Poisson sampling and noise are cited where they are used, and only there."""
    assert {"poisson", "variation"}.isdisjoint(methods(load(scene_file)))
    poisson = bibtex(load(scene_file, ['numerics.sampling="poisson"']))
    noisy = bibtex(load(scene_file, ["sources.0.variation.strength=0.5"]))
    assert ("{bridson2007," in poisson, "{perlin1985," in poisson) == (True, False)
    assert ("{bridson2007," in noisy, "{perlin1985," in noisy) == (False, True)


def test_scene_cites_what_it_uses(scene_file):
    """The transfer decides whom to cite; Neve itself and the snow model are always there."""
    apic, flip = (load(scene_file, [f'numerics.transfer="{word}"']) for word in ("apic", "flip"))
    assert methods(flip) == ["mpm", "stomakhin2013", "snow", "quadratic", "flip"]
    assert "@article{jiang2015," in bibtex(apic)
    assert "@article{zhu2005," not in bibtex(apic)
    assert "@article{zhu2005," in bibtex(flip)
    assert "@article{hu2018," not in bibtex(flip)
    for scene in (apic, flip):
        assert bibtex(scene).startswith("@software{neve,")
        assert "@article{stomakhin2013," in bibtex(scene)


def test_scene_cites_how_its_camera_moves(scene_file):
    """Curves through keyframes and the smoothing of a camera that follows, where they are used."""
    follows = bibtex(load(scene_file, ['camera.follow="snow"']))
    keyed = bibtex(load(scene_file, ["camera.keyframes=[{t=0.0}, {t=1.0, fov=20.0}]"]))
    assert ("{cleveland1979," in follows, "{fritsch1984," in follows) == (True, False)
    assert ("{cleveland1979," in keyed, "{fritsch1984," in keyed) == (False, True)


def test_scene_cites_meshes(scene_file):
    """What tells the inside of a mesh is cited where there is one: the hare as a body, and as snow."""
    assert "mesh" not in methods(load(scene_file))
    for change in ("colliders.0", "sources.0"):
        scene = load(scene_file, [f'{change}={{shape="mesh", file="neve:hare"}}'])
        assert "mesh" in methods(scene)
        assert "@article{barill2018," in bibtex(scene)


def test_scene_cites_the_engine_of_its_bodies(scene_file):
    """Who has bodies that snow moves cites what moves them; colliders do without."""
    assert "bodies" not in methods(load(scene_file))
    assert "{todorov2012," in bibtex(load(scene_file, ['bodies=[{shape="box"}]']))


def test_scene_cites_its_laws(scene_file):
    """The law and, where snow crushes and tears, the plasticity: one paper each, and no other's."""
    hard, elastic = (load(scene_file, ["snow.law=hencky", f"snow.plasticity={p}"]) for p in ("snow", "none"))
    assert {"hencky", "snow"} <= set(methods(hard))
    assert "snow" not in methods(elastic)
    assert "@article{klar2016," in bibtex(elastic)
    assert "@article{stomakhin2013," in bibtex(hard)
    assert "@article{stomakhin2013," not in bibtex(elastic)
    clay = load(scene_file, ['sources.0.snow={law="cam_clay"}'])
    assert "@article{li2020," in bibtex(clay)
    assert "@article{stomakhin2013," not in bibtex(clay)


def test_what_is_ones_own_is_named_without_an_entry(scene_file, monkeypatch):
    """A law whose works have no entry, and a solver that names none, end as comments, not as an error."""
    scene = load(scene_file)
    own = {**METHODS, scene.snow.law: ("me2026", "stomakhin2013")}
    del own[scene.numerics.method]
    monkeypatch.setattr(cite, "METHODS", own)
    text = bibtex(scene)
    comments = [line for line in text.splitlines() if line.startswith("%")]
    assert comments[0] == f"% {scene.numerics.method} names no work to cite"
    assert comments[1].startswith(f"% {scene.snow.law} cites me2026, without an entry here; its source: ")
    assert len(comments) == 2
    assert "@article{stomakhin2013," in text
    assert "@" not in "".join(comments)
