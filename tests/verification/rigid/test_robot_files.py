"""Robot files that hurt the engine's parser are one sentence: circles, replicas, singular joints, crashes."""

import re
import subprocess
import sys
import textwrap

import pytest
from patience import PATIENCE
from verification.loose import bodies_of

from neve.rigid.robot_files import helper
from neve.scene.errors import SceneError

BALL = '<geom size=".1"/>'
HINGE = '<body name="{}"><joint name="j{}" axis="0 1 0"/>{}</body>'
CIRCLES = {
    "self": {"a.xml": '<asset><model name="q" file="a.xml"/></asset>'},
    "two": {
        "a.xml": '<asset><model name="q" file="b.xml"/></asset>',
        "b.xml": '<asset><model name="q" file="a.xml"/></asset>',
    },
    "include": {"a.xml": '<include file="b.xml"/>', "b.xml": '<include file="a.xml"/>'},
    "folder": {
        "a.xml": '<compiler meshdir="sub"/><asset><model name="q" file="b.xml"/></asset>',
        "sub/b.xml": '<asset><model name="q" file="b.xml"/></asset>',
    },
}
REFUSED = {
    "replicas": (f'<replicate count="100000">{BALL}</replicate>', r"more than 10,000 geoms"),
    "nested replicas": (
        f'<replicate count="200"><replicate count="200">{BALL}</replicate></replicate>',
        r"more than 10,000 geoms",
    ),
    "deep": ("<body>" * 2000 + BALL + "</body>" * 2000, r"nested more than 100 deep"),
    "many": (BALL * 301, r"has 301 geoms that collide: 300 are allowed"),
    "huge": (HINGE.format("arm", "", '<geom name="g" size="1e11"/>'), r"^robots\.0\.g is 1e\+11 m large"),
    "singular": (
        HINGE.format("arm", "a", BALL + HINGE.format("tip", "b", '<geom size=".1" pos="1e6 0 0"/>')),
        r"^robots\.0\.(arm|tip) cannot be moved",
    ),
    "nan": (HINGE.format("arm", "", BALL).replace('name="arm"', 'pos="nan 0 0"'), r"robots\.0"),
}


def write(folder, name, content):
    """Write a robot file."""
    path = folder / name
    path.parent.mkdir(exist_ok=True)
    path.write_text(f"<mujoco>{content}<worldbody>{BALL}</worldbody></mujoco>")


@pytest.mark.parametrize("files", CIRCLES.values(), ids=CIRCLES)
def test_files_that_name_one_another_in_a_circle_are_told(files, tmp_path):
    """The engine's own scan of such files overflows its stack."""
    for name, content in files.items():
        write(tmp_path, name, content)
    with pytest.raises(
        SceneError, match=r'^robots\.0\.file = ".*a\.xml" .* goes in a circle: "[ab]\.xml" names'
    ):
        bodies_of([], robots=[{"file": str(tmp_path / "a.xml")}])
    assert helper.files_of(tmp_path / "a.xml") == []


def test_a_file_that_is_named_twice_is_no_circle(tmp_path):
    """Two attachments of one model are legal."""
    write(tmp_path, "b.xml", "")
    write(tmp_path, "a.xml", '<asset><model name="p" file="b.xml"/><model name="q" file="b.xml"/></asset>')
    assert bodies_of([], robots=[{"file": str(tmp_path / "a.xml")}]).solids
    assert tmp_path / "b.xml" in helper.files_of(tmp_path / "a.xml")


@pytest.mark.parametrize(("content", "said"), REFUSED.values(), ids=REFUSED)
def test_robots_that_nothing_can_move_are_told(content, said, tmp_path):
    """One sentence that begins with the robot's place in the scene."""
    (tmp_path / "a.xml").write_text(f"<mujoco><worldbody>{content}</worldbody></mujoco>")
    with pytest.raises(SceneError, match=said):
        bodies_of([], robots=[{"file": str(tmp_path / "a.xml")}])


DEATHS = {
    "crash": ("import os, sys; sys.stdin.readline(); os.kill(os.getpid(), 11)", r"crashes on it \(SIGSEGV\)"),
    "exit": ("import sys; sys.stdin.readline(); sys.exit(3)", r"crashes on it \(exit code 3\)"),
    "abort": ("import os, sys; sys.stdin.readline(); os.abort()", r"may need more than 4 GiB"),
    "hang": ("import time; time.sleep(10_000)", r"is not done with it after 20 s"),
}


@pytest.mark.skipif(sys.platform == "win32", reason="deaths have other names there")
@pytest.mark.parametrize(("program", "said"), DEATHS.values(), ids=DEATHS)
def test_a_reader_that_dies_is_one_sentence_and_the_next_file_is_read(program, said, tmp_path, monkeypatch):
    """Whatever a file does to the process that reads it, the run lives."""
    child = helper._Child()
    with monkeypatch.context() as patch:
        patch.setattr(helper, "START", program)
        patch.setattr(helper, "PATIENCE", 1.0 if "sleep" in program else PATIENCE)
        files, sentence = child.ask(tmp_path / "a.xml", "robots.0")
    assert files == ()
    assert sentence.startswith(f"{helper.HERE} cannot be read as a robot: the rigid-body engine ")
    assert re.search(said, sentence)
    write(tmp_path, "a.xml", "")
    assert child.ask(tmp_path / "a.xml", "robots.0") == ((tmp_path / "a.xml",), "")
    child._end()


@pytest.mark.skipif(sys.platform != "linux", reason="only Linux holds processes to an address space")
def test_the_reader_is_held_to_its_time_and_memory():
    """The limits of the system hold: a loop ends by SIGXCPU, an allocation by MemoryError."""
    program = textwrap.dedent("""
        from neve.rigid.robot_files.limits import limit_memory, limit_seconds
        limit_memory()
        try:
            bytearray(5 << 30)
        except MemoryError:
            print("refused", flush=True)
        limit_seconds(0)
        while True:
            pass
    """)
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, timeout=PATIENCE)
    assert done.stdout == "refused\n"
    assert done.returncode < 0


def test_a_file_is_read_again_once_it_or_what_it_names_has_changed(tmp_path):
    """What is remembered belongs to the content of all files."""
    write(tmp_path, "b.xml", "")
    write(tmp_path, "a.xml", '<asset><model name="q" file="b.xml"/></asset>')
    helper.require_sound(tmp_path / "a.xml", "it")
    write(tmp_path, "b.xml", '<asset><model name="q" file="a.xml"/></asset>')
    with pytest.raises(SceneError, match=r"^it cannot be read as a robot: it goes in a circle"):
        helper.require_sound(tmp_path / "a.xml", "it")
