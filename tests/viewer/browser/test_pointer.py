"""Pointer and keys in the page: what they do to snow and camera."""

import numpy as np
from viewer.browser.chromium import HEIGHT, WIDTH, until

KEYS = {
    "w": ("forward", 1),
    "s": ("forward", -1),
    "d": ("right", 1),
    "a": ("right", -1),
    "e": ("z", 1),
    "q": ("z", -1),
}


def along(page, axis, before):
    """How far the camera's target has gone along an axis of the picture, or up [m]."""
    target, forward, right = page.evaluate(
        "() => [neve.camera.target, neve.camera.forward, neve.camera.right]"
    )
    ways = {"forward": [*forward[:2], 0.0], "right": right, "z": [0.0, 0.0, 1.0]}
    return float(np.dot(np.subtract(target, before), ways[axis]))


def test_keys_fly_the_camera_while_they_are_held(page, unseen):
    """Each key, held, moves the target its way and not across it; let go, the camera stands."""
    for key, (axis, sign) in KEYS.items():
        before = page.evaluate("() => neve.camera.target")
        page.keyboard.down(key)
        until(
            page,
            f"() => Math.hypot(...neve.camera.target.map((v, i) => v - {before}[i])) > 0.02",
            f"{key} flies",
        )
        page.keyboard.up(key)
        gone = sign * along(page, axis, before)
        moved = np.linalg.norm(np.subtract(page.evaluate("() => neve.camera.target"), before))
        assert gone > 0.0
        if axis != "forward":  # along the ground, which the axis is not
            assert np.isclose(gone, moved, rtol=1e-6), key
    still = page.evaluate("() => neve.camera.target")
    drawn = page.evaluate("() => { neve.redraw(); return neve.drawn }")
    until(page, f"() => neve.drawn > {drawn}", "another picture is drawn")
    assert page.evaluate("() => neve.camera.target") == still
    page.locator('[data-path="snow.E0"] input').press("w")  # a letter that is typed flies nothing
    assert page.evaluate("() => neve.camera.keys.size") == 0


def test_views_stand_around_the_snow(page, unseen):
    """Front is where the scene's camera stands, side a quarter turn from it, back half of one."""
    home = np.subtract(*page.evaluate("() => [neve.scene.camera.position, neve.scene.camera.target]"))[:2]
    expected = {"front": 0.0, "side": 90.0, "back": 180.0}
    for name, degrees in expected.items():
        page.locator(".views button", has_text=name).click()
        until(page, "() => !neve.dirty", "it is drawn")
        back = -np.array(page.evaluate("() => neve.camera.forward"))[:2]
        turn = np.degrees(np.arctan2(home[0] * back[1] - home[1] * back[0], home @ back))
        assert np.isclose(abs(turn), degrees, atol=1e-6), name
        x, y, _ = page.evaluate("() => neve.camera.project(neve.stage.snow.middle())")
        assert abs(y - 0.5) < 1e-6
        assert abs(x - page.evaluate("() => 0.5 - 0.5 * neve.camera.covered")) < 1e-6


def test_a_push_moves_snow_the_way_of_the_pointer(page, unseen):
    """Dragged to the right through the ball, the brush gives snow a velocity to the right of the picture."""
    page.keyboard.press("3")
    page.evaluate("() => neve.send({ do: 'speed', factor: 0.02 })")  # it does not fall far meanwhile
    page.click("#play")
    right = np.array(page.evaluate("() => neve.camera.right"))
    x, y, _ = page.evaluate("() => neve.camera.project(neve.stage.snow.middle())")
    at = (x * WIDTH, y * HEIGHT)
    fastest = 0.0
    for _ in range(40):
        page.mouse.move(at[0] - 40, at[1])
        page.mouse.down()
        page.mouse.move(at[0] + 40, at[1], steps=8)
        page.mouse.up()
        fastest = max(fastest, float((np.asarray(unseen.player._sim.state.v) @ right).max()))
        if fastest > 0.3:
            break
    page.click("#play")
    assert fastest > 0.3  # gravity alone moves nothing sideways
    assert page.evaluate("() => neve.tools.held") is None


def test_the_length_between_two_clicks_is_said_at_once(page, unseen):
    """The label says what lies between both clicks without another move of the pointer; rounding is 0."""
    page.evaluate("() => { neve.panel.root.hidden = true; neve.tools.choose('measure') }")
    page.mouse.click(250, 300)
    page.mouse.click(420, 320)
    length = page.evaluate("() => neve.measure.text()")
    assert float(length.split()[0]) > 0.1
    assert page.inner_text("#probe").splitlines()[0] == length
    page.mouse.move(300, 310)
    page.mouse.click(300, 310)  # another length begins
    page.mouse.move(330, 310)
    page.mouse.move(390, 310)  # too soon for another look: it follows by itself
    until(
        page,
        "() => document.getElementById('probe').innerText.split('\\n')[0] === neve.measure.text()",
        "it is said where the pointer rests",
    )
    page.keyboard.press("Escape")
    page.evaluate("() => { neve.measure.click([0, 0, 0]); neve.measure.click([1, 1e-16, 0]) }")
    assert page.evaluate("() => neve.measure.text()") == "1 m (1, 0, 0)"


def test_a_length_measured_by_taps_stays_to_be_read(page, unseen):
    """A finger has no hover and leaves when it is lifted; another tool takes the label away."""
    page.evaluate("() => neve.tools.choose('measure')")
    for x in (250, 420):
        page.evaluate(
            """(x) => { for (const kind of ['pointerdown', 'pointerup', 'pointerleave'])
              neve.canvas.dispatchEvent(new PointerEvent(kind,
                { pointerId: 7, pointerType: 'touch', clientX: x, clientY: 300, button: 0 })) }""",
            x,
        )
    assert page.inner_text("#probe").splitlines()[0] == page.evaluate("() => neve.measure.text()")
    page.evaluate("() => neve.tools.choose('look')")
    assert page.evaluate("() => document.getElementById('probe').hidden")
