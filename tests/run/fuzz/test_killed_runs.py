"""The campaign of killed runs: what it does not let pass."""

from neve.fuzz.kills.trial import differences


def test_folders_are_compared_byte_by_byte(tmp_path):
    """A changed byte, a missing file and one too many differ; wall times and encoded films do not."""
    one, other = tmp_path / "one", tmp_path / "other"
    for folder, seconds in ((one, 1), (other, 2)):
        folder.mkdir()
        (folder / "log.csv").write_text(f"frame,mass,seconds_sort\n0,1.5,{seconds}\n")
        (folder / "preview.mp4").write_text(str(seconds))
    assert differences(one, other) == []
    (one / "checkpoint").write_bytes(b"a")
    (other / "log.csv").write_text("frame,mass,seconds_sort\n0,1.6,1\n")
    (other / "more.csv").touch()
    assert differences(one, other) == ["checkpoint", "log.csv", "more.csv"]
