"""Flakes in the air on the page: where the film has them, and only if they are to be seen."""

import numpy as np
import pytest
from viewer.browser.chromium import COARSE, HEIGHT, WIDTH, drawn, look, shown

from neve.render import falling
from neve.render.falling import draw_falling
from neve.render.path_tracing.lens import Lens
from neve.render.shot import View
from neve.scene.reading.load import load, to_toml
from neve.viewer.show import prepare

AWAY = """() => {
  for (const part of document.querySelectorAll("body > :not(canvas)")) part.style.visibility = "hidden";
  neve.setResolution(1);
  neve.camera.set({ position: [3, 3, 1.2], target: [5, 6, 1], fov: 50 }); // beside all but ground and sky
  neve.state.time = 1.7;
  neve.redraw();
}"""


@pytest.fixture
def snowing(page, small, tmp_path, monkeypatch):
    """The scene of a page on which large flakes fall; few of them: all that a page draws without a card."""
    monkeypatch.setattr(falling, "MOST", 20_000)
    scene = load(str(small))
    scene = scene.model_copy(
        update={
            "light": scene.light.model_copy(
                update={"falling": 30.0, "flake_radius": 0.02, "flake_velocity": (0.4, 0.1, -1.2)}
            ),
            "camera": scene.camera.model_copy(update={"shutter": 0.5}),
        }
    )
    file = tmp_path / "snowing.toml"
    file.write_text(to_toml(scene), encoding="utf-8")
    with shown(prepare(str(file), out=str(tmp_path / "out"), threads=1)) as address:
        page.goto(address + COARSE)
        drawn(page)
        yield load(str(file))


def before_the_ground(lens):
    """Distance of the level ground at z = 0 along the ray of each pixel [m]; 0 for the sky, (h, w)."""
    right, up, forward = lens.axes
    x = (np.arange(lens.width) + 0.5 - 0.5 * lens.width) / lens.focal
    y = (0.5 * lens.height - np.arange(lens.height) - 0.5) / lens.focal
    ray = forward + x[None, :, None] * right + y[:, None, None] * up
    ray /= np.linalg.norm(ray, axis=2, keepdims=True)
    down = -ray[:, :, 2]
    return np.where(down > 1e-6, lens.eye[2] / np.maximum(down, 1e-6), 0.0).astype(np.float32)


def test_the_page_shows_the_flakes_of_the_film(page, snowing):
    """Before sky and ground those pixels change that the film's flakes cover, and no other; the switch."""
    page.evaluate(AWAY)
    with_flakes = look(page)
    page.evaluate("() => neve.setFlakes(false)")
    without = look(page)
    eye, target, fov, time = page.evaluate(
        "() => [neve.camera.eye, neve.camera.target, neve.camera.fov, neve.state.time]"
    )
    assert time == 1.7
    lens = Lens(View(tuple(eye), tuple(target), (0.0, 0.0, 1.0), fov), WIDTH, HEIGHT)
    black, depth = np.zeros((HEIGHT, WIDTH, 3), np.float32), before_the_ground(lens)
    film = draw_falling(black, snowing.light, (lens, lens), time, 0.5 / snowing.run.fps, depth)
    covered = film.max(axis=2)[90:380, 200:500]  # what `look` cuts out
    changed = np.abs(with_flakes - without).max(axis=2)
    assert (covered > 0.3).mean() > 0.1
    assert (covered == 0.0).mean() > 0.4
    assert (changed[covered > 0.3] > 4).mean() > 0.98
    assert (changed[covered == 0.0] > 2).mean() < 0.002  # rims, which the page draws softly
    page.evaluate("() => neve.setFlakes(true)")
    assert np.array_equal(look(page), with_flakes)
