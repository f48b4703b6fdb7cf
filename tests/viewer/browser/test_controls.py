"""What the page's controls do, in one visit each: a page is dear where the processor draws it."""

import numpy as np
import pytest
from viewer.browser.chromium import changed_pixels, drawn, look, until

SIZES = [(454, 420), (1280, 800), (390, 800), (1000, 510)]

# Pairs of boxes of the page that cover each other, of those that are shown.
COVERED = """() => {
  const shown = (e) => !e.hidden && getComputedStyle(e).display !== "none";
  const boxes = ["figures", "legend", "tools", "panel", "bar"]
    .map((id) => document.getElementById(id)).filter(shown).map((e) => [e.id, e.getBoundingClientRect()]);
  const meet = (p, q) => p.left < q.right && q.left < p.right && p.top < q.bottom && q.top < p.bottom;
  return boxes.flatMap(([a, p]) => boxes.filter(([b, q]) => a < b && meet(p, q)).map(([b]) => a + " " + b));
}"""

# Where the newest message lies, and where the bar begins [px].
NOTE = """() => {
  const { left, right, bottom } = document.querySelector("#notes div:last-child").getBoundingClientRect();
  return [left, right, bottom, document.getElementById("bar").getBoundingClientRect().top];
}"""

# What modules of the page reckon: percent of shares, colours of maps, sizes of pictures.
RECKONED = """async () => {
  const { percents } = await import("/page/controls/bar.js");
  const { MAPS, mapStops } = await import("/page/draw/maps.js");
  const size = ([wide, high]) => { const c = neve.camera.toCommand(wide, high); return [c.width, c.height]; };
  return {
    percents: [[1, 1, 1], [0.005, 0.995], [0.125, 0.125, 0.75], [0.014, 0.034, 0.952]].map(percents),
    maps: MAPS.map((name) => mapStops(name)),
    sizes: [[1920, 1080], [3840, 2160]].map(size),
  };
}"""


def shown_value(page, path):
    """The value at `path` in the panel that the page was told last."""
    section, name = path.rsplit(".", 1)
    fields = f"neve.scene.panel.find((s) => s.path === '{section}').fields"
    return page.evaluate(f"() => {fields}.find((f) => f.name === '{name}').value")


def lightness(srgb):
    """OKLab's lightness (Ottosson 2020) of colours, (n, 3) in 0..1."""
    linear = np.where(srgb <= 0.04045, srgb / 12.92, ((srgb + 0.055) / 1.055) ** 2.4)
    cones = np.array(
        [
            [0.4122214708, 0.5363325363, 0.0514459929],
            [0.2119034982, 0.6806995451, 0.1073969566],
            [0.0883024619, 0.2817188376, 0.6299787005],
        ]
    )
    return np.cbrt(linear @ cones.T) @ [0.2104542553, 0.7936177850, -0.0040720468]


def put(page, path, text):
    """Type a value into the panel."""
    box = page.locator(f'[data-path="{path}"] input').first
    box.fill(text)
    box.press("Enter")


def test_nothing_lies_under_anything_at_any_size(page, unseen):
    """Figures, legend, tools, panel and bar never cover each other, messages are above, the panel closes."""
    page.select_option("#mode", "speed")
    page.wait_for_selector("#legend:not([hidden])")
    for width, height in SIZES:
        page.set_viewport_size({"width": width, "height": height})
        page.evaluate("() => { neve.panel.root.hidden = innerWidth < 720 }")
        assert page.evaluate(COVERED) == [], (width, height)
        page.evaluate("() => { neve.panel.root.hidden = false }")
        page.click("#panel .close")
        assert page.is_hidden("#panel")
        button = page.locator("#bar button", has_text="panel").bounding_box()
        assert button["x"] + button["width"] <= width
        page.evaluate("() => neve.hear({ kind: 'note', sentence: 'snow lies here' })")
        left, right, bottom, bar = page.evaluate(NOTE)
        assert left >= 0
        assert right <= width
        assert bottom <= bar
        page.evaluate("() => { neve.panel.root.hidden = innerWidth < 720 }")
    page.set_viewport_size({"width": 1280, "height": 800})
    page.locator("[data-section='world'] > summary").click()
    put(page, "world.gravity", "-0.1234567")
    assert page.evaluate(
        "() => [...document.querySelectorAll('[data-path=\"world.gravity\"] input')]"
        ".every((e) => e.scrollWidth <= e.clientWidth)"
    )


