"""Replays: what is packed is what was there, within the grid and the tolerance."""

import base64
import json
import re
import zlib

import numpy as np
import pytest

from neve.io.frames import read_frame
from neve.io.run_folder import RunFolder
from neve.viewer.exports.replay import (
    FINENESS,
    HIDDEN,
    MAIN,
    choose_keys,
    fold,
    modules,
    pack,
    predicted,
    replay_of,
)

HEAD, DATA = rb'id="head">(.*?)</script>', rb'id="data">(.*?)</script>'


def unpacked(packed, n, keys):
    """Undo `pack` as the page does."""
    raw = np.frombuffer(zlib.decompress(packed, -15), np.uint8).reshape(len(keys), 2, 3, n)
    places = {}
    for k, key in enumerate(keys):
        folded = raw[k, 0].astype(np.uint16) | (raw[k, 1].astype(np.uint16) << 8)
        away = (folded >> 1).astype(np.int32) ^ -(folded & 1).astype(np.int32)
        table = np.zeros((keys[-1] + 1, 3, n), np.uint16)
        for known, place in places.items():
            table[known] = place
        places[key] = (predicted(table, keys, k) + away).astype(np.uint16)
    return places


def test_small_numbers_come_of_small_changes():
    """0, -1, 1, -2 fold to 0, 1, 2, 3; every 16-bit number has a place of its own."""
    assert fold(np.array([0, -1, 1, -2, 2], np.int16)).tolist() == [0, 1, 2, 3, 4]
    every = np.arange(-32768, 32768).astype(np.int16)
    assert len(np.unique(fold(every))) == 65536


def test_packed_places_come_back_to_the_bit():
    """Random places, jumps over the whole range and unborn particles: what comes out is what went in."""
    rng = np.random.default_rng(3)
    places = rng.integers(0, 65536, (9, 3, 50)).astype(np.uint16)
    places[:3, :, 40:] = HIDDEN
    keys = [0, 2, 3, 7, 8]
    back = unpacked(pack(places, keys), 50, keys)
    for key in keys:
        np.testing.assert_array_equal(back[key], places[key])


def test_keys_are_few_where_snow_rests_or_flies_straight():
    """Rest and steady flight need the ends only; a throw at 9.81 m/s2 needs keys so that lines stay close.

    Lines over m frames of 1/30 s leave a parabola by g (m / 30)^2 / 8: 34.1 steps of 1 mm at m = 5, 49.1 at
    6, give or take one of rounding. With a tolerance of 36, 30 frames need six spans.
    """
    frame = np.arange(31)
    rest = np.full((31, 3, 20), 500.0)
    assert choose_keys(rest.astype(np.uint16), 1.0) == [0, 30]
    flight = rest + 40.0 * frame[:, None, None]
    assert choose_keys(flight.astype(np.uint16), 1.0) == [0, 30]
    fall = rest + 30000 - 1000 * 0.5 * 9.81 * (frame[:, None, None] / 30) ** 2
    keys = choose_keys(np.rint(fall).astype(np.uint16), 36.0)
    assert max(np.diff(keys)) == 5
    assert len(keys) == 7


def test_replay_holds_the_run(recorded):
    """Every key of the page is its frame, within half a step; nothing in it points elsewhere."""
    page = replay_of(str(recorded))
    head = json.loads(re.search(HEAD, page, re.DOTALL)[1])
    packed = base64.b64decode(re.search(DATA, page, re.DOTALL)[1])
    assert head["frames"] == 6
    assert head["keys"][0] == 0
    assert head["keys"][-1] == 5
    back = unpacked(packed, head["n"], head["keys"])
    run = RunFolder(recorded)
    for key in head["keys"]:
        x = np.array(head["low"]) + np.array(head["step"]) * back[key].T
        frame = read_frame(run.frames, key)
        assert np.abs(x - frame.x).max() <= 0.5 * head["step"][0] + 1e-5
    assert head["step"][0] == pytest.approx(0.05 / FINENESS)
    text = page.decode()
    assert not re.search(r"""(?:src|href)=["'](?!data:)""", text)
    assert not re.search(r"/\*(STYLE|MODULES|MAIN|HEAD|DATA)\*/", text)
    code = modules(MAIN)
    assert set(re.findall(r'type="module">import "([^"]+)"', text)) <= set(code)
    for url in code.values():
        kind, _, body = url.partition(";base64,")
        assert kind == "data:text/javascript"
        script = base64.b64decode(body).decode()
        assert "fetch(" not in script
        assert "WebSocket" not in script
        named = re.findall(r'^import\b[^;]*?"([^"]+)";', script, re.MULTILINE)
        assert set(named) <= set(code)


def test_command_line_writes_a_replay(recorded, tmp_path, capsys):
    """`neve view RUN --replay FILE` writes the page; without frames it says so."""
    main(["view", str(recorded), "--replay", str(tmp_path / "a.html")], 0)
    assert (tmp_path / "a.html").read_bytes() == replay_of(str(recorded))
    main(["view", str(recorded), "--replay", ""], 2)
    assert "names no file" in capsys.readouterr().err
    main(["view", str(tmp_path), "--replay", str(tmp_path / "b.html")], 2)
    assert "no frames" in capsys.readouterr().err
    assert not (tmp_path / "b.html").exists()


def main(arguments, code):
    from neve.cli import main

    with pytest.raises(SystemExit) as end:
        main(arguments)
    assert end.value.code == code
