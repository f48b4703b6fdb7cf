"""Cameras of runs that move: the same film whenever it is drawn."""

import pytest

from neve.run import run, run_scene
from neve.scene.reading.load import load

MOVING = {
    "follow": ["camera={position=[1,-9,2],follow='snow',follow_time=0.15,dolly=true}"],
    "keyframes": ["camera.keyframes=[{t=0.1,fov=50},{t=0.3,position=[0,-5,1],fov=20}]"],
    "turntable": ["camera.turntable=100"],
}


@pytest.mark.parametrize("camera", MOVING.values(), ids=MOVING)
def test_a_film_drawn_anew_is_that_of_the_run(fake, scene_file, tmp_path, camera):
    """Film and picture of a finished run that is resumed with a moving camera are those of a run with this
    camera from its start, and both differ from those of a camera at rest."""
    moving, names = load(scene_file, camera), ("preview.mp4", "preview.png")
    run(fake.Simulation(moving), tmp_path / "moving", quiet=True)
    wanted = [(tmp_path / "moving" / name).read_bytes() for name in names]
    out = tmp_path / "still"
    run(fake.Simulation(load(scene_file)), out, quiet=True)
    assert all((out / name).read_bytes() != a for name, a in zip(names, wanted, strict=True))
    run_scene(moving, out, resume=True, quiet=True)
    assert [(out / name).read_bytes() for name in names] == wanted
