"""A plane that cuts the scene open."""

import io

import numpy as np
from PIL import Image
from viewer.browser.chromium import changed_pixels, drawn, on_screen

# Cut away all that lies farther than `at` along y, or along -y.
CUT = """([way, at]) => {
  neve.stage.setClip({ normal: [0, way, 0], at: way * at });
  neve.redraw();
}"""


def _seen(page):
    """What the page shows without its panel."""
    drawn(page)
    return np.asarray(Image.open(io.BytesIO(page.screenshot())).convert("RGB"), np.int16)


def test_a_plane_that_meets_nothing_changes_nothing(page, live):
    """Ball and box span -0.3 m to 0.3 m along y; the camera is at -2.5 m."""
    page.evaluate("() => neve.togglePanel()")
    whole = _seen(page)[90:380, 200:]
    for way, at in ((-1, -0.4), (1, 0.4)):
        page.evaluate(CUT, [way, at])
        assert changed_pixels(whole, _seen(page)[90:380, 200:]) < 0.002


def test_a_solid_that_is_cut_has_a_cap_without_holes(page, live):
    """It is one even face of the colour of the box, 0.3 m wide and 0.6 m high; about it is none."""
    page.evaluate("() => neve.togglePanel()")
    page.evaluate(CUT, [-1, 0.1])
    picture = _seen(page)

    def seen(x, z):
        across, down = on_screen(page, f"[{x}, 0.1, {z}]")
        return picture[round(down), round(across)]

    inside = np.array([seen(x, z) for x in np.linspace(0.78, 1.02, 7) for z in np.linspace(0.05, 0.55, 9)])
    assert (inside[:, 0] > 1.4 * inside[:, 1]).all()  # red
    assert np.ptp(inside, axis=0).max() < 40  # light falls off a little; a wall behind it has another light
    outside = np.array([seen(0.7, 0.3), seen(1.1, 0.3), seen(0.9, 0.66)])
    assert (outside[:, 0] < 1.2 * outside[:, 1]).all()
    # The pointer finds the cap, not the half before it that is cut away.
    solid, point = page.evaluate(
        """() => {
          const { solid, point } = neve.tools.hit(...neve.camera.project([0.9, 0.1, 0.3]).slice(0, 2));
          return [solid, point];
        }"""
    )
    assert solid == "colliders.1"
    assert np.allclose(point, [0.9, 0.1, 0.3], atol=2e-3)
