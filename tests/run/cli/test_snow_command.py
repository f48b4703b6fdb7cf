"""`neve snow`: what it prints, what it refuses."""

import json

import numpy as np
import pytest

import neve
from neve.cli.commands import main
from neve.io.frames import frame_numbers, read_frame
from neve.io.run_folder import RunFolder
from neve.scene.reading.load import load


def called(capsys, *arguments):
    """Exit code, standard output and standard error of a command."""
    with pytest.raises(SystemExit) as end:
        main(["snow", *arguments])
    found = capsys.readouterr()
    return end.value.code, found.out, found.err


def test_snow_on_a_mesh(tmp_path, capsys):
    """It says how much lies and how much fell."""
    out = str(tmp_path / "out")
    code, said, _ = called(
        capsys, "neve:rock", "--depth", "0.1", "--cell", "0.05", "--ground", "0", "--out", out, "--quiet"
    )
    assert code == 0
    assert "m3 of snow lie, of" in said
    assert sorted(p.name for p in (tmp_path / "out").iterdir()) == [
        "books.json", "cover.npz", "depth.csv", "snow.ply",
    ]  # fmt: skip


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (["neve:rok"], '"neve:rock"'),
        (["nothing.obj"], "is not a file"),
        (["no_such_scene"], "no_such_scene"),
        (["neve:rock", "--wind", "3"], "--wind"),
        (["neve:rock", "--repose", "90"], "--repose"),
        (["neve:rock", "--drift-wind", "nan,0"], "--drift-wind: "),
        (["neve:rock", "--drift-wind", "1e300,0"], "--drift-wind: "),
        (["neve:rock", "--duration", "3"], "--duration: "),
        (["neve:rock", "--duration", "3", "--depth", "0.1"], "--duration: "),
        (["neve:rock", "--set", "numerics.dx=1"], "--set"),
        (["castle", "--ground", "0"], "--ground"),
        (["neve:rock", "--film", "4"], "--film"),
    ],
)
def test_what_is_wrong_is_one_sentence(tmp_path, capsys, arguments, says):
    """Exit code 2, a sentence that names it, and no folder."""
    code, _, error = called(capsys, *arguments, "--out", str(tmp_path / "out"))
    assert code == 2
    assert says in error
    assert len(error.strip().splitlines()) == 1
    assert not (tmp_path / "out").exists()


def test_film_shows_the_snow_grow(tmp_path, capsys):
    """`--film 4`: a run of four frames, from none to all that lies, with its film; what moves is hidden."""
    path = tmp_path / "yard.toml"
    path.write_text(
        "[numerics]\ndx = 0.1\n"
        '[[sources]]\nshape = "snowfall"\nsize = [2.0, 2.0]\ndepth = 0.2\n'
        '[[bodies]]\nshape = "sphere"\ncenter = [0.0, 0.0, 2.0]\nradius = 0.2\nvelocity = [1.0, 0.0, 0.0]\n'
        '[[colliders]]\nshape = "plane"\n'
    )
    out = tmp_path / "out"
    code, _, error = called(capsys, str(path), "--out", str(out), "--film", "4", "--quiet")
    assert (code, error) == (0, "")
    run = RunFolder(out / "fall")
    frames = [read_frame(run.frames, number) for number in frame_numbers(run.frames)]
    counts = [len(frame.x) for frame in frames]
    assert len(counts) == 4
    assert counts[0] == 0
    assert counts == sorted(counts)
    spacing = 0.1 / 8 ** (1 / 3)
    lies = json.loads((out / "books.json").read_text())["lies"]
    assert counts[-1] * spacing**3 == pytest.approx(lies, rel=0.02)
    assert set(frames[1].id) <= set(frames[2].id)
    scene = load(str(run.path))
    assert (scene.light.falling, scene.light.flake_velocity) == (60.0, (0.0, 0.0, -1.0))
    assert not scene.bodies[0].visible
    assert (run.path / "preview.mp4").stat().st_size > 1000


def test_film_shows_what_the_snow_falls_on(tmp_path, capsys):
    """Snow of other sources lies in every frame as a run begins with it; what flies does not."""
    path = tmp_path / "yard.toml"
    path.write_text(
        "[numerics]\ndx = 0.1\n[run]\nfilm = false\n"
        '[[sources]]\nshape = "box"\nsize = [0.6, 0.6, 0.4]\ncenter = [0.0, 0.0, 0.2]\n'
        '[[sources]]\nshape = "snowfall"\nsize = [1.5, 1.5]\ndepth = 0.1\n'
        '[[sources]]\nshape = "snowfall"\nsize = [1.5, 1.5]\ndepth = 0.1\n'
        '[[sources]]\nshape = "sphere"\nradius = 0.2\ncenter = [0.0, 0.0, 2.0]\nvelocity = [1.0, 0.0, 0.0]\n'
        '[[colliders]]\nshape = "plane"\n'
    )
    code, _, _ = called(capsys, str(path), "--out", str(tmp_path / "out"), "--film", "2", "--quiet")
    assert code == 0
    begin = neve.Simulation(load(str(path)))
    source, x = np.asarray(begin.columns()["source"]()), np.asarray(begin.state.x)
    run = RunFolder(tmp_path / "out" / "fall")
    bare, covered = (read_frame(run.frames, number) for number in frame_numbers(run.frames))
    for frame in (bare, covered):
        for i in (0, 1):
            assert np.allclose(frame.x[frame.more["source"] == i], x[source == i], atol=2e-3)
    assert set(bare.more["source"]) == {0, 1}
    assert set(covered.more["source"]) == {0, 1, 2}
    assert len({*covered.id}) == len(covered.x) == len(bare.x) + np.sum(covered.more["source"] == 2)


def test_snow_that_still_slides_is_told_once(tmp_path, capsys, monkeypatch):
    """By `neve snow` and by `neve age` alike, in one sentence on standard error."""
    monkeypatch.setattr("neve.snowfall.cover.MOST_PASSES", 0)
    path = tmp_path / "yard.toml"
    path.write_text(
        '[[sources]]\nshape = "snowfall"\nsize = [1.0, 1.0]\ncell = 0.1\nrepose = 5.0\n'
        '[[colliders]]\nshape = "plane"\n'
        '[[colliders]]\nshape = "sphere"\nradius = 0.3\ncenter = [0.0, 0.0, 0.0]\n'
    )
    for command in ("snow", "age"):
        with pytest.raises(SystemExit) as end:
            main([command, str(path), "--out", str(tmp_path / command), "--quiet"])
        assert end.value.code == 0
        said = capsys.readouterr().err.strip().splitlines()
        assert said == ["neve: warning: some snow still slides: it may lie steeper than its angle of repose."]
