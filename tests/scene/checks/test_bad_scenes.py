"""Every wrong scene is one sentence that names the key, the value and what is allowed."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from neve.scene.errors import SceneError
from neve.scene.reading.load import load, scene_from
from neve.scene.reading.presets import preset_about
from neve.scene.schema.material import Snow

BOX = '[[sources]]\nshape = "box"\nsize = [1, 1, 1]\n'
PLANE = '[[colliders]]\nshape = "plane"\n'

# What is wrong in the file -> what the sentence must say.
BAD_FILES: list[tuple[str, tuple[str, ...]]] = [
    (BOX + "[numerics]\ndx = -1", ("numerics.dx = -1", "from 1e-09 to 1000 [m]")),
    (BOX + "[numerics]\ndx = 0", ("numerics.dx = 0", "from 1e-09")),
    (BOX + '[numerics]\ndx = "small"', ('numerics.dx = "small"', "a number")),
    (BOX + "[numerics]\ndx = true", ("numerics.dx = true", "a number")),
    (BOX + "[numerics]\nDX = 1", ("numerics.DX is not a known key", "did you mean dx?", "flip_alpha")),
    (BOX + "[numercs]\ndx = 1", ("numercs is not a known key", "did you mean numerics?")),
    ("dx = 0.1\n" + BOX, ("dx is not a known key", "did you mean numerics.dx?")),
    ("g = 9.81\n" + BOX, ("g is not a known key", "did you mean world.gravity?")),
    (BOX + "[numerics]\ndt = 0", ("numerics.dt = 0", '"auto" or a number from 1e-09 to 1 [s]')),
    (BOX + '[numerics]\ndt = "atuo"', ('numerics.dt = "atuo"', 'did you mean "auto"?')),
    (BOX + '[numerics]\nspline = "quadric"', ("numerics.spline", 'did you mean "quadratic"?', '"cubic"')),
    (
        BOX + '[numerics]\ntransfer = "rpic"',
        ('numerics.transfer = "rpic"', 'did you mean "pic"?', '"apic"'),
    ),
    (BOX + "[numerics]\npolypic_modes = 9", ("numerics.polypic_modes = 9", "use 1, 4, 8 or 27")),
    (BOX + "[numerics]\npolypic_modes = true", ("numerics.polypic_modes = true", "use 1, 4, 8 or 27")),
    (BOX + "[numerics]\nflip_damping = -1", ("numerics.flip_damping = -1", '"off" or a number from 0')),
    (BOX + "[numerics]\nprecision = 32", ("numerics.precision = 32", '"float32" or "float64"')),
    (BOX + "[numerics]\nseed = -1", ("numerics.seed = -1", "at least 0")),
    (BOX + "[numerics]\nseed = 1.5", ("numerics.seed = 1.5", "a whole number")),
    (BOX + "[numerics]\nparticles_per_cell = 0", ("numerics.particles_per_cell = 0", "from 1 to 512")),
    (BOX + "[numerics]\ncfl = 1.5", ("numerics.cfl = 1.5", "to 0.6")),
    (BOX + "[snow]\nnu = 0.5", ("snow.nu = 0.5", "at least 0 and less than 0.5")),
    (BOX + "[snow]\ntheta_c = 1", ("snow.theta_c = 1", "less than 1")),
    (BOX + "[snow]\ntheta_c = nan", ("snow.theta_c = nan", "a number")),
    (BOX + "[snow]\nE0 = inf", ("snow.E0 = inf", "[Pa]")),
    (BOX + "[snow]\nJ_P_min = 1.2", ("snow.J_P_min = 1.2", "less than 1")),
    (BOX + "[snow]\nJ_P_max = 0.5", ("snow.J_P_max = 0.5", "greater than 1")),
    (BOX + "[snow]\ndensity = 300", ("snow.density is not a known key", "did you mean rho0?")),
    (BOX + '[snow]\nlaw = "stomakin"', ("snow.law", 'did you mean "stomakhin2013"?')),
    (BOX + '[snow]\nlaw = "hencki"', ("snow.law", 'did you mean "hencky"?', '"cam_clay"')),
    (BOX + '[snow]\nkind = "powdr"', ("snow.kind", 'did you mean "powder"?', '"crust"')),
    (BOX + '[snow]\nplasticity = "elastic"', ("snow.plasticity", '"snow" or "none"')),
    (BOX + "[snow]\nxi = 30", ("snow.xi = 30 is not allowed: it must be at most 20 with theta_c = 0.025",)),
    (BOX + "[snow]\ntheta_s = 0.2", ("snow.theta_s = 0.2", "at most 0.05 with xi = 10")),
    (BOX + '[snow]\nlaw = "cam_clay"\ntheta_c = 0.03', ("snow.theta_c = 0.03", "cam_clay", "M, beta, p0")),
    (BOX + '[snow]\nplasticity = "none"\nxi = 3', ("snow.xi = 3", 'plasticity = "none"', "default, 10")),
    (BOX + "[snow]\nfriction_angle = 30", ("snow.friction_angle = 30", 'law = "stomakhin2013"')),
    (BOX + '[snow]\nkind = "icy"\nlaw = "cam_clay"', ('snow.law = "cam_clay"', 'does not fit kind = "icy"')),
    (BOX + '[snow]\nlaw = "cam_clay"\nxi = 0', ("snow.xi = 0", "at least 0.0001")),
    (BOX + '[snow]\nlaw = "cam_clay"\np0 = 1e6', ("snow.p0 = 1000000.0", "at most 2.5e+05")),
    (BOX + '[snow]\nlaw = "cam_clay"\nE0 = 1e4', ("snow.E0 = 10000.0", "set p0 to at most 833")),
    (
        BOX + '[snow]\nlaw = "drucker_prager"\nfriction_angle = 45\ncohesion = 1e5',
        ("snow.cohesion = 100000.0", "at most 2.91e+04", "friction_angle"),
    ),
    (BOX + "snow = { xi = 50 }", ("sources.0.snow.xi = 50", "at most 20 with theta_c")),
    (BOX + 'snow = { law = "cam_clay", theta_c = 0.03 }', ("sources.0.snow.theta_c = 0.03", "cam_clay")),
    (BOX + 'snow = { kind = "wets" }', ("sources.0.snow.kind", 'did you mean "wet"?')),
    (
        BOX + 'snow = { plasticity = "none" }\n[snow]\nkind = "slush"',
        ("sources.0.snow.plasticity", "cam_clay"),
    ),
    (BOX + "[world]\ngravity = [0, 0]", ("world.gravity = [0, 0]", "three numbers", "[m/s2]")),
    (BOX + "[world]\ngravity = [0, 0, 0, 1]", ("world.gravity = [0, 0, 0, 1]", "three numbers")),
    (BOX + "[world]\ngravity = 9.81", ("world.gravity = 9.81", "three numbers")),
    (BOX + "[world]\ngravity = [0, 0, inf]", ("world.gravity = [0, 0, inf]", "three numbers")),
    ("camera = 5\n" + BOX, ("camera = 5", "a table")),
    (BOX + "[camera]\nposition = [0, 0, 0.5]", ("camera.target", "must differ from camera.position")),
    (BOX + "[camera]\nup = [0, 0, 0]", ("camera.up = [0, 0, 0]", "must not be zero")),
    (BOX + "[camera]\nfov = 180", ("camera.fov = 180", "less than 170 [degrees]")),
    (BOX + "[light]\nsun_color = [2, 0, 0]", ("light.sun_color = [2, 0, 0]", "three numbers from 0 to 1")),
    (BOX + "[light]\nsun_elevation = -5", ("light.sun_elevation = -5", "greater than 0 and at most 90")),
    (BOX + '[run]\nfilm = "yes"', ('run.film = "yes"', "true or false")),
    (BOX + "[run]\nduration = 2024-01-01", ('run.duration = "2024-01-01"', "a number")),
    (BOX + "[run]\nfps = 29.97", ("run.fps = 29.97", "a whole number from 1")),
    ("", ("sources needs at least one entry", "[[sources]]")),
    ("sources = []", ("sources = []", "needs at least one entry")),
    ("sources = 5", ("sources = 5", "a list of tables", "[[sources]]")),
    (
        "sources = [5]",
        ("sources.0 = 5", '"box", "sphere", "cylinder", "layer", "text", "mesh", "snowfall" or "lying"'),
    ),
    ('[sources]\nshape = "box"', ("sources = a table", "[[sources]]")),
    ("[[sources]]\nradius = 1", ("sources.0 has no shape", '"sphere"')),
    ('[[sources]]\nshape = "shere"', ('sources.0.shape = "shere"', 'did you mean "sphere"?')),
    ('[[sources]]\nshape = "box"\nradius = 1', ("sources.0.radius is not a known key of a box", "size")),
    ('[[sources]]\nshape = "box"\nsiez = 1', ("sources.0.siez", "did you mean size?")),
    ('[[sources]]\nshape = "sphere"\nradius = 1e-320', ("sources.0.radius = 1e-320", "from 1e-09")),
    (BOX + "[numerics]\ndx = 5e-324", ("numerics.dx = 5e-324", "from 1e-09")),
    ('[[sources]]\nshape = "box"\nsize = [1, 0, 1]', ("sources.0.size = [1, 0, 1]", "from 1e-09")),
    ('[[sources]]\nshape = "sphere"\nradius = 1e7', ("sources.0.radius = 10000000.0", "to 1000000 [m]")),
    ('[[sources]]\nshape = "layer"\ncenter = [0, 0, 0]', ("sources.0.center = [0, 0, 0]", "two numbers")),
    ('[[sources]]\nshape = "text"\ntext = " "', ('sources.0.text = " "', "at least one letter")),
    ('[[sources]]\nshape = "text"\ntext = 7', ("sources.0.text = 7", "text in quotes")),
    ('[[sources]]\nshape = "text"\nfont = "~nosuchuser/b.ttf"', ('"~nosuchuser/b.ttf" is not a file',)),
    ('[[sources]]\nshape = "text"\nfont = "a\\u0000b.ttf"', ('"a\\u0000b.ttf" is not a file',)),
    (f'[[sources]]\nshape = "text"\nfont = "{"x" * 300}"', ("is not a file; name a .ttf",)),
    ('[[sources]]\nshape = "text"\nfont = "no.ttf"', ("sources.0.font", "no.ttf", ".ttf or .otf")),
    (BOX + "snow = { xi = -5 }", ("sources.0.snow.xi = -5", "from 0 to 100")),
    (BOX + "snow = { hardening = 5 }", ("sources.0.snow.hardening", "did you mean xi?")),
    (BOX + "stiffness_noise = { amplitude = 1 }", ("sources.0.stiffness_noise", "did you mean variation?")),
    (BOX + "variation = { amplitude = 1 }", ("sources.0.variation.amplitude", "did you mean stiffness?")),
    (BOX + "variation = { octaves = 99 }", ("sources.0.variation.octaves = 99", "from 1 to 8")),
    (BOX + "variation = 0.5", ("sources.0.variation = 0.5", "a table")),
    (BOX + "variation = { density = 3 }", ("sources.0.variation.density = 3", "from 0 to 2")),
    (BOX + "variation = { strength = 0.7 }", ("sources.0.variation.strength = 0.7", "at most 0.693", "xi")),
    (
        BOX + '[snow]\nkind = "icy"\ntheta_c = 0.02',
        ("sources.0.variation.strength", "at most 0.223", "with the variation of its kind"),
    ),
    (BOX + "profile = 0.5", ("sources.0.profile = 0.5", "a table")),
    (BOX + 'profile = { by = "dept" }', ('sources.0.profile.by = "dept"', 'did you mean "depth"?')),
    (
        BOX + "profile = { at = 0.5 }",
        ("sources.0.profile.at = 0.5", "a list of numbers from 0 to 1000000 [m]"),
    ),
    (BOX + "profile = { at = [0, -1] }", ("sources.0.profile.at = [0, -1]", "a list of numbers from 0")),
    (
        BOX + "profile = { at = [0, 0] }",
        ("sources.0.profile.at = [0, 0]", "must increase, and 0 comes after 0"),
    ),
    (
        BOX + "profile = { at = [0, 1], density = [1] }",
        ("sources.0.profile.density = [1]", "as many entries as at, 2"),
    ),
    (
        BOX + "profile = { stiffness = [2] }",
        ("sources.0.profile.stiffness = [2]", "as many entries as at, 0"),
    ),
    (
        BOX + "profile = { at = [0, 1], stiffness = [1, 0] }",
        ("sources.0.profile.stiffness = [1, 0]", "a list of numbers from 1e-06 to 100"),
    ),
    (
        BOX + "profile = { at = [0, 1], strength = [3, 1] }",
        (
            "sources.0.profile.strength = [3, 1]",
            "no factor above 2, and has 3 at the depth 0 m",
            "theta_c = 0.025 and xi = 10",
            "so that hardening cannot create energy",
        ),
    ),
    (
        BOX
        + 'profile = { by = "height", at = [0, 0.25], strength = [1, 2.5] }\nvariation = { strength = 0.1 }',
        ("no factor above 2, and has 2.5 at the height 0.25 m",),
    ),
    (
        BOX + "profile = { at = [0.1], strength = [1.5] }\nvariation = { strength = 0.5 }",
        ("at most 0.287", "exp(0.5) times 1.5", "xi = 10"),
    ),
    (
        BOX + 'snow = { law = "cam_clay", p0 = 1e4 }\nprofile = { at = [0, 2], strength = [1, 90] }',
        ("no factor above", "has 90 at the depth 2 m", "p0 = 10000", "elastic strains"),
    ),
    (BOX + '[[colliders]]\nshape = "plan"', ('colliders.0.shape = "plan"', 'did you mean "plane"?')),
    (BOX + PLANE + "normal = [0, 0, 0]", ("colliders.0.normal = [0, 0, 0]", "zero vector")),
    (BOX + PLANE + "friction = 1", ("colliders.0.friction", "of a plane", "did you mean mu_c?")),
    (BOX + PLANE + "mu_c = -0.1", ("colliders.0.mu_c = -0.1", "from 0 to 100")),
    (BOX + PLANE + 'mode = "stick"', ('colliders.0.mode = "stick"', 'did you mean "sticky"?')),
    (
        BOX + PLANE + "keyframes = [{t = 1}, {t = 1}]",
        ("colliders.0.keyframes.1.t = 1", "later than", "1 [s]"),
    ),
    (BOX + PLANE + "keyframes = [{time = 1}]", ("colliders.0.keyframes.0.time", "t, position, rotation")),
    (BOX + PLANE + "keyframes = [5]", ("colliders.0.keyframes.0 = 5", "table")),
    (BOX + PLANE + "velocity = [1, 0, 0]\nkeyframes = [{t = 1}]", ("colliders.0.velocity", "keyframes")),
    (BOX + PLANE + "spin = [1, 0, 0]\nkeyframes = [{t = 1}]", ("colliders.0.spin", "keyframes")),
    (BOX + PLANE + "visible = 0", ("colliders.0.visible = 0", "true or false")),
    ("[numerics\ndx = 1", ("line 1", "not valid TOML")),
    (BOX + "[numerics]\ndx = \n", ("line 5", "not valid TOML")),
    (BOX + "[numerics]\ndx = 0.1\ndx = 0.2\n", ("line 6", "not valid TOML")),
    ("a = " + "[" * 5000, ("nested too deeply",)),
]

# An override of a scene with one box of snow -> what the sentence must say.
BAD_OVERRIDES: list[tuple[str, tuple[str, ...]]] = [
    ("numerics.dx", ("--set numerics.dx:", "key=value")),
    ("=1", ("--set =1", "key=value")),
    ("numerics.dx=", ("--set numerics.dx=", "key=value")),
    ("numerics..dx=1", ("--set numerics..dx=1", "key=value")),
    ("numerics.dx=-1", ("--set numerics.dx=-1: numerics.dx = -1", "from 1e-09")),
    ("numerics.dxx=1", ("numerics.dxx is not a known key", "did you mean dx?")),
    ("snwo.xi=1", ("snwo is not a known key", "did you mean snow?")),
    ("numerics.transfer=flp", ('numerics.transfer = "flp"', 'did you mean "flip"?')),
    ("sources.1.size=[1,1,1]", ("sources has no entry 1", "0 is the only one")),
    ("sources.-1.size=[1,1,1]", ("sources.-1", "number of an entry")),
    ("sources.size=[1,1,1]", ("sources is a list", "number of an entry")),
    ("sources.0.size.3=1", ("sources.0.size has no entry 3", "0 to 2")),
    ("sources.0.size.1=-3", ("sources.0.size = [1, -3, 1]", "from 1e-09")),
    ("sources.0.size=[1,", ("not valid TOML",)),
    ("colliders.0.mu_c=1", ("colliders is empty",)),
    ("sources.0.shape.x=1", ("sources.0.shape", "single value")),
    ("sources.0.radius=1", ("sources.0.radius is not a known key of a box",)),
    ("numerics.seed=1\nx = 2", ("numerics.seed", "a whole number")),
]


def sentence_of(error: SceneError) -> str:
    """Return the sentence of `error`, after checking that it is one."""
    text = str(error)
    assert "\n" not in text
    assert text.endswith(".")
    assert not re.search(r"[.!] [A-Z]", text), "more than one sentence"
    assert "Input should" not in text
    assert "Traceback" not in text
    return text


@pytest.mark.parametrize(("content", "parts"), BAD_FILES)
def test_bad_file_is_one_sentence(content: str, parts: tuple[str, ...], tmp_path: Path) -> None:
    """A bad file: the sentence starts with the file, names the key and says what is allowed."""
    path = tmp_path / "bad.toml"
    path.write_text(content)
    with pytest.raises(SceneError) as caught:
        load(path)
    sentence = sentence_of(caught.value)
    assert sentence.startswith(str(path))
    for part in parts:
        assert part in sentence


@pytest.mark.parametrize(("text", "parts"), BAD_OVERRIDES)
def test_bad_override_is_one_sentence(text: str, parts: tuple[str, ...], tmp_path: Path) -> None:
    """A bad override: the sentence starts with --set, not with the file."""
    path = tmp_path / "good.toml"
    path.write_text(BOX)
    with pytest.raises(SceneError) as caught:
        load(path, [text])
    sentence = sentence_of(caught.value)
    assert sentence.startswith("--set ")
    for part in parts:
        assert part in sentence


def test_kind_that_does_not_go_with_the_file() -> None:
    """A kind or law set on top of a file's [snow]: the file's key is named, and how to replace the table."""
    tables = {"sources": [{"shape": "box"}], "snow": {"theta_c": 0.03}}
    for text in ("snow.kind=powder", "snow.law=cam_clay"):
        with pytest.raises(SceneError, match=r"^scene: snow\.theta_c = 0\.03 is not allowed") as caught:
            scene_from(tables, [text])
        key, word = text.removeprefix("snow.").split("=")
        told = f"or replace the whole table with --set 'snow={{{key}=\"{word}\"}}'."
        assert sentence_of(caught.value).endswith(told)
        assert scene_from(tables, [told.split("'")[1]]).snow == Snow.model_validate({key: word})
    with pytest.raises(SceneError) as caught:
        scene_from(tables, ["snow.law=cam_clay", "snow.theta_c=0.02"])
    assert "replace" not in sentence_of(caught.value)


def test_other_problems_are_counted() -> None:
    """The first problem is told, the others are counted."""
    tables = {"sources": [{"shape": "box"}], "numerics": {"dx": -1, "cfl": -1, "seed": -1}}
    with pytest.raises(SceneError, match=r"^scene: numerics\.dx = -1 .* \(and 2 more\)\.$"):
        scene_from(tables)


def test_unknown_preset_names_the_nearest() -> None:
    """A misspelled preset: the nearest name and the list."""
    with pytest.raises(SceneError) as caught:
        load("throw_bal")
    sentence = sentence_of(caught.value)
    assert 'called "throw_bal"' in sentence
    assert "did you mean throw_ball?" in sentence
    assert "text_fall" in sentence
    with pytest.raises(SceneError, match="did you mean plow"):
        preset_about("plov")


def test_missing_file_names_the_nearest(tmp_path: Path) -> None:
    """A misspelled file: the nearest file of its folder."""
    (tmp_path / "ball.toml").write_text(BOX)
    with pytest.raises(SceneError) as caught:
        load(tmp_path / "bal.toml")
    sentence = sentence_of(caught.value)
    assert "bal.toml: there is no such file" in sentence
    assert f"did you mean {tmp_path / 'ball.toml'}?" in sentence
    with pytest.raises(SceneError, match="there is no such file"):
        load(tmp_path / "nowhere" / "ball.toml")


def test_file_that_may_not_be_looked_for(monkeypatch: pytest.MonkeyPatch) -> None:
    """A closed folder, a user who does not exist, a name that no disk takes: one sentence each."""
    for name in ("~nosuchuser/x.toml", "x" * 300, "a\0b.toml"):
        with pytest.raises(SceneError) as caught:
            load(name)
        assert sentence_of(caught.value).startswith((name, "no preset"))

    def closed(path: Path) -> bool:
        if path.parent.name == "closed":
            raise PermissionError(13, "Permission denied", str(path))
        return path.exists()

    monkeypatch.setattr(Path, "is_dir", closed)
    with pytest.raises(SceneError, match=r"closed/x\.toml: .* as a file: permission denied;"):
        load("closed/x.toml")


def test_folder_without_scene(tmp_path: Path) -> None:
    """A folder that is no run."""
    with pytest.raises(SceneError, match=r"is a folder without scene\.toml"):
        load(tmp_path)


def test_file_that_is_not_text(tmp_path: Path) -> None:
    """A picture, say, given as a scene."""
    path = tmp_path / "x.toml"
    path.write_bytes(b"\x89PNG\xff")
    with pytest.raises(SceneError, match=r"x\.toml: byte 0 is not UTF-8 text"):
        load(path)
