"""The page in a real browser, headless, without a graphics card.

The browser is the first of: the program that the variable NEVE_BROWSER names; the Chromium that
`playwright install chromium` has put there; a Chromium or Chrome of the system. Without Playwright or a
browser these tests are skipped.
"""

import asyncio
import contextlib
import io
import os
import shutil
import threading
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from neve.viewer.exports.replay import replay_of
from neve.viewer.show import prepare

playwright = pytest.importorskip(
    "playwright.sync_api", reason="playwright is not installed: pip install '.[test]'"
)

# Draw with the processor: no machine of the tests needs a graphics card.
ARGUMENTS = ["--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"]
if hasattr(os, "geteuid") and os.geteuid() == 0:
    ARGUMENTS.append("--no-sandbox")  # Chromium refuses its sandbox to root
WIDTH, HEIGHT = 760, 480
PATIENCE = 120_000  # ms: the processor draws a picture in a second if others leave it one


# The end of the gizmo's upward arrow, in JavaScript.
TIP = "(([x, y, z]) => [x, y, z + neve.gizmo.size([x, y, z])])(neve.gizmo.place())"


def program(chromium):
    """The browser to start; None if there is none."""
    named = os.environ.get("NEVE_BROWSER")
    own = Path(chromium.executable_path)
    system = (
        shutil.which(name)
        for name in ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable")
    )
    return named or (str(own) if own.is_file() else next((path for path in system if path), None))


@pytest.fixture(scope="module")
def browser():
    with playwright.sync_playwright() as p:
        path = program(p.chromium)
        if path is None:
            pytest.skip("no browser was found: run `playwright install chromium`, or set NEVE_BROWSER")
        try:
            started = p.chromium.launch(executable_path=path, args=ARGUMENTS)
        except playwright.Error:  # on a busy machine Chromium now and then ends while it starts: once more
            started = p.chromium.launch(executable_path=path, args=ARGUMENTS)
        yield started
        started.close()


@pytest.fixture
def page(browser):
    """An empty page that collects what the console says; errors fail the test."""
    context = browser.new_context(viewport={"width": WIDTH, "height": HEIGHT})
    page = context.new_page()
    page.set_default_timeout(PATIENCE)
    said = []
    page.on("console", lambda message: said.append(message.text) if message.type == "error" else None)
    page.on("pageerror", lambda error: said.append(str(error)))
    yield page
    assert said == []
    context.close()


@contextlib.contextmanager
def shown(server):
    """Serve in a thread; give the address."""
    loop, ready, told = asyncio.new_event_loop(), threading.Event(), {}

    async def main():
        async with server.serve(0) as socket:
            told["port"], told["end"] = socket.sockets[0].getsockname()[1], asyncio.Event()
            ready.set()
            await told["end"].wait()

    thread = threading.Thread(target=lambda: loop.run_until_complete(main()))
    thread.start()
    assert ready.wait(60)
    try:
        yield f"http://127.0.0.1:{told['port']}/"
    finally:
        loop.call_soon_threadsafe(told["end"].set)
        thread.join()
        loop.close()


def until(page, question, what):
    """Wait until JavaScript's `question` is true; the page's policy forbids the usual way, an eval."""
    for _ in range(PATIENCE // 100):
        if page.evaluate(question):
            return
        page.wait_for_timeout(100)
    raise AssertionError(f"waited in vain until {what}")


def drawn(page):
    """Wait until a picture later than now is drawn."""
    page.wait_for_selector("body[data-drawn]", state="attached")
    count = page.evaluate("() => +document.body.dataset.drawn")
    # Each question asks for a picture; the first that follows may have been under way before.
    ask = f"() => {{ neve.dirty = true; return +document.body.dataset.drawn > {count + 1} }}"
    until(page, ask, "the page draws")


def look(page):
    """What the canvas shows, (height, width, 3), without panel and bar."""
    drawn(page)
    image = Image.open(io.BytesIO(page.screenshot())).convert("RGB")
    return np.asarray(image, np.int16)[90:380, 200:500]


def on_screen(page, point):
    """Where a point of the world, a JavaScript expression, is on the screen [px]."""
    x, y = page.evaluate(f"() => neve.camera.project({point}).slice(0, 2)")
    return x * WIDTH, y * HEIGHT


def changed_pixels(a, b):
    """Share of the pixels that differ clearly."""
    return float((np.abs(a - b).max(axis=2) > 24).mean())


@pytest.fixture
def live(page, small, tmp_path):
    """The page of a live session, paused at the start."""
    server = prepare(str(small), out=str(tmp_path / "out"), threads=1)
    with shown(server) as address:
        page.goto(address)
        drawn(page)
        page.evaluate("() => neve.send({do: 'speed', factor: 100})")
        yield server


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


def test_a_value_in_the_panel_changes_the_simulation(page, live):
    """A new E0 reaches the running model; a wrong nu is refused beside its field, and reaches nothing."""
    box = page.locator('[data-path="snow.E0"] input')
    box.fill("200000")
    box.press("Enter")
    box.blur()
    told = "neve.scene.panel.find(s => s.path === 'snow').fields.find(f => f.name === 'E0').value"
    until(page, f"() => {told} === 2e5", "E0 is told")
    assert live.player._sim.solver.model.snows[0].E0 == 2e5
    nu = page.locator('[data-path="snow.nu"] input')
    nu.fill("0.9")
    nu.blur()
    page.wait_for_selector(".wrong-text")
    assert "less than 0.5" in page.inner_text(".wrong-text")
    assert live.player._sim.solver.model.snows[0].nu == 0.2


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


def test_colours_have_a_legend_and_solids_a_gizmo(page, live):
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
    assert live.player.scene.colliders[1].center[2] > 0.35


def test_a_table_is_added_and_the_snow_seen_from_above(page, live):
    """The panel's button makes a keyframe, whose fields appear; a view turns the camera to the snow."""
    page.locator("[data-section='colliders.1'] > summary").click()
    page.locator("[data-section='colliders.1.keyframes'] > summary button").click()
    page.wait_for_selector("[data-path='colliders.1.keyframes.0.t']", state="attached")
    assert len(live.player.scene.colliders[1].keyframes) == 1
    page.locator(".views button", has_text="above").click()
    drawn(page)
    assert page.evaluate("() => neve.camera.forward[2]") < -0.95
    x, y, _ = page.evaluate("() => neve.camera.project([0, 0, 0.5])")  # the ball's middle
    assert abs(x - page.evaluate("() => 0.5 - 0.5 * neve.camera.covered")) < 0.02
    assert abs(y - 0.5) < 0.02


def test_a_run_has_a_timeline(page, recorded):
    """The slider shows another frame of the run."""
    with shown(prepare(str(recorded))) as address:
        page.goto(address)
        first = look(page)
        page.locator(".timeline").fill("5")
        until(page, "() => neve.state.frame === 5", "frame 5 is shown")
        assert changed_pixels(first, look(page)) > 0.003
        assert page.is_hidden("#tools")


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