def test_what_the_page_reckons(page, unseen):
    """Shares add up to 100 %; maps rise evenly in OKLab's lightness; pictures are as large as asked for."""
    found = page.evaluate(RECKONED)
    assert [sum(percents) for percents in found["percents"]] == [100] * 4
    assert found["percents"][1:3] == [[1, 99], [13, 12, 75]]
    assert found["sizes"] == [[1920, 1080], [3840, 2160]]
    assert len(found["maps"]) == 4
    for stops in found["maps"]:
        light = lightness(np.array(stops) / 255.0)
        even = np.linspace(light[0], light[-1], len(light))
        # Colours are rounded to 1/255, and lightness rises about as fast as the numbers of a screen.
        assert np.abs(light - even).max() < 0.004
        assert light[-1] - light[0] > 0.7


def test_values_wait_or_are_refused_where_they_stand(page, unseen):
    """A dx that waits changes nothing that is seen; a refusal goes when a good value comes."""
    page.locator("[data-section='numerics'] > summary").click()
    spacing = page.evaluate("() => [neve.scene.dx, neve.scene.spacing, neve.scene.cell, neve.tools.radius()]")
    put(page, "numerics.dx", "0.05")
    page.wait_for_selector('[data-path="numerics.dx"] .pending')
    assert page.inner_text('[data-path="numerics.dx"] .pending') == "0.1 → 0.05 at restart (r)"
    assert shown_value(page, "numerics.dx") == 0.05
    after = page.evaluate("() => [neve.scene.dx, neve.scene.spacing, neve.scene.cell, neve.tools.radius()]")
    assert after == spacing
    put(page, "numerics.dx", "-1")
    page.wait_for_selector(".wrong-text")
    assert page.locator("#notes").inner_text() == ""
    put(page, "numerics.dx", "0.06")
    until(page, "() => !document.querySelector('.wrong-text, .row.wrong')", "the refusal is gone")
    box = page.locator('[data-path="numerics.dx"] input')
    box.fill("1e-4")
    page.evaluate("() => neve.setScene(neve.scene)")  # the server answers while the next value is being typed
    assert box.input_value() == "1e-4"
    box.press("Enter")
    until(page, "() => document.querySelector('.pending').textContent.includes('0.0001')", "it is told")
    page.evaluate("() => neve.send({ do: 'restart' })")
    page.wait_for_selector('[data-path="numerics.dx"].wrong')
    assert "too many" in page.inner_text(".wrong-text") or "particles" in page.inner_text(".wrong-text")
    assert page.evaluate("() => neve.scene.dx") == 0.1


def test_new_things_stand_where_their_ghost_was_and_can_be_taken_back(page, live):
    """A box is offered first and stands on the surface; Ctrl Z, Ctrl Y, Delete and Esc are as elsewhere."""
    page.locator("[data-section='add'] > summary").click()
    before = look(page)
    page.click("[data-add='colliders']")
    ghost = page.evaluate("() => [neve.placing.ghost.what.shape, neve.placing.ghost.at]")
    assert ghost[0] == "box"
    assert changed_pixels(before, look(page)) > 0.002
    page.keyboard.press("Escape")
    assert page.evaluate("() => neve.placing.ghost") is None
    page.evaluate("() => { neve.camera.target = [0.2, 2.5, 0]; neve.redraw() }")
    drawn(page)
    page.click("[data-add='colliders']")
    at = page.evaluate("() => neve.placing.ghost.at")
    page.keyboard.press("Enter")
    until(page, "() => neve.scene.solids.length === 3", "the box is there")
    box = live.player.scene.colliders[2]
    assert box.shape == "box"
    assert np.allclose([*box.center[:2], box.center[2] - 0.5 * box.size[2]], at)
    page.keyboard.press("Control+z")
    until(page, "() => neve.scene.solids.length === 2", "it is taken back")
    assert "new box" in page.locator("button[title^='Do again']").get_attribute("title")
    page.keyboard.press("Control+y")
    until(page, "() => neve.scene.solids.length === 3", "it is done again")
    page.evaluate("() => { neve.tools.choose('move'); neve.select('colliders.2') }")
    page.keyboard.press("Delete")
    until(page, "() => neve.scene.solids.length === 2", "it is deleted")
    page.keyboard.press("?")
    assert "Delete" in page.inner_text("#help")
    page.keyboard.press("Escape")
    assert page.is_hidden("#help")


def test_snow_that_would_overlap_snow_lies_on_top(page, unseen):
    """It is told, and put above the highest particle in its way: 0.8 m, the top of the ball."""
    page.evaluate("() => neve.send({ do: 'add', kind: 'sources', shape: 'box', at: [0, 0, 0.5] })")
    until(page, "() => neve.scene.panel.some((s) => s.path === 'sources.1')", "the snow is there")
    source = unseen.player.scene.sources[1]
    assert source.center[2] - 0.5 * source.size[2] == pytest.approx(0.8, abs=0.06)
    assert "on top" in page.inner_text("#notes")


