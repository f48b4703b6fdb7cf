"""The page's types are those of Python, and messages are what their types say."""

from typing import Any, NotRequired, get_args, get_origin, get_type_hints

import pytest

from neve.viewer.describe import describe
from neve.viewer.modes import MODES, available
from neve.viewer.protocol import commands, document, messages
from neve.viewer.show import prepare


def test_the_types_of_the_page_are_current():
    """Both files are what Python makes; if not: python -m neve.viewer.protocol.document."""
    for file, text in document.documents().items():
        assert file.read_text(encoding="utf-8") == text


def test_every_command_and_message_is_told():
    """Each class of a command and each kind of message stands in the file, with its word."""
    text = "".join(document.documents().values())
    for model in get_args(get_args(commands.AnyCommand)[0]):
        (word,) = get_args(model.model_fields["do"].annotation)
        assert f'{{"{word}"}} do' in text
    for table in get_args(messages.Message):
        assert f"@typedef {{object}} {table.__name__}\n" in text


def unlike(value, annotation, path="message"):
    """Paths at which a value is not what an annotation says."""
    origin, items = get_origin(annotation), get_args(annotation)
    if hasattr(annotation, "__required_keys__"):
        hints = get_type_hints(annotation)
        needed = {name for name, hint in get_type_hints(annotation, include_extras=True).items()
                  if "NotRequired" not in str(hint)}  # fmt: skip
        if not isinstance(value, dict) or not needed <= set(value) <= set(hints):
            yield path
        else:
            for name in value:
                yield from unlike(value[name], hints[name], f"{path}.{name}")
    elif origin is NotRequired:
        yield from unlike(value, items[0], path)
    elif origin is list:
        for i, item in enumerate(value):
            yield from unlike(item, items[0], f"{path}.{i}")
    elif origin is tuple:
        if not isinstance(value, tuple | list) or len(value) != len(items):
            yield path
    elif isinstance(annotation, type) and annotation is not Any:
        good = (int, float) if annotation is float else annotation
        if not isinstance(value, good):
            yield path


@pytest.mark.parametrize("which", ["live", "recorded"])
def test_a_scene_message_is_what_its_type_says(which, small, recorded, tmp_path):
    """Live and recorded: every key is declared, and every declared key is there."""
    player = prepare(str(small if which == "live" else recorded), out=str(tmp_path / "out"), threads=1).player
    player._begin()
    assert list(unlike(describe(player), messages.SceneMessage)) == []
    assert list(unlike(player.state(), messages.PlayerState)) == []


def test_unlike_finds_what_is_wrong():
    """A missing key, an unknown key and a wrong kind are found."""
    good = {
        "playing": True,
        "speed": 1.0,
        "frames": 0,
        "recording": False,
        "recorded": 0,
        "undo": "",
        "redo": "",
    }
    assert list(unlike(good, messages.PlayerState)) == []
    assert list(unlike(good | {"more": 1}, messages.PlayerState)) == ["message"]
    assert list(unlike({"playing": True}, messages.PlayerState)) == ["message"]
    assert list(unlike(good | {"speed": "fast"}, messages.PlayerState)) == ["message.speed"]


def test_a_mode_is_one_entry(monkeypatch, recorded, tmp_path):
    """A colour mode that is added to MODES is offered, measured and encoded without another line."""
    from neve.viewer.encode import encode
    from neve.viewer.modes import Colors, Mode, Scale
    from neve.viewer.protocol.state import unframed

    height = Mode("height", "m", ("x",), lambda columns, spacing: columns["x"]()[:, 2], (0.0, 1.0))
    monkeypatch.setattr("neve.viewer.modes.MODES", MODES | {"height": height})
    for module in ("encode", "players.live", "server"):
        monkeypatch.setattr(f"neve.viewer.{module}.MODES", MODES | {"height": height})
    player = prepare(str(recorded), out=str(tmp_path / "out")).player
    player.modes = {"height"}
    player._begin()
    told = describe(player)["modes"]
    assert [mode["label"] for mode in told if mode["name"] == "height"] == ["height"]
    assert "height" in available({"x"})
    head, _ = unframed(encode(player.latest, Colors("height"), Scale(), 1))
    assert (head["mode"], head["limits"]) == ("height", [0.0, 1.0])
