"""Films: every frame once and in order, whatever happens to the process that makes them."""

import contextlib
import os
import subprocess
import sys
import textwrap
from fractions import Fraction

import imageio_ffmpeg
import numpy as np
import pytest

from neve.render import film as module
from neve.render.film import Film, FilmError

SIZE = (64, 48)
PARTS = ".preview.mp4.parts"


@pytest.fixture(autouse=True)
def short_segments(monkeypatch):
    monkeypatch.setattr(module, "SEGMENT_FRAMES", 5)


def picture(index, size=SIZE):
    """A grey image whose brightness says which frame it is."""
    return np.full((size[1], size[0], 3), 20 + 6 * index, np.uint8)


def decoded(path, size=SIZE):
    """Return the frame numbers that the decoded film shows, by brightness."""
    command = [imageio_ffmpeg.get_ffmpeg_exe(), "-loglevel", "error", "-i", str(path)]
    command += ["-fps_mode", "passthrough", "-f", "rawvideo", "-pix_fmt", "rgb24", "-"]
    raw = subprocess.run(command, capture_output=True, check=True).stdout
    frames = np.frombuffer(raw, np.uint8).reshape(-1, size[1], size[0], 3)
    return [round((frame[8:-8, 8:-8].mean() - 20) / 6) for frame in frames]


def fill(film, count):
    for index in range(count):
        film.add(picture(index))


def probe(path):
    """What ffmpeg says about a file."""
    command = [imageio_ffmpeg.get_ffmpeg_exe(), "-hide_banner", "-i", str(path)]
    return subprocess.run(command, capture_output=True, text=True, check=False).stderr


def test_film_has_every_frame_in_order(tmp_path):
    """Twelve frames over three segments: twelve frames, H.264 4:2:0, the right size and length, nothing
    else left."""
    path = tmp_path / "preview.mp4"
    film = Film(path, 24, SIZE)
    fill(film, 12)
    film.close()
    assert decoded(path) == list(range(12))
    told = probe(path)
    assert "h264" in told
    assert "yuv420p(tv, bt709" in told
    assert "64x48" in told
    assert "24 fps" in told
    assert "Duration: 00:00:00.50" in told
    data = path.read_bytes()
    assert data.index(b"moov") < data.index(b"mdat")  # plays while it loads
    assert os.listdir(tmp_path) == ["preview.mp4"]


def test_rate_need_not_be_whole(tmp_path):
    """Six frames at 15/2 a second: 0.8 s."""
    film = Film(tmp_path / "slow.mp4", Fraction(15, 2), SIZE)
    fill(film, 6)
    film.close()
    assert decoded(tmp_path / "slow.mp4") == list(range(6))
    assert "7.50 fps" in probe(tmp_path / "slow.mp4")
    assert "Duration: 00:00:00.80" in probe(tmp_path / "slow.mp4")


def test_odd_sizes_are_padded(tmp_path):
    """H.264 4:2:0 needs even sizes: one row and one column more."""
    film = Film(tmp_path / "odd.mp4", 30, (33, 17))
    film.add(picture(0, (33, 17)))
    film.close()
    assert "34x18" in probe(tmp_path / "odd.mp4")


KILLED = """
    import os, signal, sys
    import numpy as np
    from neve.render import film
    film.SEGMENT_FRAMES = 5
    made = film.Film(sys.argv[1], 24, (64, 48))
    for index in range(int(sys.argv[2])):
        made.add(np.full((48, 64, 3), 20 + 6 * index, np.uint8))
    os.kill(os.getpid(), signal.SIGKILL)
"""