def test_colours_are_chosen_by_hand(page, live):
    """Ends, powers and map are what the legend shows, and what is under the pointer is said."""
    page.evaluate("() => neve.setQuality(0)")
    for frame in (1, 2, 3):
        page.evaluate("() => neve.send({ do: 'frame' })")
        until(page, f"() => neve.state.frame === {frame}", "the ball falls")
    page.select_option("#mode", "speed")
    until(page, "() => neve.state.mode === 'speed'", "speed is shown")
    until(page, "() => neve.bar.legend.counts.some(Boolean)", "values are counted")
    first = look(page)
    low, high = (
        page.locator("[aria-label='value of the first colour']"),
        page.locator("[aria-label='value of the last colour']"),
    )
    low.fill("0.5")
    high.fill("4")
    high.press("Enter")
    high.blur()
    until(page, "() => neve.state.limits[1] === 4 && neve.state.limits[0] === 0.5", "the ends are taken")
    page.check("#log")
    until(page, "() => neve.state.log", "powers are taken")
    middle = page.locator("#legend .ends span").nth(1).inner_text()
    assert float(middle) == pytest.approx((0.5 * 4) ** 0.5, rel=0.01)
    page.select_option("#map", "ember")
    assert changed_pixels(first, look(page)) > 0.01
    x, y, _ = page.evaluate("() => neve.camera.project(neve.stage.snow.middle())")
    size = page.viewport_size
    page.mouse.move(x * size["width"], y * size["height"])
    until(page, "() => document.getElementById('probe').textContent.includes('m/s')", "it is said")
    told = page.inner_text("#probe").splitlines()[0]
    speed = float(np.linalg.norm(live.player._sim.state.v, axis=1).mean())
    assert float(told.split()[1]) == pytest.approx(speed, rel=0.05)  # all of it falls alike


def test_a_cut_opens_the_snow_and_a_length_is_measured(page, live):
    """A plane takes half of the ball away; a click on each end of the box's upper edge gives its 0.6 m."""
    before = look(page)
    page.select_option("#cut", "x")
    assert changed_pixels(before, look(page)) > 0.005
    assert page.evaluate("() => neve.stage.clip.normal") == [1, 0, 0]
    page.select_option("#cut", "no cut")
    page.evaluate("() => { neve.measure.click([1, 0, 0]); neve.measure.click([1, 0.6, 0]) }")
    assert page.evaluate("() => neve.measure.text()").startswith("0.6 m")
    page.evaluate("() => neve.tools.choose('push')")
    radius = page.evaluate("() => neve.tools.radius()")
    page.mouse.move(300, 200)
    page.keyboard.down("Shift")
    page.mouse.wheel(0, -300)
    page.keyboard.up("Shift")
    until(page, f"() => neve.tools.radius() > 1.2 * {radius}", "the brush is larger")
    page.evaluate("() => neve.tools.choose('throw')")
    page.keyboard.down("Alt")
    page.mouse.wheel(0, -300)
    page.keyboard.up("Alt")
    until(page, "() => neve.tools.speed > 12.5", "balls fly faster")


def test_two_fingers_apart_come_closer(page, unseen):
    """Twice as far apart, half as far away."""
    far = page.evaluate("() => neve.camera.distance")
    touch = """(pairs) => {
      const at = (id, x, kind) => neve.canvas.dispatchEvent(new PointerEvent(kind, {
        pointerId: id, pointerType: 'touch', clientX: x, clientY: 200, button: 0, buttons: 1 }));
      at(11, 200, 'pointerdown'); at(12, 300, 'pointerdown'); at(12, 400, 'pointermove');
      at(11, 200, 'pointerup'); at(12, 400, 'pointerup');
    }"""
    page.evaluate(touch, [])
    assert page.evaluate("() => neve.camera.distance") == pytest.approx(far / 2, rel=1e-6)


def test_a_lost_graphics_card_comes_back(page, live):
    """After the context is lost and given back the same picture is drawn without loading the page again."""
    before = look(page)
    page.evaluate(
        "() => { window.card = neve.stage.gl.getExtension('WEBGL_lose_context'); card.loseContext() }"
    )
    until(page, "() => neve.stage.gl.isContextLost() && neve.lostCard", "it is lost, and said")
    page.evaluate("() => card.restoreContext()")
    until(page, "() => !neve.lostCard", "it is back")
    assert changed_pixels(before, look(page)) < 0.002
