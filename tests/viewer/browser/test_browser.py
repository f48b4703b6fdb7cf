"""The page in a real browser: what it shows, and what its controls do to the run."""

import numpy as np
from viewer.browser.chromium import (
    COARSE,
    HEIGHT,
    TIP,
    WIDTH,
    changed_pixels,
    drawn,
    look,
    on_screen,
    shown,
    until,
)

from neve.viewer.exports.replay import replay_of
from neve.viewer.show import prepare


def test_page_shows_the_snow_and_play_moves_it(page, live):
    """The snow is brighter than the ground behind it; after `play` pixels change where it falls."""
    before = look(page)
    bright = (before.min(axis=2) > 150).mean()
    assert bright > 0.02  # a ball of 0.3 m at 2.9 m, seen at 35 degrees, covers more than that
    page.click("#play")
    until(page, "() => +document.body.dataset.time > 0.15", "time runs")
    page.click("#play")
    after = look(page)
    assert changed_pixels(before, after) > 0.01
    assert page.title().startswith("small")
    figures = page.inner_text("#figures")
    assert "particles" in figures
    assert "steps" in figures


def test_a_value_in_the_panel_changes_the_simulation(page, unseen):
    """A new E0 reaches the running model; a wrong nu is refused beside its field, and reaches nothing."""
    box = page.locator('[data-path="snow.E0"] input')
    box.fill("200000")
    box.press("Enter")
    box.blur()
    told = "neve.scene.panel.find(s => s.path === 'snow').fields.find(f => f.name === 'E0').value"
    until(page, f"() => {told} === 2e5", "E0 is told")
    assert unseen.player._sim.solver.model.snows[0].E0 == 2e5
    nu = page.locator('[data-path="snow.nu"] input')
    nu.fill("0.9")
    nu.blur()
    page.wait_for_selector(".wrong-text")
    assert "less than 0.5" in page.inner_text(".wrong-text")
    assert unseen.player._sim.solver.model.snows[0].nu == 0.2


def test_a_click_throws_a_snowball_that_arrives(page, live):
    """The throw tool adds snow, which flies to where the click was and shows."""
    before, n = look(page), int(page.evaluate("() => neve.state.n"))
    page.keyboard.press("2")
    page.mouse.click(WIDTH / 2, HEIGHT / 2)
    until(page, f"() => neve.state.n > {n}", "the ball is there")
    assert live.player._sim.count > n
    assert changed_pixels(before, look(page)) > 0.01
    page.click("#play")
    until(page, "() => +document.body.dataset.time > 0.3", "the ball has flown")
    page.click("#play")
    x = np.asarray(live.player.latest.x)[n:]
    eye, target = np.array([1.5, -2.5, 1.0]), np.array([0.2, 0.0, 0.35])
    # From 0.3 of the way at 12 m/s: after 0.3 s it has reached the target and whatever stands there.
    way = (target - eye) / np.linalg.norm(target - eye)
    assert ((x - eye) @ way).max() > np.linalg.norm(target - eye) - 0.3


def test_colours_have_a_legend_and_solids_a_gizmo(page, unseen):
    """A colour mode shows its legend with unit; the move tool chooses a box and drags it along its arrow."""
    page.select_option("#mode", "speed")
    page.wait_for_selector("#legend:not([hidden])")
    assert "m/s" in page.inner_text("#legend")
    page.locator("#mode").blur()
    page.keyboard.press("p")  # the panel hides the box on a screen so small
    page.keyboard.press("5")
    drawn(page)
    page.mouse.click(*on_screen(page, "[0.9, 0, 0.45]"))
    until(page, "() => neve.selected === 'colliders.1'", "the box is chosen")
    tip = on_screen(page, TIP)
    page.mouse.move(*tip)
    page.mouse.down()
    page.mouse.move(tip[0], tip[1] - 60, steps=4)
    page.mouse.up()
    until(page, "() => neve.state.poses[1][2] > 0.35", "the box is higher")
    assert unseen.player.scene.colliders[1].center[2] > 0.35


def test_a_table_is_added_and_the_snow_seen_from_above(page, unseen):
    """The panel's button makes a keyframe, whose fields appear; a view turns the camera to the snow."""
    page.locator("[data-section='colliders.1'] > summary").click()
    page.locator("[data-section='colliders.1.keyframes'] > summary button").click()
    page.wait_for_selector("[data-path='colliders.1.keyframes.0.t']", state="attached")
    assert len(unseen.player.scene.colliders[1].keyframes) == 1
    page.locator(".views button", has_text="above").click()
    drawn(page)
    assert page.evaluate("() => neve.camera.forward[2]") < -0.95
    x, y, _ = page.evaluate("() => neve.camera.project([0, 0, 0.5])")  # the ball's middle
    assert abs(x - page.evaluate("() => 0.5 - 0.5 * neve.camera.covered")) < 0.02
    assert abs(y - 0.5) < 0.02


def test_a_run_has_a_timeline(page, recorded):
    """The slider shows another frame of the run; arrow keys move it, and not the camera."""
    with shown(prepare(str(recorded))) as address:
        page.goto(address + COARSE)
        first = look(page)
        page.locator(".timeline").fill("5")
        until(page, "() => neve.state.frame === 5", "frame 5 is shown")
        assert changed_pixels(first, look(page)) > 0.003
        target = page.evaluate("() => neve.camera.target")
        page.locator(".timeline").press("ArrowLeft")
        until(page, "() => neve.state.frame === 4", "frame 4 is shown")
        assert page.evaluate("() => [neve.camera.keys.size, neve.camera.target]") == [0, target]
        assert page.is_hidden("[data-tool=throw]")
        assert page.is_visible("[data-tool=measure]")


def test_a_replay_plays_offline(page, recorded, tmp_path):
    """The file alone, from disk and with the network off, draws the snow and moves it."""
    path = tmp_path / "replay.html"
    path.write_bytes(replay_of(str(recorded)))
    page.context.set_offline(True)
    asked = []
    page.on("request", lambda request: asked.append(request.url))
    page.goto(path.as_uri())
    page.wait_for_selector("body[data-drawn]", state="attached")
    page.evaluate("() => { neve.send({do: 'pause'}); neve.send({do: 'seek', frame: 0}) }")
    until(page, "() => +document.body.dataset.time === 0", "it begins")
    first = look(page)
    assert (first.min(axis=2) > 150).mean() > 0.02
    page.evaluate("() => neve.send({do: 'seek', frame: 5})")
    until(page, "() => +document.body.dataset.time > 0.16", "it ends")
    assert changed_pixels(first, look(page)) > 0.003
    assert [url for url in asked if not url.startswith(("file:", "data:", "blob:"))] == []
