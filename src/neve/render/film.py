"""Make the film of a run: H.264 in mp4, as every browser plays it.

A film outlives its process. Frames go into short segments of raw H.264, each encoded by its own ffmpeg (the
one that comes with imageio-ffmpeg), in a hidden folder beside the film:
`.preview.mp4.parts/000000-000059.h264` holds the frames 0 to 59. A segment gets its name when it is
complete, begins with a key frame and has no frames that look ahead, so segments can be joined byte by byte,
without encoding again, into an mp4 that then takes the film's name in one move. Killing the process costs
at most the segment that was being written: `Film(..., start=n)` lists in `missing` which frames before n
are in no segment (they are drawn again from the run's frame files), and drops what earlier attempts filmed
from frame n on. So every frame is in the film exactly once.
"""

from __future__ import annotations

import contextlib
import re
import secrets
import subprocess
import sys
from collections.abc import Iterator
from fractions import Fraction
from pathlib import Path
from typing import IO, Any

import numpy as np
import numpy.typing as npt

from neve.system import disk, stopping

SEGMENT = re.compile(r"(\d{6,})-(\d{6,})\.h264")
# A minute of drawing at most is lost with a segment, and a key frame every two seconds costs little.
SEGMENT_FRAMES = 60
COLORS = ["-color_primaries", "bt709", "-color_trc", "bt709", "-colorspace", "bt709"]


class FilmError(RuntimeError):
    """One sentence for the user: why there is no film."""


class Film:
    """Collect pictures and leave a film at `path`.

    path: of the film. fps: pictures per second of film. size: (width, height) of the pictures [px]; an odd
    number of pixels gets one more row or column of black, which H.264 needs. start: the frame that will be
    added next; frames from it on that an earlier, interrupted process has filmed are dropped. Frames before
    it are kept, and those that are lost are in `missing`.
    Errors: FilmError, when ffmpeg fails or the disk is full.
    """

    def __init__(self, path: Path | str, fps: int | Fraction, size: tuple[int, int], start: int = 0) -> None:
        self.path = Path(path)
        self.fps, self.size = fps, size
        self._parts = self.path.with_name(f".{self.path.name}.parts")
        self._next = start
        self._encoder: _Encoder | None = None
        with _one_sentence(self.path):
            self._keep_before(start)
            self._held = {k for first, last, _ in self._segments() for k in range(first, last + 1)}

    @property
    def missing(self) -> list[int]:
        """Numbers of the frames before `start` that must be added again, in order."""
        return [frame for frame in range(self._next) if frame not in self._held]

    def add(self, image: npt.NDArray[np.uint8], index: int | None = None) -> None:
        """Put a picture (height, width, 3) into the film, as frame `index` or, without it, as the next one.

        The next one is `start` at first, whatever lost frames are added before it.
        """
        width, height = self.size
        if image.shape != (height, width, 3) or image.dtype != np.uint8:
            raise ValueError(f"a picture is uint8 of shape {(height, width, 3)}, not {image.shape}")
        frame = self._next if index is None else index
        if frame in self._held:
            raise ValueError(f"frame {frame} is in the film already")
        with _one_sentence(self.path):
            if self._encoder and not self._encoder.takes(frame):
                self._end_segment()
            if self._encoder is None:
                self._encoder = _Encoder(self._parts, frame, self.fps, self.size)
            try:
                self._encoder.add(np.ascontiguousarray(image).data)
            except FilmError:
                self._lose_segment(self._encoder)
                raise
        self._held.add(frame)
        self._next = max(self._next, frame + 1)

    def close(self, keep: bool = False) -> None:
        """Write the film of all frames so far. keep: leave the segments for a run that will go on.

        Without any frame there is no film. Frames that are still missing are an error.
        """
        with _one_sentence(self.path):
            self._end_segment()
            segments = self._segments()
            if lost := self.missing:
                raise FilmError(f"{self.path} lacks frame {lost[0]}: it was neither filmed nor drawn again.")
            if segments:
                self._join([part for _, _, part in segments])
            if not keep:
                disk.remove_tree(self._parts)

    def _segments(self) -> list[tuple[int, int, Path]]:
        """First frame, last frame and file of all complete segments, in order."""
        found = []
        for part in self._parts.glob("*.h264"):
            if match := SEGMENT.fullmatch(part.name):
                found.append((int(match[1]), int(match[2]), part))
        return sorted(found)

    def _keep_before(self, start: int) -> None:
        """Drop segments that are torn, that reach past `start`, or that belong to a film of another make."""
        if self._parts.is_symlink():
            raise FilmError(
                f"{self._parts} is a symbolic link, and a film is made in its own folder: remove it."
            )
        make = self._parts / "make"
        text = f"{self.size[0]}x{self.size[1]} {self.fps}"
        if start == 0 or not make.is_file() or disk.read_bytes(make) != text.encode():
            disk.remove_tree(self._parts)
        disk.make_folder(self._parts)
        with disk.replacing(make) as file:
            file.write(text.encode())
        disk.sweep(self._parts)
        for torn in self._parts.glob("*.part"):
            disk.remove(torn)
        end = 0
        for first, last, part in self._segments():
            if last >= start or first < end:
                disk.remove(part)
            else:
                end = last + 1

    def _end_segment(self) -> None:
        encoder, self._encoder = self._encoder, None
        if encoder:
            try:
                encoder.close()
            except FilmError:
                self._lose_segment(encoder)
                raise

    def _lose_segment(self, encoder: _Encoder) -> None:
        self._encoder = None
        self._held.difference_update(range(encoder.first, encoder.last + 1))

    def _join(self, parts: list[Path]) -> None:
        command = ["-f", "h264", "-framerate", str(self.fps), "-i", "pipe:0", "-c", "copy"]
        command += ["-movflags", "+faststart", "-f", "mp4"]
        with disk.temporary_of(self.path) as temporary:
            child = _Child([*command, str(temporary)])
            try:
                for part in parts:
                    child.write(disk.read_bytes(part))
                child.close()
            except BaseException:
                child.kill()
                raise