@pytest.mark.parametrize(("filmed", "resume"), [(13, 12), (13, 13), (8, 3), (3, 3), (13, 0)])
def test_a_killed_film_goes_on(tmp_path, filmed, resume):
    """A process is killed in the middle of a segment; the run goes on at frame `resume`. Lost frames are
    listed, frames filmed beyond `resume` are dropped, and the film has each of the 15 frames once."""
    path = tmp_path / "preview.mp4"
    script = [sys.executable, "-c", textwrap.dedent(KILLED), str(path), str(filmed)]
    assert subprocess.run(script, check=False).returncode == -9
    assert not path.exists()
    film = Film(path, 24, SIZE, start=resume)
    whole = 5 * (min(filmed - 1, resume) // 5)  # a fifth frame completes a segment when the sixth comes
    assert film.missing == list(range(whole, resume))
    for index in film.missing:
        film.add(picture(index), index)
    for index in range(resume, 15):
        film.add(picture(index))
    film.close()
    assert decoded(path) == list(range(15))


def test_an_encoder_left_by_a_killed_process_changes_nothing(tmp_path):
    """ffmpeg outlives the process that fed it for a while. It writes its part late, or finds its folder
    gone: which of the two is a matter of when it starts."""
    path = tmp_path / "preview.mp4"
    killed = Film(path, 24, SIZE)
    killed.add(picture(9))
    film = Film(path, 24, SIZE)
    film.add(picture(0))
    with contextlib.suppress(FilmError):
        killed._encoder._child.close()
    for index in range(1, 8):
        film.add(picture(index))
    film.close()
    assert decoded(path) == list(range(8))


def test_a_stopped_film_shows_what_is_done_and_goes_on(tmp_path):
    """close(keep=True) leaves a film and its segments; nothing is missing later, and nothing is encoded
    twice."""
    path = tmp_path / "preview.mp4"
    film = Film(path, 24, SIZE)
    fill(film, 7)
    film.close(keep=True)
    assert decoded(path) == list(range(7))
    kept = {p: p.stat().st_mtime_ns for p in (tmp_path / PARTS).glob("*.h264")}
    film = Film(path, 24, SIZE, start=7)
    assert film.missing == []
    film.add(picture(7))
    assert {p: p.stat().st_mtime_ns for p in kept} == kept
    film.close()
    assert decoded(path) == list(range(8))


def test_segments_of_another_make_are_dropped(tmp_path):
    """Frames of another size or rate cannot be joined: all are missing."""
    path = tmp_path / "preview.mp4"
    film = Film(path, 24, SIZE)
    film.add(picture(0))
    film.close(keep=True)
    assert Film(path, 30, SIZE, start=1).missing == [0]


def test_a_kill_while_the_make_is_written_costs_nothing(tmp_path, monkeypatch):
    """The make changes in one move: one that is cut short does not lose the frames filmed before."""
    path = tmp_path / "preview.mp4"
    film = Film(path, 24, SIZE)
    film.add(picture(0))
    film.close(keep=True)

    def killed(*_):
        raise KeyboardInterrupt

    with monkeypatch.context() as patch:
        patch.setattr("neve.system.disk.os.replace", killed)
        with pytest.raises(KeyboardInterrupt):
            Film(path, 24, SIZE, start=1)
    assert Film(path, 24, SIZE, start=1).missing == []
    assert not list((tmp_path / ".preview.mp4.parts").glob("*.part"))


def test_a_new_film_replaces_the_old_one_whole(tmp_path):
    """Until close, the old film is untouched; a film without frames leaves it, too."""
    path = tmp_path / "preview.mp4"
    path.write_bytes(b"old")
    film = Film(path, 24, SIZE)
    film.add(picture(3))
    assert path.read_bytes() == b"old"
    film.close()
    assert decoded(path) == [3]
    Film(path, 24, SIZE).close()
    assert decoded(path) == [3]


def test_a_frame_is_never_twice_nor_lost(tmp_path):
    """A frame that is there cannot be added; a film that lacks one cannot be closed."""
    film = Film(tmp_path / "preview.mp4", 24, SIZE)
    film.add(picture(0))
    with pytest.raises(ValueError, match="frame 0 is in the film already"):
        film.add(picture(0), 0)
    film.add(picture(2), 2)
    with pytest.raises(FilmError, match="lacks frame 1"):
        film.close()


@pytest.mark.parametrize("wrong", [picture(0, (48, 64)), picture(0).astype(float)])
def test_a_picture_of_another_kind_is_refused(tmp_path, wrong):
    with pytest.raises(ValueError, match=r"a picture is uint8 of shape \(48, 64, 3\)"):
        Film(tmp_path / "preview.mp4", 24, SIZE).add(wrong)


def broken(tmp_path, monkeypatch, script):
    """Put a program that fails in ffmpeg's place; return a film."""
    program = tmp_path / "ffmpeg"
    program.write_text(f"#!/bin/sh\n{script}\n")
    program.chmod(0o755)
    monkeypatch.setattr(imageio_ffmpeg, "get_ffmpeg_exe", lambda: str(program))
    return Film(tmp_path / "preview.mp4", 24, SIZE)


@pytest.mark.parametrize("before", ["", "cat > /dev/null;"])
def test_ffmpeg_that_fails_is_one_sentence(tmp_path, monkeypatch, before):
    """Whether it stops at once or at the end, its last words are in the sentence, and there is no film."""
    film = broken(tmp_path, monkeypatch, f"{before} echo 'No space left on device' >&2; exit 1")
    with pytest.raises(FilmError, match="No space left on device"):
        fill(film, 12)
    assert not (tmp_path / "preview.mp4").exists()


def test_no_ffmpeg_is_one_sentence(tmp_path, monkeypatch):
    def none():
        raise RuntimeError("No ffmpeg exe could be found.")

    monkeypatch.setattr(imageio_ffmpeg, "get_ffmpeg_exe", none)
    with pytest.raises(FilmError, match=r"set run\.film to false"):
        Film(tmp_path / "preview.mp4", 24, SIZE).add(picture(0))


def test_a_place_that_cannot_be_written_is_one_sentence(tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(FilmError, match="could not be written"):
        Film(tmp_path / "file" / "preview.mp4", 24, SIZE)
