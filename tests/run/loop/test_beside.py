"""Outputs beside the simulation: in order, in little memory, and an error ends the run with its sentence."""

import threading

import pytest
from patience import PATIENCE

from neve.io.errors import RunError
from neve.io.frames import frame_numbers
from neve.run import loop, run
from neve.run.beside import DEPTH, Beside
from neve.run.outputs import frames as frames_module
from neve.run.outputs.picture import PictureOutput
from neve.run.painter import Painter
from neve.scene.reading.load import load


def test_jobs_are_done_in_order_in_another_thread():
    """What is handed over is done first things first, and all of it at the end of the block."""
    done = []
    with Beside() as beside:
        for k in range(20):
            beside.do(k, lambda k=k: done.append((k, threading.get_ident())))
    assert [k for k, _ in done] == list(range(20))
    assert {thread for _, thread in done} != {threading.get_ident()}


def test_no_more_than_two_frames_wait():
    """The third frame is not taken before the first is done: memory is bounded."""
    free, done, taken = threading.Event(), [], []

    def slow(k):
        free.wait(PATIENCE)
        done.append(k)

    with Beside() as beside:

        def give():
            for k in range(DEPTH + 1):
                beside.do(k, lambda k=k: slow(k))
                taken.append(k)

        giver = threading.Thread(target=give)
        giver.start()
        giver.join(0.2)
        assert taken == list(range(DEPTH))
        assert done == []
        free.set()
        giver.join(PATIENCE)
        assert taken == list(range(DEPTH + 1))
    assert done == taken


def test_one_job_can_be_waited_for():
    """`wait` returns when the job of a number is done, while later ones are not."""
    free, done = threading.Event(), []
    with Beside() as beside:
        first = beside.do(0, lambda: done.append(0))
        beside.do(0, lambda: free.wait(PATIENCE))
        beside.wait(first)
        assert done == [0]
        free.set()


@pytest.mark.parametrize("how", ["do", "wait", "end"])
def test_an_error_is_raised_where_the_run_can_end(how):
    """Jobs after an error are not done; it is raised by the next call, or at the end of the block."""
    done = []

    def fail():
        raise RunError("the disk is full.")

    def work():
        with Beside() as beside:
            beside.do(0, fail)
            if how == "wait":
                beside.wait()
            while how == "do":
                beside.do(0, lambda: None)
            done.append(how)

    with pytest.raises(RunError, match=r"the disk is full\."):
        work()
    assert done == ([how] if how == "end" else [])


def test_what_waits_is_written_before_an_error_of_the_steps_goes_on():
    """A simulation that fails leaves all frames before; one that is hurried drops those that wait."""
    for error, expected in ((RuntimeError("lost"), [0, 1]), (KeyboardInterrupt(), [])):
        free, done = threading.Event(), []

        def fail(error=error, free=free, done=done):
            with Beside() as beside:
                beside.do(0, lambda: free.wait(0.2) and None)
                for k in (0, 1):
                    beside.do(k, lambda k=k: done.append(k))
                raise error

        with pytest.raises(type(error)):
            fail()
        assert done == expected


def test_a_writer_that_fails_ends_the_run(fake, scene_file, tmp_path, monkeypatch):
    """The run ends with the sentence of the writer, soon after; what is on the disk can be resumed."""
    real = frames_module.FrameOutput.write
    refuse = True

    def write(self, context):
        def fail():
            raise RunError(f"frame {context.frame} could not be written: no space left.")

        if refuse and context.frame == 3:
            context.beside(fail)
        else:
            real(self, context)

    monkeypatch.setattr(frames_module.FrameOutput, "write", write)
    out = tmp_path / "run"
    with pytest.raises(RunError, match=r"^frame 3 could not be written: no space left\.$"):
        run(fake.Simulation(load(scene_file)), out, quiet=True)
    refuse = False
    assert max(frame_numbers(out / "frames")) <= 2
    run(fake.Simulation(load(scene_file)), out, resume=True, quiet=True)
    last = loop.last_frame(load(scene_file), None)
    assert frame_numbers(out / "frames") == list(range(last + 1))


def test_an_output_of_a_user_finds_what_is_written_before(fake, scene_file, tmp_path):
    """An output that is no part of Neve is called when the files of its frame are there."""
    seen = []

    class Looker:
        def write(self, context):
            seen.append((context.folder / f"frames/{context.frame:06d}.npz").exists())

        def close(self, context):
            seen.append((context.folder / "checkpoint").exists())

    run(fake.Simulation(load(scene_file)), tmp_path / "run", quiet=True, outputs=[Looker()])
    assert len(seen) > 2
    assert all(seen)


@pytest.mark.parametrize("device", ["cpu", "cuda"])
def test_pictures_are_drawn_by_the_threads_of_the_steps(fake, scene, tmp_path, monkeypatch, device):
    """On the processor the steps wait while all threads draw; beside those of a GPU another thread draws."""
    numerics = scene.numerics.model_copy(update={"device": device})
    scene, drawing = scene.model_copy(update={"numerics": numerics}), set()
    real = Painter.draw

    def draw(self, content):
        drawing.add(threading.get_ident())
        return real(self, content)

    monkeypatch.setattr(Painter, "draw", draw)
    monkeypatch.setattr(PictureOutput, "close", lambda self, context: None)
    run(fake.Simulation(scene), tmp_path / "run", quiet=True)
    here = {threading.get_ident()}
    assert drawing == here if device == "cpu" else drawing and not drawing & here