class _Encoder:
    """Encode consecutive frames into one segment."""

    def __init__(self, folder: Path, first: int, fps: int | Fraction, size: tuple[int, int]) -> None:
        self.first, self.last = first, first - 1
        # A name of its own: the encoder of a process that was killed may still write.
        self._folder, self._part = folder, folder / f"{first:06d}-{secrets.token_hex(4)}.part"
        width, height = size
        pad = "pad=ceil(iw/2)*2:ceil(ih/2)*2"
        command = ["-f", "rawvideo", "-pix_fmt", "rgb24", "-s", f"{width}x{height}", "-r", str(fps)]
        command += ["-i", "pipe:0"]
        command += ["-vf", f"{pad},scale=out_color_matrix=bt709:out_range=tv,format=yuv420p", *COLORS]
        command += ["-c:v", "libx264", "-preset", "veryfast", "-crf", "18", "-bf", "0", "-threads", "2"]
        command += ["-f", "h264", str(self._part)]
        self._child = _Child(command)

    def takes(self, frame: int) -> bool:
        return frame == self.last + 1 and frame - self.first < SEGMENT_FRAMES

    def add(self, image: memoryview) -> None:
        self._child.write(image)
        self.last += 1

    def close(self) -> None:
        self._child.close()
        disk.move(self._part, self._folder / f"{self.first:06d}-{self.last:06d}.h264")


class _Child:
    """An ffmpeg that reads from a pipe; no signal but a kill ends it, so the frames it holds are not lost."""

    def __init__(self, arguments: list[str]) -> None:
        import imageio_ffmpeg  # type: ignore[import-untyped]

        try:
            program = imageio_ffmpeg.get_ffmpeg_exe()
        except RuntimeError as error:
            raise FilmError(
                "no ffmpeg program was found: install imageio-ffmpeg again, or set run.film to false."
            ) from error
        apart: dict[str, Any] = {"start_new_session": True}
        if sys.platform == "win32":
            apart = {"creationflags": subprocess.CREATE_NEW_PROCESS_GROUP}
        with stopping.Deaf():
            self._process = subprocess.Popen(
                [program, "-nostdin", "-hide_banner", "-loglevel", "error", "-y", *arguments],
                stdin=subprocess.PIPE,
                stdout=subprocess.DEVNULL,
                stderr=subprocess.PIPE,
                **apart,
            )

    def write(self, data: bytes | memoryview) -> None:
        pipe: IO[bytes] | None = self._process.stdin
        assert pipe is not None
        try:
            pipe.write(data)
        except BrokenPipeError:
            self.close()  # says why ffmpeg has gone
            raise FilmError("ffmpeg stopped before the end of the film.") from None

    def kill(self) -> None:
        """End ffmpeg, whatever it is at."""
        self._process.kill()
        self._process.communicate()

    def close(self) -> None:
        """Wait until ffmpeg has written all; raise what it complains about."""
        said = self._process.communicate()[1].decode(errors="replace").strip().splitlines()
        if self._process.returncode:
            raise FilmError(f"ffmpeg could not write the film: {said[-1] if said else 'it gave no reason'}.")


@contextlib.contextmanager
def _one_sentence(path: Path) -> Iterator[None]:
    """Turn what the system refuses into one sentence."""
    try:
        yield
    except OSError as error:
        reason = error.strerror or type(error).__name__
        raise FilmError(f"the film {path} could not be written: {reason.lower()}.") from error
